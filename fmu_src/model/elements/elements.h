// The closed list of the forces that a mechanism may have; all that handles them goes through it.
//
// A definition has kKind (in messages), kType (in files, where a list holds several types), parameters(), check() of
// what it refers to, check_values() of numbers that are no parameters, points() where it attaches to bodies, visit() of
// its members for files, and a name or variable(), which makes names of variables.
#pragma once

#include <type_traits>
#include <utility>

#include "model/elements/bearing.h"
#include "model/elements/bushing.h"
#include "model/elements/cloud_contact.h"
#include "model/elements/drag.h"
#include "model/elements/follower_force.h"
#include "model/elements/joint_armature.h"
#include "model/elements/joint_friction.h"
#include "model/elements/joint_spring.h"
#include "model/elements/joint_stop.h"
#include "model/elements/line_spring.h"
#include "model/elements/load.h"
#include "model/elements/plane_contact.h"
#include "model/elements/rotation_motor.h"
#include "model/elements/sphere_contact.h"
#include "model/elements/spring_damper.h"
#include "model/elements/table_spring.h"
#include "model/elements/tendon.h"
#include "model/elements/torsion_spring.h"

namespace sigmafmu {

// Calls use(key of the list in files, list) for each type of force, those of one key one after the other; Any is a
// MultibodyDef, const or not.
template <typename Any, typename Use>
void for_each_force_list(Any& d, Use use) {
  use("loads", d.loads);
  use("forces", d.spring_dampers);
  use("forces", d.line_springs);
  use("forces", d.table_springs);
  use("forces", d.torsion_springs);
  use("forces", d.bushings);
  use("forces", d.bearings);
  use("forces", d.follower_forces);
  use("forces", d.drags);
  use("forces", d.plane_contacts);
  use("forces", d.sphere_contacts);
  use("forces", d.cloud_contacts);
  use("tendons", d.tendons);
  use("joint_springs", d.joint_springs);
  use("joint_frictions", d.joint_frictions);
  use("joint_stops", d.joint_stops);
  use("joint_armatures", d.joint_armatures);
  use("rotation_motors", d.rotation_motors);
}

template <typename Def, typename = void>
struct HasName : std::false_type {};
template <typename Def>
struct HasName<Def, std::void_t<decltype(std::declval<Def>().name)>> : std::true_type {};
template <typename Def, typename = void>
struct HasDescription : std::false_type {};
template <typename Def>
struct HasDescription<Def, std::void_t<decltype(std::declval<Def>().description)>> : std::true_type {};

// The name of an element's variable.
template <typename Def>
std::string variable_name(const MultibodyDef& d, const Def& element, const std::string& word) {
  if constexpr (HasName<Def>::value) {
    return element.name + "." + word;
  } else {
    return element.variable(d, word);
  }
}

template <typename Def>
const char* type_of(const MultibodyDef& d, const Def& element, const Parameter<Def>& parameter) {
  if constexpr (std::is_base_of_v<OnCoordinate, Def>) {
    if (parameter.type_of_angle && element.turns(d)) return parameter.type_of_angle;
  }
  return parameter.type;
}

}  // namespace sigmafmu
