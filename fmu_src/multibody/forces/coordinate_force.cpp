#include "multibody/forces/coordinate_force.h"

namespace sigmafmu {

void CoordinateForce::add(const Kinematics& k, const Inputs& u, const FrameForces& r) const {
  coordinate_.add_force(k, force(k, u), r);
}

void CoordinateForce::linearize(const Kinematics& k, const Inputs& u, const FramePairs& K, const FramePairs& C) const {
  const Law f = law(k, u);
  double b[12], z[12];
  const FrameRows B(b, 1), Z(z, 1);
  coordinate_.gradient(k, B);
  coordinate_.rates(k, Z);
  for (int j = 0; j < 2; ++j) {
    const Vector6d of_j = (f.by_value * B[j] + f.by_rate * Z[j]).transpose();
    for (int i = 0; i < 2; ++i) {
      if (!K.has(i, j)) continue;
      K(i, j).noalias() -= B[i].transpose() * of_j.transpose();
      C(i, j).noalias() -= (f.by_rate * B[i].transpose()) * B[j];
    }
  }
  coordinate_.stiffness(k, f.force, K);
}

}  // namespace sigmafmu
