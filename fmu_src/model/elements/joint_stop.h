// Stops of a joint's coordinate c at both ends of its range. Beyond one of them by p > 0 the second body is pushed
// back:
//
//   f = k s(p) (1 + z / sqrt(1 + z^2)),   z = d p',   s = p^2 / (2 w) for p < w, else p - w/2.
//
// f never pulls, and it and its derivatives by p and p' are continuous: stiff from the depth w on. Damping d makes f up
// to twice as large on the way in and takes it away on the way out: 0 gives all energy back, much of it nothing.
#pragma once

#include <vector>

#include "model/elements/on_coordinate.h"

namespace sigmafmu {

struct JointStopDef : OnCoordinate {
  static constexpr const char *kKind = "joint stop", *kType = nullptr, *kSeveral = "stops";

  double lower = -1e9, upper = 1e9;  // [rad] or [m]
  double stiffness = 0;              // k [N m/rad] or [N/m]
  double damping = 0;                // d [s/rad] or [s/m]
  double depth = 1e-3;               // w [rad] or [m]

  static const std::vector<Parameter<JointStopDef>>& parameters() {
    using Def = JointStopDef;
    static const std::vector<Parameter<Def>> table = {
        {"lowerStop", "Displacement", "Where the joint's range begins", 0, [](Def& d) { return &d.lower; }, "Angle"},
        {"upperStop", "Displacement", "Where the joint's range ends", 0, [](Def& d) { return &d.upper; }, "Angle"},
        {"stopStiffness", "Stiffness", "Stiffness of the joint's stops", 0, [](Def& d) { return &d.stiffness; },
         "TorsionalStiffness"},
        {"stopDamping", "StopDamping", "Damping of the joint's stops: at this times the rate of 1 about half of it", 0,
         [](Def& d) { return &d.damping; }, "TorsionalStopDamping"},
        {"stopDepth", "LengthScale", "Depth from which the joint's stops are stiff", 0, [](Def& d) { return &d.depth; },
         "AngleScale"},
    };
    return table;
  }
  void check(const References& of) const;
};

}  // namespace sigmafmu
