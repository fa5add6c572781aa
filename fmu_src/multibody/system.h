// Assembles the equations of motion of a multibody system, block by block:
//
//   r(q, v, vdot, lambda, u) = M vdot + g(q, v, u) + B(q)^T lambda = 0,   Phi(q) = 0,   Phi' = B v = 0
//
// (Holzinger, Arnold, Gerstmayr 2025, Eqs. 1-4). System is immutable while it is evaluated; all results go into an
// Evaluation, so one System may serve several of them. Nothing here allocates after make_evaluation().
//
// For n bodies q has the 7 n positions of their frames, then all modal coordinates, v the 6 n velocities of the frames,
// then all modal rates, flexible body after flexible body. lambda has constraint_size() entries, joint after joint; u
// has input_size().
//
// Nodes of the linearized equations are the frames of the bodies, then the modes of each flexible body, then the
// joints. All that couples frames alone has blocks of fixed size; blocks with modes are kept apart.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "multibody/bodies/flexible_body.h"
#include "multibody/bodies/node_frame.h"
#include "multibody/bodies/rigid_body.h"
#include "multibody/forces/spring_damper.h"
#include "multibody/joints/joint.h"

namespace sigmafmu {

using Eigen::VectorXd;

// Where the nonzero blocks of the linearized equations are; fixed when the System is built. Solvers need only this.
struct BlockPattern {
  struct Incidence {
    int joint, body, side;  // side 0: the joint's body 1, side 1: its body 2
  };
  std::vector<int> body_sizes;                  // velocities of each body's frame
  std::vector<int> modal_sizes;                 // modes of each flexible body
  std::vector<int> joint_sizes;                 // equations of each joint
  std::vector<std::pair<int, int>> body_pairs;  // (i, j) blocks of M, C, K; the first n are (i, i)
  std::vector<Incidence> incidences;            // blocks of B and Z

  // Blocks with modes: (i, j) nodes of C and K. The first 3 f are, for each flexible body, (frame, modes), (modes,
  // frame) and (modes, modes), those of M.
  std::vector<std::pair<int, int>> modal_pairs;
  std::vector<Incidence> modal_incidences;  // joints at a node; `body` counts flexible bodies

  int modal_node(int flexible) const { return static_cast<int>(body_sizes.size()) + flexible; }
  int joint_node(int joint) const { return static_cast<int>(body_sizes.size() + modal_sizes.size()) + joint; }
};

// m equations by the modes of a flexible body.
struct ModalRows {
  MatrixXd B, Z;
};

struct Evaluation {
  std::vector<BodyKinematics> bodies;  // then the ground, then the frames in nodes
  std::vector<JointEvaluation> joints;
  std::vector<SpringDamperEvaluation> spring_dampers;
  std::vector<Matrix6d> C, K;  // by index into BlockPattern::body_pairs: dr/dv, dr/d(motion)

  std::vector<FlexibleEvaluation> flexible;              // of each flexible body, with the blocks of M for its frame
  std::vector<MatrixXd> modal_M;                         // by index into BlockPattern::modal_pairs, the first 3 f
  std::vector<MatrixXd> modal_C, modal_K;                // by index into BlockPattern::modal_pairs
  std::vector<ModalRows> modal_joints;                   // by index into BlockPattern::modal_incidences
  std::vector<NodeFrameEvaluation> node_frames;          // the first one is that of all frames in no node
  std::vector<std::array<JointRows, 2>> node_gradients;  // B of the joints at nodes, in the frames they attach to
  Matrix6Xd work;
};

class System {
 public:
  explicit System(const MultibodyDef& definition);
  // Takes over every value that is no geometry: masses, inertias, gravity, spring-dampers, loads, modal damping.
  void set_values(const MultibodyDef& definition);

  int body_count() const { return body_count_; }
  int position_size() const { return kPositionsPerBody * body_count() + modal_count_; }
  int velocity_size() const { return kVelocitiesPerBody * body_count() + modal_count_; }
  int constraint_size() const { return constraint_size_; }
  int input_size() const { return input_size_; }
  double size() const { return size_; }  // of the mechanism [m]
  const BlockPattern& pattern() const { return pattern_; }
  // Mass and inertia of a rigid body; zero for a flexible one, whose inertia Evaluation::flexible and modal_M hold.
  const RigidBody& body(int i) const { return bodies_[i]; }
  const Joint& joint(int j) const { return joints_[j]; }
  const SpringDamper& spring_damper(int s) const { return spring_dampers_[s]; }
  int joint_count() const { return static_cast<int>(joints_.size()); }
  int spring_damper_count() const { return static_cast<int>(spring_dampers_.size()); }

  // Flexible bodies in the order of the bodies: which of them body i is (-1: rigid) and what they are.
  int flexible_count() const { return static_cast<int>(flexible_.size()); }
  int flexible_index(int body) const { return flexible_index_[body]; }
  int flexible_body(int flexible) const { return flexible_bodies_[flexible]; }
  const FlexibleBody& flexible(int flexible) const { return flexible_[flexible]; }
  // Modal coordinates of all bodies, of one (0: rigid) and, for a flexible body, where they start among all.
  int modal_count() const { return modal_count_; }
  int modes(int body) const { return flexible_index_[body] < 0 ? 0 : flexible_[flexible_index_[body]].modes(); }
  int modal_index(int body) const { return flexible_index_[body] < 0 ? -1 : modal_index_[flexible_index_[body]]; }
  // The same in q and in v, counted by flexible body.
  int modal_position(int flexible) const { return kPositionsPerBody * body_count() + modal_index_[flexible]; }
  int modal_velocity(int flexible) const { return kVelocitiesPerBody * body_count() + modal_index_[flexible]; }

  // First entry of each element in lambda and u. Inputs: body force (W) and torque (B); motor; actuator force (W).
  int lambda_index(int joint) const { return lambda_index_[joint]; }
  int force_index(int body) const { return 6 * body; }
  int motor_index(int joint) const { return motor_index_[joint]; }
  int actuator_index(int spring_damper) const { return actuator_index_[spring_damper]; }

  Evaluation make_evaluation() const;

  // 1. Kinematics, Phi, B, Phi' and spring-damper gaps at (q, v). All that follows uses them.
  void evaluate(const VectorXd& q, const VectorXd& v, Evaluation& e) const;
  // 2. r = M vdot + g + B^T lambda.
  void residual(const Evaluation& e, const VectorXd& vdot, const VectorXd& lambda, const VectorXd& u,
                VectorXd& r) const;
  // 3. Z of every joint.
  void constraint_rates(Evaluation& e) const;
  // 4. C and K, d(M vdot)/d(motion) included.
  void linearize(const VectorXd& vdot, const VectorXd& lambda, const VectorXd& u, Evaluation& e) const;
  // The same for rigid bodies alone. Their M is constant; its derivative vanishes on R^3 x SO(3) with the body frame in
  // the centre of mass.
  void linearize(const VectorXd& lambda, const VectorXd& u, Evaluation& e) const;

  // out = B^T mu at `e`; mu is laid out as lambda, `out` as v.
  void gradient_times(const Evaluation& e, const VectorXd& mu, VectorXd& out) const;
  // The angles of revolute joints in (-pi, pi]; and with their turns, a time h [s] after `angle`, as rates predict.
  void start_turns(const Evaluation& e, VectorXd& angle) const;
  void count_turns(const Evaluation& e, double h, VectorXd& angle) const;

  // Maxima over all equations [m or 1, m/s or 1/s].
  double position_residual(const Evaluation& e) const;
  double velocity_residual(const Evaluation& e) const;
  double kinetic_energy(const Evaluation& e) const;  // [J]
  // Gravity (zero at W's origin), springs and deformation [J].
  double potential_energy(const Evaluation& e) const;

  const BodyKinematics& kinematics(const Evaluation& e, int body) const {
    return e.bodies[body == kGround ? body_count() : body];
  }
  // The frame that a joint attaches to on side 0 or 1: a body, the ground or a node.
  const BodyKinematics& attachment(const Evaluation& e, int joint, int side) const {
    return e.bodies[joint_ends_[joint].side[side].frame];
  }
  // Force and torque on body 2 (the node, where it attaches to one), in W.
  Joint::Reaction reaction(const Evaluation& e, int joint, const double* lambda) const;
  std::vector<bool> bodies_in_joints() const;
  // Place of a flexible body's node in W [m].
  Vector3d node_position(const Evaluation& e, int body, int node) const;

 private:
  // One side of a joint or spring-damper: its body, its frame among Evaluation::bodies and Evaluation::node_frames (0:
  // the body's own frame).
  struct End {
    int body, frame, node_frame;
  };
  // Both, and where the blocks of their frames are in C and K (-1: nowhere).
  struct Ends {
    End side[2];
    int pair[2][2];
    bool at_node() const { return side[0].node_frame > 0 || side[1].node_frame > 0; }
  };
  struct NodeJoint {
    int joint;
    int modal_incidence[2];  // -1: that side is not at a node
  };
  // What an element between frames adds to r and its derivatives, by side, in the terms of node_frame.h.
  struct NodeElement;
  End make_end(int body, int node);
  Ends make_ends(const End& end1, const End& end2, bool coupled);
  int add_pair(int i, int j);

  // The parts of evaluate, residual, constraint_rates and linearize that flexible bodies and elements at nodes add.
  void evaluate_flexible(const VectorXd& q, const VectorXd& v, Evaluation& e) const;
  void evaluate_node_gradients(Evaluation& e) const;
  void evaluate_node_rates(Evaluation& e) const;
  void add_flexible_residual(const Evaluation& e, const VectorXd& vdot, const VectorXd& lambda, const VectorXd& u,
                             VectorXd& r) const;
  void linearize_at_nodes(const VectorXd& lambda, const VectorXd& u, Evaluation& e) const;
  void add_end_force(const Evaluation& e, const End& end, const Vector6d& f_N, VectorXd& r) const;
  void add_element(const Ends& ends, const NodeElement& element, Evaluation& e) const;
  FlexibleBody::Blocks flexible_blocks(std::vector<Matrix6d>& frames, std::vector<MatrixXd>& modal, int flexible) const;
  static PairBlocks blocks(std::vector<Matrix6d>& matrices, const Ends& ends);

  struct Load {
    int body = 0;
    Vector3d force = Vector3d::Zero(), torque = Vector3d::Zero();
  };
  std::vector<RigidBody> bodies_;
  std::vector<Joint> joints_;
  std::vector<SpringDamper> spring_dampers_;
  std::vector<Load> loads_;
  Vector3d gravity_;
  BlockPattern pattern_;
  // Nodes x nodes, bodies and modes: index into body_pairs or modal_pairs, -1 where there is no block.
  std::vector<int> pair_table_;
  int body_count_ = 0, nodes_ = 0;
  std::vector<Ends> joint_ends_, spring_ends_;
  std::vector<int> frame_joints_, frame_springs_;  // those that do not attach to a node
  std::vector<int> lambda_index_, motor_index_, actuator_index_;
  int constraint_size_ = 0, input_size_ = 0;
  double size_;

  std::vector<FlexibleBody> flexible_;
  std::vector<int> flexible_index_;                 // by body
  std::vector<int> flexible_bodies_, modal_index_;  // by flexible body
  int modal_count_ = 0;
  std::vector<NodeFrame> node_frames_;  // the first one is none
  std::vector<NodeJoint> node_joints_;
  std::vector<int> node_springs_;
};

}  // namespace sigmafmu
