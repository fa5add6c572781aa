// Assembles the equations of motion of a multibody system, block by block:
//
//   r(q, v, vdot, lambda, u) = M vdot + g(q, v, u) + B(q)^T lambda = 0,   Phi(q) = 0,   Phi' = B v = 0
//
// (Holzinger, Arnold, Gerstmayr 2025, Eqs. 1-4). System is immutable while it is evaluated; all results go into an
// Evaluation, so one System may serve several of them. Nothing here allocates after make_evaluation().
//
// Sizes for n bodies: q 7 n, v 6 n; lambda has constraint_size() entries, joint after joint; u has input_size().
#pragma once

#include <Eigen/Core>
#include <vector>

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
  std::vector<int> body_sizes;                  // velocities of each body
  std::vector<int> joint_sizes;                 // equations of each joint
  std::vector<std::pair<int, int>> body_pairs;  // (i, j) blocks of M, C, K; the first n are (i, i)
  std::vector<Incidence> incidences;            // blocks of B and Z
};

struct Evaluation {
  std::vector<BodyKinematics> bodies;  // the last one is the ground
  std::vector<JointEvaluation> joints;
  std::vector<SpringDamperEvaluation> spring_dampers;
  std::vector<Matrix6d> C, K;  // by index into BlockPattern::body_pairs: dr/dv, dr/d(motion)
};

class System {
 public:
  explicit System(const MultibodyDef& definition);
  // Takes over every value that is no geometry: masses, inertias, gravity, spring-dampers, loads.
  void set_values(const MultibodyDef& definition);

  int body_count() const { return static_cast<int>(bodies_.size()); }
  int position_size() const { return kPositionsPerBody * body_count(); }
  int velocity_size() const { return kVelocitiesPerBody * body_count(); }
  int constraint_size() const { return constraint_size_; }
  int input_size() const { return input_size_; }
  const BlockPattern& pattern() const { return pattern_; }
  const RigidBody& body(int i) const { return bodies_[i]; }
  const Joint& joint(int j) const { return joints_[j]; }
  const SpringDamper& spring_damper(int s) const { return spring_dampers_[s]; }
  int joint_count() const { return static_cast<int>(joints_.size()); }
  int spring_damper_count() const { return static_cast<int>(spring_dampers_.size()); }

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
  // 4. C and K. M is constant; its derivative vanishes on R^3 x SO(3) with the body frame in the centre of mass.
  void linearize(const VectorXd& lambda, const VectorXd& u, Evaluation& e) const;

  // Maxima over all equations [m or 1, m/s or 1/s].
  double position_residual(const Evaluation& e) const;
  double velocity_residual(const Evaluation& e) const;
  double kinetic_energy(const Evaluation& e) const;    // [J]
  double potential_energy(const Evaluation& e) const;  // gravity (zero at W's origin) and springs [J]

  const BodyKinematics& kinematics(const Evaluation& e, int body) const {
    return e.bodies[body == kGround ? body_count() : body];
  }

 private:
  PairBlocks blocks(std::vector<Matrix6d>& matrices, int body1, int body2) const;
  int pair_index(int i, int j) const;

  struct Load {
    int body;
    Vector3d force, torque;
  };
  std::vector<RigidBody> bodies_;
  std::vector<Joint> joints_;
  std::vector<SpringDamper> spring_dampers_;
  std::vector<Load> loads_;
  Vector3d gravity_;
  BlockPattern pattern_;
  std::vector<int> pair_table_;  // body_count x body_count, -1 where there is no block
  std::vector<int> lambda_index_, motor_index_, actuator_index_;
  int constraint_size_ = 0, input_size_ = 0;
};

}  // namespace sigmafmu
