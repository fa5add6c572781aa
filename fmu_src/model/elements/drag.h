// Quadratic drag at a point of a body in a medium that moves at `flow`. In the axes of the body, or of the node that
// the point belongs to, with the velocity u of the point against the medium and the angular velocity w: force -|u|
// diag(coefficient) u and torque -|w| diag(rotational) w. A coefficient is rho c_d A / 2.
#pragma once

#include <string>

#include "model/elements/checks.h"
#include "model/elements/references.h"
#include "model/parameter.h"

namespace sigmafmu {

struct DragDef {
  static constexpr const char *kKind = "drag", *kType = "drag";
  using Vector3d = Eigen::Vector3d;

  std::string name;
  int body = 0;
  Vector3d point = Vector3d::Zero();        // [m]
  Vector3d coefficient = Vector3d::Zero();  // along the axes [N s2/m2]
  Vector3d rotational = Vector3d::Zero();   // about the axes [N m s2]
  Vector3d flow = Vector3d::Zero();         // in W [m/s]
  int node = kFloatingFrame;

  static const std::vector<Parameter<DragDef>>& parameters() {
    using Def = DragDef;
    static const std::vector<Parameter<Def>> table = {
        {"coefficient", "Drag", "Drag along the body's axes: density c_d area / 2", 3,
         [](Def& d) { return d.coefficient.data(); }},
        {"rotational", "RotationalDrag", "Drag about the body's axes", 3, [](Def& d) { return d.rotational.data(); }},
        {"flow", "Velocity", "Velocity of the medium, in W", 3, [](Def& d) { return d.flow.data(); }},
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
