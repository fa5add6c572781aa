// What forces at a point of a single body have in common.
#pragma once

#include <string>

#include "model/elements/checks.h"
#include "model/elements/references.h"

namespace sigmafmu {

// The point [m] may belong to a node, as in Frame.
struct OnePoint {
  std::string name;
  int body = 0;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  int node = kFloatingFrame;

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
