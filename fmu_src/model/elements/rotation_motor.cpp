#include "model/elements/rotation_motor.h"

#include "model/definition.h"
#include "model/validation.h"

namespace sigmafmu {

std::string RotationMotorDef::variable(const MultibodyDef& d, const std::string& word) const {
  return d.joints[joint].name + "." + word;
}

void RotationMotorDef::check(const References& of) const {
  of.joint("A rotation motor", joint);
  const JointDef& j = of.definition().joints[joint];
  switch (j.type) {
    case JointType::spherical:
    case JointType::distance:
    case JointType::point_on_line:
    case JointType::free:
    case JointType::constant_velocity:
    case JointType::point_in_plane:
      return;
    default:
      validation::fail(j.name,
                       " has a rotation motor; its type must be spherical, distance, point_on_line, point_in_plane, "
                       "constant_velocity or free.");
  }
}

}  // namespace sigmafmu
