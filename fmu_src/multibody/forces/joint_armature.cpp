#include "multibody/forces/joint_armature.h"

namespace sigmafmu {
namespace {

// A_ij += factor B_i^T X_j.
void add_products(double factor, const FrameRows& B, const FrameRows& X, const FramePairs& A) {
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      if (A.has(i, j)) A(i, j).noalias() += (factor * B[i].transpose()) * X[j];
    }
  }
}

}  // namespace

void JointArmature::add_mass(const Kinematics& k, const FramePairs& M) const {
  double b[12];
  const FrameRows B(b, 1);
  coordinate_.gradient(k, B);
  add_products(inertia_, B, B, M);
}

void JointArmature::add_inertial_force(const Kinematics& k, const Accelerations& a, const FrameForces& r) const {
  coordinate_.add_force(k, -inertia_ * coordinate_.acceleration(k, a.vdot1, a.vdot2), r);
}

void JointArmature::linearize(const Kinematics& k, const Accelerations& a, const FramePairs& K,
                              const FramePairs& C) const {
  double b[12], m[12], v[12];
  const FrameRows B(b, 1), by_motion(m, 1), by_velocity(v, 1);
  coordinate_.gradient(k, B);
  coordinate_.acceleration_derivatives(k, a.vdot1, a.vdot2, by_motion, by_velocity);
  add_products(inertia_, B, by_motion, K);
  add_products(inertia_, B, by_velocity, C);
  coordinate_.stiffness(k, -inertia_ * coordinate_.acceleration(k, a.vdot1, a.vdot2), K);
}

double JointArmature::kinetic_energy(const Kinematics& k) const {
  const double rate = coordinate_.rate(k);
  return 0.5 * inertia_ * rate * rate;
}

}  // namespace sigmafmu
