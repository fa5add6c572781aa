// Units, types of variables and their nominal values: tables behind TypeDefinitions; enumerations are in
// settings_table.h.
#pragma once

#include <string>
#include <vector>

#include "model/definition.h"

namespace sigmafmu {

// A unit with its SI exponents and the units that people like to see it in: shown = factor * value.
struct Unit {
  const char* name;
  int kg, m, s, rad;
  struct Display {
    const char* name;
    double factor;
  };
  std::vector<Display> displays;
};
const std::vector<Unit>& units();

// Sizes that the definition of a mechanism tells, for nominal values; 0 where it tells nothing.
struct Scales {
  double length = 0;            // farthest body, node, joint or attachment point [m]
  double velocity = 0;          // fastest body at the start [m/s]
  double angular_velocity = 0;  // at the start [rad/s]
  double force = 0;             // weight of all bodies [N]
  double torque = 0;            // that weight at that length [N m]
};
Scales scales(const MultibodyDef& definition);

// What a Real variable measures.
struct RealType {
  const char* name;
  const char* quantity;      // as in the Modelica Standard Library
  const char* unit;          // of units()
  const char* display_unit;  // of that unit's displays, or null
  double min, max;
  double Scales::* nominal;  // or null
};
const std::vector<RealType>& real_types();
// By its name, which must be one of the table.
const RealType& real_type(const std::string& name);

}  // namespace sigmafmu
