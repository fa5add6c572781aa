#include "multibody/forces/spring_damper.h"

#include "multibody/joints/primitives_inline.h"

namespace sigmafmu {

void SpringDamper::evaluate(const BodyKinematics& k1, const BodyKinematics& k2, SpringDamperEvaluation& e) const {
  e.phi = points.gap(k1, k2);
  points.gradient_1(k1, 0, e.B[0]);
  points.gradient_2(k2, 0, e.B[1]);
  e.phidot = k2.v_WB + e.B[1].rightCols<3>() * k2.w_WB_B - k1.v_WB + e.B[0].rightCols<3>() * k1.w_WB_B;
}

Vector3d SpringDamper::force(const SpringDamperEvaluation& e) const {
  return -stiffness.cwiseProduct(e.phi) - damping.cwiseProduct(e.phidot);
}

double SpringDamper::energy(const SpringDamperEvaluation& e) const {
  return 0.5 * e.phi.dot(stiffness.cwiseProduct(e.phi));
}

void SpringDamper::linearize(const BodyKinematics& k1, const BodyKinematics& k2, const Vector3d& total_force,
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

}  // namespace sigmafmu
