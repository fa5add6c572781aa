// All that a file in models/ provides: one function, named like the file, that returns a Mechanism.
//
//   models/HeavyTop.cpp:   namespace sigmafmu::models { Mechanism HeavyTop() { ... } }
//
// The build finds the file, makes the FMU `HeavyTop.fmu` and adds the mechanism to the Python module.
#pragma once

#include <string>

#include "integrator/settings.h"
#include "multibody/definition.h"

namespace sigmafmu {

struct Mechanism {
  std::string name;         // = model identifier = name of the function and of its file
  std::string description;  // one sentence
  MultibodyDef multibody;
  IntegratorSettings integrator;
  double stop_time = 1.0;            // default experiment [s]
  double communication_step = 1e-3;  // default experiment [s]
};

}  // namespace sigmafmu
