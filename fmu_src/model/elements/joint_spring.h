// Spring and damper on a joint's coordinate c: f = -k (c - c_rest) - d c' on the second body, a torque [N m] about the
// joint's axis or a force [N] along it. Angles count turns.
#pragma once

#include <vector>

#include "model/elements/on_coordinate.h"

namespace sigmafmu {

struct JointSpringDef : OnCoordinate {
  static constexpr const char *kKind = "joint spring", *kType = nullptr, *kSeveral = "springs";

  double stiffness = 0;
  double damping = 0;
  double rest = 0;  // where the spring has no force [rad] or [m]

  static const std::vector<Parameter<JointSpringDef>>& parameters() {
    using Def = JointSpringDef;
    static const std::vector<Parameter<Def>> table = {
        {"stiffness", "Stiffness", "Stiffness of the joint's spring", 0, [](Def& d) { return &d.stiffness; },
         "TorsionalStiffness"},
        {"damping", "Damping", "Damping in the joint", 0, [](Def& d) { return &d.damping; }, "TorsionalDamping"},
        {"rest", "Displacement", "Where the joint's spring has no force", 0, [](Def& d) { return &d.rest; }, "Angle"},
    };
    return table;
  }
  void check(const References& of) const { of.coordinate("A joint spring", joint, coordinate); }
};

}  // namespace sigmafmu
