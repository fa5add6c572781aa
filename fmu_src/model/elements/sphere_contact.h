// Two spheres that touch: one of body1 about point1, one of body2 about point2.
#pragma once

#include "model/elements/contact_surface.h"
#include "model/elements/two_points.h"

namespace sigmafmu {

struct SphereContactDef : TwoPoints {
  static constexpr const char *kKind = "sphere contact", *kType = "sphere_contact";

  double radius1 = 1, radius2 = 1;  // [m]
  ContactSurface surface;

  static const std::vector<Parameter<SphereContactDef>>& parameters() { return surface_parameters<SphereContactDef>(); }
  void check_values() const {
    check_points();
    validation::check_positive(name + ".radius1", radius1, "m");
    validation::check_positive(name + ".radius2", radius2, "m");
    surface.check_values(name);
  }
  template <typename Archive, typename Any>
  static void visit(Archive& archive, Any& d) {
    visit_points(archive, d);
    archive.required("radius1", d.radius1);
    archive.required("radius2", d.radius2);
    archive.parameters(d);
  }
};

}  // namespace sigmafmu
