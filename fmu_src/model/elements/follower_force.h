// A force [N] at a point of a body and a torque [N m] that turn with it: both in the axes of the body, or of the node
// that the point belongs to. Inputs are added to the constants.
#pragma once

#include <string>

#include "model/elements/checks.h"
#include "model/elements/references.h"
#include "model/parameter.h"

namespace sigmafmu {

struct FollowerForceDef {
  static constexpr const char *kKind = "follower force", *kType = "follower_force";

  std::string name;
  int body = 0;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  // [m]
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();
  int node = kFloatingFrame;

  static const std::vector<Parameter<FollowerForceDef>>& parameters() {
    using Def = FollowerForceDef;
    static const std::vector<Parameter<Def>> table = {
        {"force", "Force", "Constant force at the point, in body axes", 3, [](Def& d) { return d.force.data(); }},
        {"torque", "Torque", "Constant torque, in body axes", 3, [](Def& d) { return d.torque.data(); }},
    };
    return table;
  }
  void check(const References& of) const {
    of.not_ground(name, "acts on", body);
    of.node(name, body, node);
  }
  void check_values() const { validation::check_point(name + ".point", point); }
  template <typename Use>
  void points(Use use) const {
    use(body, point, node);
  }
  template <typename Archive, typename Any>
  static void visit(Archive& archive, Any& d) {
    archive.body("body", d.body);
    archive.optional("point", d.point);
    archive.optional("node", d.node, d.node != kFloatingFrame);
    archive.parameters(d);
  }
};

}  // namespace sigmafmu
