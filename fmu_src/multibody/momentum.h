// Mass, centre of mass and momenta of all bodies, in W. With m, S and J of a body and H of its modes (flexible_body.h;
// of a rigid body S = 0), its momentum is m v + R (w x S + S') and its moment of momentum about its frame's origin
// S x R^T v + J w + H zeta'.
#pragma once

#include "multibody/system.h"

namespace sigmafmu {

struct Momentum {
  double mass = 0;                             // [kg]
  Vector3d centre_of_mass = Vector3d::Zero();  // [m]
  Vector3d linear = Vector3d::Zero();          // [N s]
  Vector3d angular = Vector3d::Zero();         // about the origin of W [N m s]
};

Momentum momentum(const System& system, const Evaluation& e);

}  // namespace sigmafmu
