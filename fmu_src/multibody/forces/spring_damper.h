// Spring-damper between two points: force on body 2 in W, f = -K Phi - D Phi' + f_actuator, the opposite on body 1,
// with Phi = p_2 - p_1 (PointCoincidence) and diagonal K, D. Its share of r = M vdot + g + B^T lambda is -B^T f.
#pragma once

#include "model/definition.h"
#include "multibody/joints/primitives.h"

namespace sigmafmu {

struct SpringDamperEvaluation {
  Vector3d phi, phidot;  // [m], [m/s]
  JointRows B[2] = {JointRows::Zero(3, 6), JointRows::Zero(3, 6)};
  JointRows Z[2] = {JointRows::Zero(3, 6), JointRows::Zero(3, 6)};
};

struct SpringDamper {
  int body1, body2;
  PointCoincidence points;
  Vector3d stiffness, damping;  // diagonals of K [N/m] and D [N s/m]

  void evaluate(const BodyKinematics& k1, const BodyKinematics& k2, SpringDamperEvaluation& e) const;
  // Without the actuator [N].
  Vector3d force(const SpringDamperEvaluation& e) const;
  // [J]
  double energy(const SpringDamperEvaluation& e) const;
  // K_ij += B_i^T (K B_j + D Z_j) - d(B_i^T f)/d(motion) at constant f, C_ij += B_i^T D B_j.
  void linearize(const BodyKinematics& k1, const BodyKinematics& k2, const Vector3d& total_force,
                 SpringDamperEvaluation& e, const PairBlocks& K, const PairBlocks& C) const;
};

}  // namespace sigmafmu
