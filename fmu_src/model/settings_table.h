// What the settings of the integrator may be, by the names that they have in the FMU (integrator.stepSize, ...): the
// one table for parameters, for JSON and for validate.
#pragma once

#include <string>
#include <vector>

#include "model/settings.h"

namespace sigmafmu {

struct Enumeration {
  const char* name;
  const char* description;
  struct Item {
    const char* name;
    const char* description;
  };
  std::vector<Item> items;  // values 1, 2, ...
};
const std::vector<Enumeration>& enumerations();

struct RealSetting {
  const char* name;
  double IntegratorSettings::* value;
  double min, max;
  bool above_min;  // min itself is not allowed
};
const std::vector<RealSetting>& real_settings();

struct IntegerSetting {
  const char* name;
  int IntegratorSettings::* value;
  int min, max;
  const Enumeration* enumeration;  // or null
};
const std::vector<IntegerSetting>& integer_settings();

}  // namespace sigmafmu
