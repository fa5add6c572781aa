// All that a file in models/ provides: one function, named like the file, that returns a Mechanism.
//
//   models/HeavyTop.cpp:   namespace sigmafmu::models { Mechanism HeavyTop() { ... } }
//
// The build finds the file, makes the FMU `HeavyTop.fmu` and adds the mechanism to the Python module.
#pragma once

#include <string>
#include <vector>

#include "model/definition.h"
#include "model/settings.h"

namespace sigmafmu {

// Makes a body flexible with the modal data of a file: one of the FMU's folder `resources`, here in
// models/resources/<Mechanism>. The number of modes is told because the FMU has variables for each.
struct ModalFileDef {
  int body = 0;
  std::string file;
  int modes = 0;
};

// A point of a flexible body, the mean of some of its nodes, whose place in W is an output. So are, if axes (unit
// vectors in B) are given, the components of its displacement by deformation along them.
struct StationDef {
  std::string name;
  std::string description;
  int body = 0;
  std::vector<int> nodes;  // from 0
  std::vector<Vector3d> deflection_axes = {};
};

struct Mechanism {
  std::string name;         // = model identifier = name of the function and of its file
  std::string description;  // one sentence
  MultibodyDef multibody;
  std::vector<ModalFileDef> modal_files;  // data that `multibody` lacks until load_modal_files (fmi/modal_file.h)
  std::vector<StationDef> stations;
  IntegratorSettings integrator;
  double stop_time = 1.0;            // default experiment [s]
  double communication_step = 1e-3;  // default experiment [s]
};

}  // namespace sigmafmu
