// Many points of body2 that touch a plane of body1, as the corners of a box or the nodes of a hull: a small sphere
// about each, on the plane z = 0 of frame1, whose z axis points to the free side.
#pragma once

#include <vector>

#include "model/elements/contact_surface.h"
#include "model/elements/references.h"

namespace sigmafmu {

struct CloudContactDef {
  static constexpr const char *kKind = "cloud contact", *kType = "cloud_contact";

  std::string name;
  int body1 = kGround;
  Frame frame1;
  int body2 = kGround;
  std::vector<Eigen::Vector3d> points2;  // seen from node2, where there is one [m]
  double radius = 1;                     // of the spheres [m]
  ContactSurface surface;
  int node2 = kFloatingFrame;

  static const std::vector<Parameter<CloudContactDef>>& parameters() { return surface_parameters<CloudContactDef>(); }
  void check(const References& of) const {
    of.pair(name, body1, body2);
    of.node(name, body1, frame1.node);
    of.node(name, body2, node2);
  }
  void check_values() const;
  template <typename Use>
  void points(Use use) const {
    use(body1, frame1.origin, frame1.node);
    for (const Eigen::Vector3d& point : points2) use(body2, point, node2);
  }
  template <typename Archive, typename Any>
  static void visit(Archive& archive, Any& d) {
    archive.bodies("bodies", d.body1, d.body2);
    archive.optional("frame1", d.frame1);
    archive.required("points2", d.points2);
    archive.optional("node2", d.node2, d.node2 != kFloatingFrame);
    archive.required("radius", d.radius);
    archive.parameters(d);
  }
};

}  // namespace sigmafmu
