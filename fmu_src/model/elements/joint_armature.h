// Inertia a of what turns or moves with a joint's coordinate c beside its bodies: of a motor's rotor, seen through its
// gear. It adds a c'^2 / 2 to the kinetic energy. Its gyroscopic moments and its weight are left out.
#pragma once

#include <vector>

#include "model/elements/on_coordinate.h"

namespace sigmafmu {

struct JointArmatureDef : OnCoordinate {
  static constexpr const char *kKind = "armature", *kType = nullptr, *kSeveral = "armatures";

  double armature = 0;  // [kg m^2] or [kg]

  static const std::vector<Parameter<JointArmatureDef>>& parameters() {
    using Def = JointArmatureDef;
    static const std::vector<Parameter<Def>> table = {
        {"armature", "Mass", "Inertia that moves with the joint's coordinate", 0, [](Def& d) { return &d.armature; },
         "MomentOfInertia"},
    };
    return table;
  }
  void check(const References& of) const { of.coordinate("An armature", joint, coordinate); }
};

}  // namespace sigmafmu
