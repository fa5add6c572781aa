// Between point1 of body1 and point2 of body2: force on body2 f = -K (p2 - p1) - D (v2 - v1) + f_actuator, with
// diagonal K [N/m], D [N s/m] and all vectors in W. The points may belong to nodes, as in Frame.
#pragma once

#include <Eigen/Core>

#include "model/elements/checks.h"
#include "model/elements/references.h"
#include "model/parameter.h"

namespace sigmafmu {

struct SpringDamperDef {
  static constexpr const char *kKind = "spring-damper", *kType = "spring_damper";

  std::string name;
  int body1 = kGround;
  Eigen::Vector3d point1 = Eigen::Vector3d::Zero();
  int body2 = kGround;
  Eigen::Vector3d point2 = Eigen::Vector3d::Zero();
  Eigen::Vector3d stiffness = Eigen::Vector3d::Zero();
  Eigen::Vector3d damping = Eigen::Vector3d::Zero();
  int node1 = kFloatingFrame;
  int node2 = kFloatingFrame;

  static const std::vector<Parameter<SpringDamperDef>>& parameters() {
    using Def = SpringDamperDef;
    static const std::vector<Parameter<Def>> table = {
        {"stiffness", "Stiffness", "Stiffness along the axes of W", 3, [](Def& d) { return d.stiffness.data(); }},
        {"damping", "Damping", "Damping along the axes of W", 3, [](Def& d) { return d.damping.data(); }},
    };
    return table;
  }
  void check(const References& of) const {
    of.pair(name, body1, body2);
    of.node(name, body1, node1);
    of.node(name, body2, node2);
  }
  void check_values() const {
    validation::check_point(name + ".point1", point1);
    validation::check_point(name + ".point2", point2);
  }
  template <typename Use>
  void points(Use use) const {
    use(body1, point1, node1);
    use(body2, point2, node2);
  }
  template <typename Archive, typename Any>
  static void visit(Archive& archive, Any& d) {
    archive.bodies("bodies", d.body1, d.body2);
    archive.optional("point1", d.point1);
    archive.optional("point2", d.point2);
    archive.parameters(d);
    archive.optional("node1", d.node1, d.node1 != kFloatingFrame);
    archive.optional("node2", d.node2, d.node2 != kFloatingFrame);
  }
};

}  // namespace sigmafmu
