#include "multibody/forces/torsion_spring.h"

#include <cmath>

#include "lie/isotropic_operator.h"

namespace sigmafmu {

const std::vector<ForcePort>& TorsionSpring::ports() const {
  static const std::vector<ForcePort> table = {
      {"angle", 0, "Angle", "Twist from the first frame to the second, in (-pi, pi]",
       [](const Force& f, const Kinematics& k, const Inputs&, double* x) {
         *x = twist(static_cast<const TorsionSpring&>(f).relative(k)).angle;
       }},
      {"angularRate", 0, "AngularVelocity", "Rate of the twist",
       [](const Force& f, const Kinematics& k, const Inputs&, double* x) {
         *x = twist(static_cast<const TorsionSpring&>(f).relative(k)).rate;
       }},
      {"torque", 0, "Torque", "Torque of spring and damper (actuator excluded) on the second body",
       [](const Force& f, const Kinematics& k, const Inputs&, double* x) {
         const auto& self = static_cast<const TorsionSpring&>(f);
         *x = self.torque(twist(self.relative(k)));
       }},
      {"energy", 0, "Energy", "Elastic energy", energy_output},
      {"power", 0, "Power", "Power of the element on its bodies", power_output, true},
      {"actuatorTorque", 0, "Torque", "Torque of an actuator about the axis on the second body", nullptr},
  };
  return table;
}

void TorsionSpring::set_values(const MultibodyDef& definition) {
  const TorsionSpringDef& d = definition.torsion_springs[index_];
  stiffness_ = d.stiffness;
  damping_ = d.damping;
  rest_ = d.rest;
}

TorsionSpring::Twist TorsionSpring::twist(const RelativeMotion& x) {
  const Vector3d z = x.Q.col(2), b = (z + Vector3d::UnitZ()) / (1 + z[2]);
  return {std::atan2(x.Q(1, 0) - x.Q(0, 1), x.Q(0, 0) + x.Q(1, 1)), b.dot(x.w), b, z};
}

double TorsionSpring::stored(const RelativeMotion& x) const {
  const double c = twist(x).angle - rest_;
  return 0.5 * stiffness_ * c * c;
}

Vector6d TorsionSpring::wrench(const RelativeMotion& x, const double* u) const {
  const Twist t = twist(x);
  Vector6d W;
  W << Vector3d::Zero(), (torque(t) + *u) * t.b;
  return W;
}

void TorsionSpring::derivatives(const RelativeMotion& x, const double* u, Matrix6d& by_motion,
                                Matrix6d& by_velocity) const {
  const Twist t = twist(x);
  Matrix3d across = Matrix3d::Identity();
  across.col(2) -= t.b;
  const Matrix3d b_turn = -across * lie::hat(t.z) / (1 + t.z[2]);
  by_motion.setZero();
  by_velocity.setZero();
  by_motion.bottomRightCorner<3, 3>() =
      (torque(t) + *u) * b_turn - t.b * (stiffness_ * t.b + damping_ * (b_turn.transpose() * x.w)).transpose();
  by_velocity.bottomRightCorner<3, 3>() = -damping_ * t.b * t.b.transpose();
}

}  // namespace sigmafmu
