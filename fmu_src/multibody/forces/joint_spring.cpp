#include "multibody/forces/joint_spring.h"

namespace sigmafmu {

const std::vector<ForcePort>& JointSpring::ports() const {
  static const std::vector<ForcePort> torque = {
      {"springTorque", 0, "Torque", "Torque of the joint's spring and damper on the second body", output},
      {"springEnergy", 0, "Energy", "Elastic energy of the joint's spring", energy_output},
      {"springPower", 0, "Power", "Power of the joint's spring and damper on the bodies", power_output}};
  static const std::vector<ForcePort> force = {
      {"springForce", 0, "Force", "Force of the joint's spring and damper on the second body", output},
      {"springEnergy", 0, "Energy", "Elastic energy of the joint's spring", energy_output},
      {"springPower", 0, "Power", "Power of the joint's spring and damper on the bodies", power_output}};
  return is_angle() ? torque : force;
}

}  // namespace sigmafmu
