// A sphere of body2 about point2 that touches a plane of body1: z = 0 of frame1, whose z axis points to the free side.
#pragma once

#include "model/elements/contact_surface.h"
#include "model/elements/references.h"

namespace sigmafmu {

struct PlaneContactDef {
  static constexpr const char *kKind = "plane contact", *kType = "plane_contact";

  std::string name;
  int body1 = kGround;
  Frame frame1;
  int body2 = kGround;
  Eigen::Vector3d point2 = Eigen::Vector3d::Zero();
  double radius = 1;  // [m]
  ContactSurface surface;
  int node2 = kFloatingFrame;

  static const std::vector<Parameter<PlaneContactDef>>& parameters() { return surface_parameters<PlaneContactDef>(); }
  void check(const References& of) const {
    of.pair(name, body1, body2);
    of.node(name, body1, frame1.node);
    of.node(name, body2, node2);
  }
  void check_values() const {
    validation::check_frame(name + ".frame1", frame1);
    validation::check_point(name + ".point2", point2);
    validation::check_positive(name + ".radius", radius, "m");
    surface.check_values(name);
  }
  template <typename Use>
  void points(Use use) const {
    use(body1, frame1.origin, frame1.node);
    use(body2, point2, node2);
  }
  template <typename Archive, typename Any>
  static void visit(Archive& archive, Any& d) {
    archive.bodies("bodies", d.body1, d.body2);
    archive.optional("frame1", d.frame1);
    archive.optional("point2", d.point2);
    archive.optional("node2", d.node2, d.node2 != kFloatingFrame);
    archive.required("radius", d.radius);
    archive.parameters(d);
  }
};

}  // namespace sigmafmu
