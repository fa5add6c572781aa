// Assembles the equations of motion of a multibody system, block by block:
//
//   r(q, v, vdot, lambda, u) = M vdot + g(q, v, u) + B(q)^T lambda = 0,   Phi(q, t) = 0,   Phi' = B v + Phi_t = 0
//
// (Holzinger, Arnold, Gerstmayr 2025, Eqs. 1-4; they have no t). A System is a list of elements: bodies, constraints
// and forces, and the frames they attach to. It is immutable while it is evaluated; all results go into an Evaluation,
// so one System may serve several of them. Nothing here allocates after make_evaluation().
//
// For n bodies q has the 7 n positions of their frames, then all modal coordinates, v the 6 n velocities of the frames,
// then all modal rates, flexible body after flexible body. lambda has constraint_size() entries, constraint after
// constraint.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "multibody/bodies/flexible_body.h"
#include "multibody/bodies/rigid_body.h"
#include "multibody/constraints/compliance.h"
#include "multibody/constraints/coupling.h"
#include "multibody/constraints/joint.h"
#include "multibody/forces/force.h"
#include "multibody/forces/joint_armature.h"
#include "multibody/frame.h"
#include "multibody/moving_frame.h"
#include "multibody/pattern.h"

namespace sigmafmu {

struct Evaluation {
  std::vector<FrameKinematics> frames;         // of the bodies, the ground, what moves of it, the nodes
  VectorXd phi, phidot, W;                     // Phi, Phi' and d(Phi')/dt, laid out as lambda
  VectorXd B, Z;                               // by BlockPattern::Incidence::offset, among rows by frames
  VectorXd M, C, K;                            // by BlockPattern::Pair::offset; C = dr/dv, K = dr/d(motion)
  std::vector<Vector6d> moving_accelerations;  // of frames of the ground that move: (v', w')
  std::vector<FlexibleEvaluation> flexible;
  std::vector<NodeFrameEvaluation> node_frames;  // the first one is that of all frames at no node

  // Of one element between frames of which some are at nodes, and what else its pull-back needs.
  VectorXd frame_forces, frame_C, frame_K;
  Matrix6Xd work;
  Matrix6Xd by_motion, by_velocity;  // of a node's acceleration, where there are armatures
};

class System {
 public:
  explicit System(const MultibodyDef& definition, Compliance compliance = {});
  System(const System&) = delete;
  System& operator=(const System&) = delete;
  // Takes over what may change while the System is in use: gravity, damping of flexible bodies, values of forces.
  void set_values(const MultibodyDef& definition);

  int body_count() const { return body_count_; }
  int position_size() const { return kPositionsPerBody * body_count() + modal_count_; }
  int velocity_size() const { return kVelocitiesPerBody * body_count() + modal_count_; }
  int constraint_size() const { return constraint_size_; }
  int input_size() const { return input_size_; }
  int drive_count() const { return drive_count_; }
  // In Inputs::x are what drives prescribe, constants of couplings, then six numbers for each moving frame.
  int coupling_count() const { return static_cast<int>(couplings_.size()); }
  int prescribed_count() const {
    return drive_count() + coupling_count() + kPrescribedPerMotion * static_cast<int>(moving_frames_.size());
  }
  double size() const { return size_; }  // of the mechanism [m]
  const BlockPattern& pattern() const { return pattern_; }

  // A rigid body, or null for a flexible one.
  const RigidBody* rigid(int body) const { return rigid_index_[body] < 0 ? nullptr : &rigid_[rigid_index_[body]].body; }
  // Flexible bodies in the order of the bodies: which of them body i is (-1: rigid) and what they are.
  int flexible_count() const { return static_cast<int>(flexible_.size()); }
  int flexible_index(int body) const { return flexible_index_[body]; }
  int flexible_body(int flexible) const { return flexible_[flexible].index; }
  const FlexibleBody& flexible(int flexible) const { return flexible_[flexible].body; }
  // Modal coordinates of all bodies, of one (0: rigid) and, for a flexible body, where they start among all.
  int modal_count() const { return modal_count_; }
  int modes(int body) const { return flexible_index_[body] < 0 ? 0 : flexible(flexible_index_[body]).modes(); }
  int modal_index(int body) const {
    return flexible_index_[body] < 0 ? -1 : modal_velocity(flexible_index_[body]) - kVelocitiesPerBody * body_count();
  }
  // The same in q and in v, counted by flexible body.
  int modal_position(int flexible) const { return pattern_.unknowns[body_count_ + flexible].position; }
  int modal_velocity(int flexible) const { return pattern_.unknowns[body_count_ + flexible].velocity; }

  std::vector<bool> bodies_in_joints() const;
  int constraint_count() const { return static_cast<int>(constraints_.size()); }
  const Constraint& constraint(int c) const { return *constraints_[c].element; }
  int lambda_index(int constraint) const { return constraints_[constraint].first; }
  // Which of lambda belong to equations of velocities alone.
  const std::vector<int>& velocity_equations() const { return velocity_equations_; }
  // B := 0 for these, where positions are looked for.
  void clear_velocity_rows(Evaluation& e) const;
  // Joints are the first constraints.
  int joint_count() const { return static_cast<int>(joints_.size()); }
  const Joint& joint(int j) const { return *joints_[j]; }
  // Of constraints whose equations depend on each other.
  const Compliance& compliance() const { return compliance_; }
  // Then come the drives, then the couplings.
  int drive_lambda_index(int d) const { return lambda_index(joint_count() + d); }
  const Coupling& coupling(int c) const { return *couplings_[c]; }
  Kinematics coupling_kinematics(const Evaluation& e, int c) const {
    return kinematics(e, constraints_[joint_count() + drive_count() + c].at);
  }
  // What it takes to move frame m of the ground as prescribed: against all that holds to it.
  struct MovingLoad {
    Vector3d force, torque;  // in W; about the frame's origin
    double power;
  };
  MovingLoad moving_load(const Evaluation& e, int m, const VectorXd& vdot, const VectorXd& lambda,
                         const Inputs& u) const;
  bool axes_agree(const Evaluation& e, int joint) const;
  // Of a rolling disk: what touches the plane, in W [m]. The sine of the angle between disk and plane: at 0 no single
  // point touches (1 for other joints).
  Vector3d touching_point(const Evaluation& e, int joint) const;
  double tilt_of_disk(const Evaluation& e, int joint) const;
  // Force and torque on body 2 (the node, where it attaches to one), as ReactionDef has them.
  Joint::Reaction reaction(const Evaluation& e, int joint, const double* lambda) const;

  // Coordinates of joints, joint after joint.
  int coordinate_count() const { return static_cast<int>(coordinates_.size()); }
  const JointCoordinate& coordinate(int c) const { return coordinates_[c].coordinate; }
  // The first one of a joint; those of joint j + 1 follow.
  int coordinate_index(int joint) const { return coordinate_index_[joint]; }
  double coordinate_value(const Evaluation& e, int c) const;  // angles in (-pi, pi]
  double coordinate_rate(const Evaluation& e, int c) const;
  double coordinate_acceleration(const Evaluation& e, int c, const VectorXd& vdot) const;
  void coordinate_values(const Evaluation& e, VectorXd& coordinates) const;
  // From all coordinates a time h [s] before to those now: angles take the turn nearest to what their rates predict.
  void count_turns(const Evaluation& e, double h, VectorXd& coordinates) const;

  // First those of for_each_force_list, type after type, then a motor for each coordinate.
  int force_count() const { return static_cast<int>(forces_.size()); }
  const Force& force(int f) const { return *forces_[f].element; }
  Kinematics force_kinematics(const Evaluation& e, int f) const { return kinematics(e, forces_[f].at); }
  const Force& motor(int coordinate) const { return force(force_count() - coordinate_count() + coordinate); }
  // The force (W) and the torque (B) on a body in u.
  int force_index(int body) const { return 6 * body; }

  Evaluation make_evaluation() const;
  Inputs make_inputs() const { return {input_size(), prescribed_count(), coordinate_count()}; }
  InputSignal make_signal() const { return {input_size(), prescribed_count()}; }

  // 1. Kinematics, M, Phi, B and Phi' at (q, v) and what drives prescribe. All that follows uses them.
  void evaluate(const VectorXd& q, const VectorXd& v, const Inputs& u, Evaluation& e) const;
  // 2. r = M vdot + g + B^T lambda.
  void residual(Evaluation& e, const VectorXd& vdot, const VectorXd& lambda, const Inputs& u, VectorXd& r) const;
  // 3. Z and W of every constraint.
  void constraint_rates(const Inputs& u, Evaluation& e) const;
  // 4. C and K, d(M vdot)/d(motion) included.
  void linearize(const VectorXd& vdot, const VectorXd& lambda, const Inputs& u, Evaluation& e) const;

  // out := B^T lambda or out += B^T lambda.
  void gradient_times(const Evaluation& e, const VectorXd& lambda, VectorXd& out) const {
    out.setZero();
    add_gradient_times(e, lambda, out);
  }
  void add_gradient_times(const Evaluation& e, const VectorXd& lambda, VectorXd& out) const;
  // out -= rows v, the rows being B or Z of an evaluation.
  void subtract_rows_times(const VectorXd& rows, const double* v, VectorXd& out) const;

  // Maxima over all equations [m or 1, m/s or 1/s].
  double position_residual(const Evaluation& e) const { return largest(e.phi); }
  double velocity_residual(const Evaluation& e) const { return largest(e.phidot); }
  double kinetic_energy(const Evaluation& e) const;  // [J]
  // Gravity (zero at W's origin), springs and deformation [J].
  double potential_energy(const Evaluation& e, const Inputs& u) const;
  Stiffest stiffest() const;  // sums of all forces

  const FrameKinematics& kinematics(const Evaluation& e, int body) const {
    return e.frames[body == kGround ? body_count() : body];
  }
  // Place of a flexible body's node in W [m].
  Vector3d node_position(const Evaluation& e, int body, int node) const;

 private:
  // The frames of an element. Forces on them and blocks between them go straight into r, C and K, or, where a frame is
  // at a node, into Evaluation::frame_forces, frame_C and frame_K, from where they are pulled back onto the unknowns.
  struct Attachment {
    std::vector<int> frames;  // in Evaluation::frames
    bool at_node = false;
    std::vector<int> force, pair;  // offsets there, by frame and by frame and frame; -1: none
    // At a node: the columns of J of each frame that belong to one unknown.
    struct Part {
      int frame, unknown, first;
    };
    std::vector<Part> parts;
    std::vector<int> part_pair;  // offset in C and K, by part and part; -1: none
    int count() const { return static_cast<int>(frames.size()); }
  };
  struct Rigid {
    int index = 0;
    RigidBody body;
  };
  struct Flexible {
    int index = 0;
    FlexibleBody body;
  };
  struct AttachedConstraint {
    std::unique_ptr<Constraint> element;
    Attachment at;
    int first;  // equation
    int rows;   // offset of its rows in Evaluation::B and Z
  };
  struct AttachedForce {
    std::unique_ptr<Force> element;
    Attachment at;
  };
  // One of the forces, and a block of M that these change and that nothing else writes anew: of a rigid body with
  // itself, of the modes of a flexible one with themselves, or between two bodies.
  struct Armature {
    const JointArmature* element;
    int force;
  };
  struct ArmatureBlock {
    BlockPattern::Pair pair;
    const RigidBody* rigid;
    const FlexibleBody* modes;
  };
  struct AttachedCoordinate {
    JointCoordinate coordinate;
    Attachment at;
  };
  // Rows for a frame at a node, and those for pose and modes that they make. They are added to where other frames of
  // the constraint have the same unknowns, as those of a body's own frame are then.
  struct PulledRows {
    int frame, equations, rows, pose, modes;
    bool add_pose, add_modes;
  };
  // Rows of a constraint for a frame of the ground that moves.
  struct MovingRows {
    int moving, first, equations, rows;
  };
  // A force at a frame of the ground that moves. `offset`: 0 for each of its frames that is this one, else -1.
  struct MovingForce {
    int moving, force;
    std::vector<int> offset;
  };

  // Set-up.
  class Builder;

  Kinematics kinematics(const Evaluation& e, const Attachment& at) const { return {e.frames.data(), at.frames.data()}; }
  static FramePairs pairs(const Attachment& at, VectorXd& blocks, VectorXd& of_frames) {
    return {at.at_node ? of_frames.data() : blocks.data(), at.pair.data(), at.count()};
  }
  NodeFrameEvaluation& node_frame(Evaluation& e, int frame) const {
    return e.node_frames[frame < body_count_ ? 0 : frame - body_count_];
  }
  const NodeFrameEvaluation& node_frame(const Evaluation& e, int frame) const {
    return e.node_frames[frame < body_count_ ? 0 : frame - body_count_];
  }
  // What armatures have in M, r, K and C.
  void add_armature_masses(Evaluation& e) const;
  void add_armature_forces(Evaluation& e, const VectorXd& vdot, VectorXd& r) const;
  void linearize_armatures(const VectorXd& vdot, Evaluation& e) const;
  JointArmature::Accelerations accelerations(const Evaluation& e, const Attachment& at, const VectorXd& vdot) const;
  // Of v of a frame.
  Vector6d frame_acceleration(const Evaluation& e, int frame, const VectorXd& vdot) const;
  void move_frames(const Inputs& u, Evaluation& e) const;
  void add_explicit_rates(Evaluation& e) const;
  void pull_back_rows(Evaluation& e) const;
  void pull_back_rates(Evaluation& e) const;
  void pull_back_forces(const Attachment& at, const Evaluation& e, VectorXd& r) const;
  // Blocks of frames i and j of an element += J_i^T work.
  void add_pulled_back(const Attachment& at, const Evaluation& e, int i, int j, VectorXd& blocks) const;
  void pull_back_pairs(const Attachment& at, Evaluation& e) const;
  void pull_back_masses(const Attachment& at, Evaluation& e) const;
  void pull_back_accelerations(const Attachment& at, const VectorXd& vdot, Evaluation& e) const;
  FlexibleBody::Blocks flexible_blocks(VectorXd& blocks, int flexible) const;
  using RowMajorXd = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  static Eigen::Map<RowMajorXd> modal_rows(VectorXd& rows, int equations, int offset, Eigen::Index modes) {
    return {rows.data() + offset, equations, modes};
  }
  static Eigen::Map<const RowMajorXd> modal_rows(const VectorXd& rows, int equations, int offset, Eigen::Index modes) {
    return {rows.data() + offset, equations, modes};
  }
  static double largest(const VectorXd& x) { return x.size() > 0 ? x.lpNorm<Eigen::Infinity>() : 0.0; }

  int body_count_ = 0, modal_count_ = 0, constraint_size_ = 0, input_size_ = 0, drive_count_ = 0;
  double size_;
  Vector3d gravity_;
  BlockPattern pattern_;
  int rows_size_ = 0, blocks_size_ = 0, inertia_size_ = 0;  // of Evaluation::B, C and M

  std::vector<Rigid> rigid_;
  std::vector<Flexible> flexible_;
  std::vector<int> rigid_index_, flexible_index_;  // by body
  std::vector<NodeFrame> node_frames_;             // the first ones are the ground and its frames that move
  std::vector<AttachedConstraint> constraints_;
  std::vector<PulledRows> pulled_rows_;
  std::vector<int> velocity_equations_;
  struct VelocityRows {
    int offset, count;  // in Evaluation::B
  };
  std::vector<VelocityRows> velocity_rows_;
  std::vector<MovingFrame> moving_frames_;
  std::vector<MovingRows> moving_rows_;
  std::vector<MovingForce> moving_forces_;
  std::vector<const Coupling*> couplings_;
  std::vector<AttachedForce> forces_;
  std::vector<Armature> armatures_;
  std::vector<ArmatureBlock> armature_blocks_;
  std::vector<AttachedCoordinate> coordinates_;
  std::vector<int> coordinate_index_;
  std::vector<const Joint*> joints_;
  const Compliance compliance_;
};

}  // namespace sigmafmu
