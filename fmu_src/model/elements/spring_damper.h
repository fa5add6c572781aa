// Between point1 of body1 and point2 of body2: force on body2 f = -K (p2 - p1) - D (v2 - v1) + f_actuator, with
// diagonal K [N/m], D [N s/m] and all vectors in W. The points may belong to nodes, as in Frame.
#pragma once

#include <vector>

#include "model/elements/two_points.h"
#include "model/parameter.h"

namespace sigmafmu {

struct SpringDamperDef : TwoPoints {
  static constexpr const char *kKind = "spring-damper", *kType = "spring_damper";

  Eigen::Vector3d stiffness = Eigen::Vector3d::Zero();
  Eigen::Vector3d damping = Eigen::Vector3d::Zero();

  static const std::vector<Parameter<SpringDamperDef>>& parameters() {
    using Def = SpringDamperDef;
    static const std::vector<Parameter<Def>> table = {
        {"stiffness", "Stiffness", "Stiffness along the axes of W", 3, [](Def& d) { return d.stiffness.data(); }},
        {"damping", "Damping", "Damping along the axes of W", 3, [](Def& d) { return d.damping.data(); }},
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
