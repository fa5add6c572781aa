#include "multibody/forces/spring_damper.h"

#include "multibody/constraints/primitives_inline.h"

namespace sigmafmu {

SpringDamper::SpringDamper(const SpringDamperDef& d, int index)
    : index_(index), points_{d.point1, d.point2}, stiffness_(d.stiffness), damping_(d.damping) {}

void SpringDamper::set_values(const MultibodyDef& definition) {
  stiffness_ = definition.spring_dampers[index_].stiffness;
  damping_ = definition.spring_dampers[index_].damping;
}

void SpringDamper::gradient(const Kinematics& k, Rows3 (&B)[2]) const {
  points_.gradient_1(k[0], 0, Rows(B[0].data(), 3, 6));
  points_.gradient_2(k[1], 0, Rows(B[1].data(), 3, 6));
}

Vector3d SpringDamper::force(const Kinematics& k, const Rows3 (&B)[2]) const {
  const Vector3d phi = points_.gap(k[0], k[1]);
  const Vector3d phidot =
      k[1].v_WB + B[1].rightCols<3>() * k[1].w_WB_B - k[0].v_WB + B[0].rightCols<3>() * k[0].w_WB_B;
  return -stiffness_.cwiseProduct(phi) - damping_.cwiseProduct(phidot);
}

Vector3d SpringDamper::force(const Kinematics& k) const {
  Rows3 B[2];
  gradient(k, B);
  return force(k, B);
}

double SpringDamper::energy(const Kinematics& k) const {
  const Vector3d phi = points_.gap(k[0], k[1]);
  return 0.5 * phi.dot(stiffness_.cwiseProduct(phi));
}

void SpringDamper::add(const Kinematics& k, const double* u, const FrameForces& r) const {
  Rows3 B[2];
  gradient(k, B);
  const Vector3d f = force(k, B) + Vector3d(u[0], u[1], u[2]);
  for (int i = 0; i < 2; ++i) {
    if (r.has(i)) r[i].noalias() -= B[i].transpose() * f;
  }
}

void SpringDamper::linearize(const Kinematics& k, const double* u, const FramePairs& K, const FramePairs& C) const {
  Rows3 B[2], Z[2];
  gradient(k, B);
  points_.rate_1(k[0], 0, Rows(Z[0].data(), 3, 6));
  points_.rate_2(k[1], 0, Rows(Z[1].data(), 3, 6));
  const Vector3d f = force(k, B) + Vector3d(u[0], u[1], u[2]);
  points_.stiffness(k[0], k[1], -f, K);
  for (int j = 0; j < 2; ++j) {
    if (!K.has(j, j)) continue;  // the ground
    const Eigen::Matrix<double, 3, 6> DB = damping_.asDiagonal() * B[j];
    const Eigen::Matrix<double, 3, 6> KB = stiffness_.asDiagonal() * B[j];
    const Eigen::Matrix<double, 3, 6> DZ = damping_.asDiagonal() * Z[j];
    for (int i = 0; i < 2; ++i) {
      if (!K.has(i, j)) continue;
      const Eigen::Matrix<double, 6, 3> Bt = B[i].transpose();
      K(i, j).noalias() += Bt * (KB + DZ);
      C(i, j).noalias() += Bt * DB;
    }
  }
}

}  // namespace sigmafmu
