// Quadratic drag at a point of a body in a medium that moves at `flow`. In the axes of the body, or of the node that
// the point belongs to, with the velocity u of the point against the medium and the angular velocity w: force -|u|
// diag(coefficient) u and torque -|w| diag(rotational) w. A coefficient is rho c_d A / 2.
#pragma once

#include <vector>

#include "model/elements/one_point.h"
#include "model/parameter.h"

namespace sigmafmu {

struct DragDef : OnePoint {
  static constexpr const char *kKind = "drag", *kType = "drag";
  using Vector3d = Eigen::Vector3d;

  Vector3d coefficient = Vector3d::Zero();  // along the axes [N s2/m2]
  Vector3d rotational = Vector3d::Zero();   // about the axes [N m s2]
  Vector3d flow = Vector3d::Zero();         // in W [m/s]

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
};

}  // namespace sigmafmu
