// Spring-damper between two points: force on body 2 in W, f = -K Phi - D Phi' + f_actuator, the opposite on body 1,
// with Phi = p_2 - p_1 (PointCoincidence) and diagonal K, D. Its share of r = M vdot + g + B^T lambda is -B^T f.
#pragma once

#include "multibody/definition.h"
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

  void evaluate(const BodyKinematics& k1, const BodyKinematics& k2, SpringDamperEvaluation& e) const {
    e.phi = points.gap(k1, k2);
    points.gradient_1(k1, 0, e.B[0]);
    points.gradient_2(k2, 0, e.B[1]);
    e.phidot = k2.v_WB + e.B[1].rightCols<3>() * k2.w_WB_B - k1.v_WB + e.B[0].rightCols<3>() * k1.w_WB_B;
  }
  // Without the actuator [N].
  Vector3d force(const SpringDamperEvaluation& e) const {
    return -stiffness.cwiseProduct(e.phi) - damping.cwiseProduct(e.phidot);
  }
  // [J]
  double energy(const SpringDamperEvaluation& e) const { return 0.5 * e.phi.dot(stiffness.cwiseProduct(e.phi)); }
  // K_ij += B_i^T (K B_j + D Z_j) - d(B_i^T f)/d(motion) at constant f, C_ij += B_i^T D B_j.
  void linearize(const BodyKinematics& k1, const BodyKinematics& k2, const Vector3d& total_force,
                 SpringDamperEvaluation& e, const PairBlocks& K, const PairBlocks& C) const {
    points.rate_1(k1, 0, e.Z[0]);
    points.rate_2(k2, 0, e.Z[1]);
    points.stiffness(k1, k2, -total_force, K);
    for (int j = 0; j < 2; ++j) {
      if (!K.block[j][j]) continue;  // the ground
      const Eigen::Matrix<double, 3, 6> DB = damping.asDiagonal() * e.B[j];
      const Eigen::Matrix<double, 3, 6> KB = stiffness.asDiagonal() * e.B[j];
      const Eigen::Matrix<double, 3, 6> DZ = damping.asDiagonal() * e.Z[j];
      for (int i = 0; i < 2; ++i) {
        if (!K.block[i][j]) continue;
        const Eigen::Matrix<double, 6, 3> Bt = e.B[i].transpose();
        K.block[i][j]->noalias() += Bt * (KB + DZ);
        C.block[i][j]->noalias() += Bt * DB;
      }
    }
  }
};

}  // namespace sigmafmu
