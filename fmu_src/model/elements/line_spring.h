// Along the line from point1 of body1 to point2 of body2, of length L: the tension N = k (L - L_0) + d L' + N_actuator
// pulls both points towards each other.
#pragma once

#include "model/elements/two_points.h"
#include "model/parameter.h"

namespace sigmafmu {

struct LineSpringDef : TwoPoints {
  static constexpr const char *kKind = "line spring", *kType = "line_spring";

  double stiffness = 0;    // k [N/m]
  double damping = 0;      // d [N s/m]
  double free_length = 0;  // L_0 [m]

  static const std::vector<Parameter<LineSpringDef>>& parameters() {
    using Def = LineSpringDef;
    static const std::vector<Parameter<Def>> table = {
        {"stiffness", "Stiffness", "Stiffness along the line", 0, [](Def& d) { return &d.stiffness; }},
        {"damping", "Damping", "Damping along the line", 0, [](Def& d) { return &d.damping; }},
        {"freeLength", "Distance", "Length at which the spring has no force", 0, [](Def& d) { return &d.free_length; }},
    };
    return table;
  }
  void check_values() const { check_points(); }
  template <typename Archive, typename Any>
  static void visit(Archive& archive, Any& d) {
    visit_points(archive, d);
    archive.parameters(d);
  }
};

}  // namespace sigmafmu
