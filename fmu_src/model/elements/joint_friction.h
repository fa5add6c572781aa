// Friction on a joint's coordinate c: f = -(F + S exp(-(c'/v_S)^2)) tanh(c'/v_0) - d c' on the second body: Coulomb,
// Stribeck and viscous friction.
//
// It is smooth, so nothing sticks: under a load p below F + S the coordinate creeps, at v_0 atanh(p / (F + S)) where
// v_0 is small against v_S.
#pragma once

#include <vector>

#include "model/elements/on_coordinate.h"

namespace sigmafmu {

struct JointFrictionDef : OnCoordinate {
  static constexpr const char *kKind = "joint friction", *kType = nullptr, *kSeveral = "frictions";

  double friction = 0;           // F [N m] or [N]
  double stribeck_friction = 0;  // S
  double stribeck_rate = 0.1;    // v_S [rad/s] or [m/s]
  double viscous_friction = 0;   // d
  double creep_rate = 1e-3;      // v_0

  static const std::vector<Parameter<JointFrictionDef>>& parameters() {
    using Def = JointFrictionDef;
    static const std::vector<Parameter<Def>> table = {
        {"friction", "FrictionForce", "Coulomb friction of the joint", 0, [](Def& d) { return &d.friction; },
         "FrictionTorque"},
        {"stribeckFriction", "FrictionForce", "What is added to the Coulomb friction at rest", 0,
         [](Def& d) { return &d.stribeck_friction; }, "FrictionTorque"},
        {"stribeckRate", "RateScale", "Rate at which a part 1/e of that is left", 0,
         [](Def& d) { return &d.stribeck_rate; }, "AngularRateScale"},
        {"viscousFriction", "Damping", "Friction of the joint by its rate", 0,
         [](Def& d) { return &d.viscous_friction; }, "TorsionalDamping"},
        {"creepRate", "RateScale",
         "Rate at which friction has tanh(1) = 76 % of its value; loads below it let it creep", 0,
         [](Def& d) { return &d.creep_rate; }, "AngularRateScale"},
    };
    return table;
  }
  void check(const References& of) const { of.coordinate("A joint friction", joint, coordinate); }
};

}  // namespace sigmafmu
