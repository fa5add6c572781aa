#include "multibody/forces/joint_friction.h"

#include <cmath>

namespace sigmafmu {

const std::vector<ForcePort>& JointFriction::ports() const {
  static const std::vector<ForcePort> torque = {
      {"frictionTorque", 0, "Torque", "Torque of the joint's friction on the second body", output},
      {"frictionPower", 0, "Power", "Power of the joint's friction on the bodies", power_output}};
  static const std::vector<ForcePort> force = {
      {"frictionForce", 0, "Force", "Force of the joint's friction on the second body", output},
      {"frictionPower", 0, "Power", "Power of the joint's friction on the bodies", power_output}};
  return is_angle() ? torque : force;
}

CoordinateForce::Law JointFriction::law(double, double rate) const {
  const double direction = std::tanh(rate / d_.creep_rate), x = rate / d_.stribeck_rate;
  const double at_low_rates = d_.stribeck_friction * std::exp(-x * x);
  const double size = d_.friction + at_low_rates, by_rate = -2 * x / d_.stribeck_rate * at_low_rates;
  return {-size * direction - d_.viscous_friction * rate, 0,
          -by_rate * direction - size * (1 - direction * direction) / d_.creep_rate - d_.viscous_friction};
}

}  // namespace sigmafmu
