#include "multibody/forces/joint_stop.h"

#include <algorithm>
#include <cmath>

namespace sigmafmu {

const std::vector<ForcePort>& JointStop::ports() const {
  static const std::vector<ForcePort> torque = {
      {"stopTorque", 0, "Torque", "Torque of the joint's stops on the second body", output},
      {"stopEnergy", 0, "Energy", "Elastic energy of the joint's stops", energy_output},
      {"stopPower", 0, "Power", "Power of the joint's stops on the bodies", power_output}};
  static const std::vector<ForcePort> force = {
      {"stopForce", 0, "Force", "Force of the joint's stops on the second body", output},
      {"stopEnergy", 0, "Energy", "Elastic energy of the joint's stops", energy_output},
      {"stopPower", 0, "Power", "Power of the joint's stops on the bodies", power_output}};
  return is_angle() ? torque : force;
}

// Away from a stop.
CoordinateForce::Law JointStop::push(double depth, double rate) const {
  const double w = d_.depth;
  const double s = depth < w ? depth * depth / (2 * w) : depth - w / 2, s_depth = std::min(depth / w, 1.0);
  const double z = d_.damping * rate, root = std::sqrt(1 + z * z), g = 1 + z / root;
  return {d_.stiffness * s * g, d_.stiffness * s_depth * g, d_.stiffness * s * d_.damping / (root * root * root)};
}

CoordinateForce::Law JointStop::law(double value, double rate) const {
  if (value > d_.upper) {
    const Law f = push(value - d_.upper, rate);
    return {-f.force, -f.by_value, -f.by_rate};
  }
  if (value < d_.lower) {
    const Law f = push(d_.lower - value, -rate);
    return {f.force, -f.by_value, -f.by_rate};
  }
  return {0, 0, 0};
}

double JointStop::energy_at(double value) const {
  const double w = d_.depth, depth = std::max({value - d_.upper, d_.lower - value, 0.0}), beyond = depth - w / 2;
  return d_.stiffness * (depth < w ? depth * depth * depth / (6 * w) : 0.5 * beyond * beyond + w * w / 24);
}

}  // namespace sigmafmu
