#include "multibody/forces/joint_spring.h"

namespace sigmafmu {

const std::vector<ForcePort>& JointSpring::ports() const {
  constexpr auto output = [](const Force& f, const Kinematics& k, const Inputs& u, double* x) {
    *x = static_cast<const JointSpring&>(f).force(k, u);
  };
  static const std::vector<ForcePort> torque = {
      {"springTorque", 0, "Torque", "Torque of the joint's spring and damper on the second body", output},
      {"springEnergy", 0, "Energy", "Elastic energy of the joint's spring", energy_output},
      {"springPower", 0, "Power", "Power of the joint's spring and damper on the bodies", power_output}};
  static const std::vector<ForcePort> force = {
      {"springForce", 0, "Force", "Force of the joint's spring and damper on the second body", output},
      {"springEnergy", 0, "Energy", "Elastic energy of the joint's spring", energy_output},
      {"springPower", 0, "Power", "Power of the joint's spring and damper on the bodies", power_output}};
  return coordinate_.is_angle() ? torque : force;
}

void JointSpring::set_values(const MultibodyDef& definition) {
  const JointSpringDef& d = definition.joint_springs[index_];
  stiffness_ = d.stiffness;
  damping_ = d.damping;
  rest_ = d.rest;
}

double JointSpring::extension(const Kinematics& k, const Inputs& u) const {
  return coordinate_.value_near(k, u.turned[c_]) - rest_;
}

double JointSpring::force(const Kinematics& k, const Inputs& u) const {
  return -stiffness_ * extension(k, u) - damping_ * coordinate_.rate(k);
}

double JointSpring::energy(const Kinematics& k, const Inputs& u) const {
  const double x = extension(k, u);
  return 0.5 * stiffness_ * x * x;
}

void JointSpring::add(const Kinematics& k, const Inputs& u, const FrameForces& r) const {
  coordinate_.add_force(k, force(k, u), r);
}

void JointSpring::linearize(const Kinematics& k, const Inputs& u, const FramePairs& K, const FramePairs& C) const {
  double b[12], z[12];
  const FrameRows B(b, 1), Z(z, 1);
  coordinate_.gradient(k, B);
  coordinate_.rates(k, Z);
  for (int j = 0; j < 2; ++j) {
    const Vector6d of_j = (stiffness_ * B[j] + damping_ * Z[j]).transpose();
    for (int i = 0; i < 2; ++i) {
      if (!K.has(i, j)) continue;
      K(i, j).noalias() += B[i].transpose() * of_j.transpose();
      C(i, j).noalias() += (damping_ * B[i].transpose()) * B[j];
    }
  }
  coordinate_.stiffness(k, force(k, u), K);
}

}  // namespace sigmafmu
