// What surfaces that touch are made of (multibody/forces/contact_law.h).
#pragma once

#include <string>
#include <vector>

#include "model/elements/checks.h"
#include "model/parameter.h"

namespace sigmafmu {

struct ContactSurface {
  double modulus = 1e7;         // E* [Pa]: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2
  double dissipation = 0;       // c [s/m]: small impacts at v are elastic but for the share c v
  double friction = 0;          // mu
  double slip_velocity = 1e-2;  // v_s [m/s]: from where on friction has 0.7 of its force

  void check_values(const std::string& name) const {
    validation::check_positive(name + ".slipVelocity", slip_velocity, "m/s");
  }
};

// Those of an element whose member `surface` it is.
template <typename Def>
const std::vector<Parameter<Def>>& surface_parameters() {
  static const std::vector<Parameter<Def>> table = {
      {"modulus", "Modulus", "Contact modulus E*", 0, [](Def& d) { return &d.surface.modulus; }},
      {"dissipation", "Dissipation", "Hunt-Crossley dissipation", 0, [](Def& d) { return &d.surface.dissipation; }},
      {"friction", "Coefficient", "Coefficient of friction", 0, [](Def& d) { return &d.surface.friction; }},
      {"slipVelocity", "SlipVelocity", "Sliding velocity at which friction has 0.7 of its force", 0,
       [](Def& d) { return &d.surface.slip_velocity; }},
  };
  return table;
}

}  // namespace sigmafmu
