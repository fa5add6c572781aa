// What forces between a point of one body and a point of another have in common.
#pragma once

#include <string>

#include "model/elements/checks.h"
#include "model/elements/references.h"

namespace sigmafmu {

// point1 of body1 and point2 of body2 [m]; they may belong to nodes, as in Frame.
struct TwoPoints {
  std::string name;
  int body1 = kGround;
  Eigen::Vector3d point1 = Eigen::Vector3d::Zero();
  int body2 = kGround;
  Eigen::Vector3d point2 = Eigen::Vector3d::Zero();
  int node1 = kFloatingFrame;
  int node2 = kFloatingFrame;

  void check(const References& of) const {
    of.pair(name, body1, body2);
    of.node(name, body1, node1);
    of.node(name, body2, node2);
  }
  void check_points() const {
    validation::check_point(name + ".point1", point1);
    validation::check_point(name + ".point2", point2);
  }
  template <typename Use>
  void points(Use use) const {
    use(body1, point1, node1);
    use(body2, point2, node2);
  }
  template <typename Archive, typename Any>
  static void visit_points(Archive& archive, Any& d) {
    archive.bodies("bodies", d.body1, d.body2);
    archive.optional("point1", d.point1);
    archive.optional("point2", d.point2);
    archive.optional("node1", d.node1, d.node1 != kFloatingFrame);
    archive.optional("node2", d.node2, d.node2 != kFloatingFrame);
  }
};

}  // namespace sigmafmu
