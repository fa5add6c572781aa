// All that a file in models/ provides: one function, named like the file, that returns a Mechanism.
//
//   models/HeavyTop.cpp:   namespace sigmafmu::models { Mechanism HeavyTop() { ... } }
//
// The build finds the file, makes the FMU `HeavyTop.fmu` and adds the mechanism to the Python module.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "model/definition.h"
#include "model/sensor.h"
#include "model/settings.h"

namespace sigmafmu {

// A point of a flexible body, the mean of some of its nodes, whose place in W is an output. So are, if axes (unit
// vectors in B) are given, the components of its displacement by deformation along them.
struct StationDef {
  std::string name;
  std::string description;
  int body = 0;
  std::vector<int> nodes;  // from 0
  std::vector<Vector3d> deflection_axes = {};
};

// Which variables the FMU has: those whose name, or that of their vector, a shell pattern (* ? [...]) matches. Counters
// are among the outputs.
struct ExposureDef {
  std::vector<std::string> inputs, outputs, parameters;
};

struct Mechanism {
  std::string name;         // = model identifier = name of the function and of its file
  std::string description;  // one sentence
  MultibodyDef multibody;
  std::vector<StationDef> stations;
  std::vector<SensorDef> sensors;
  // Nothing said: all of up to 20 bodies; of more, all but what belongs to bodies.
  std::optional<ExposureDef> expose = std::nullopt;
  IntegratorSettings integrator;
  double stop_time = 1.0;            // default experiment [s]
  double communication_step = 1e-3;  // default experiment [s]

  int add(StationDef station);  // each returns the index
  int add(SensorDef sensor);
};

// Each throws std::invalid_argument with one sentence, as that for a MultibodyDef: settings of the integrator that are
// out of range; stations of no flexible body or at no node of it, sensors of no body, the name of the mechanism, the
// default experiment.
void validate(const IntegratorSettings& settings);
void validate(const Mechanism& mechanism);

}  // namespace sigmafmu
