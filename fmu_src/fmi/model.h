// What tells one FMU from another. Two files define it: model.cpp, which the build generates for each mechanism of
// models/, and model_of_file.cpp for mechanisms that are a file in the FMU's resources.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "model/mechanism.h"
#include "multibody/ports/ports.h"
#include "text/checksum.h"

namespace sigmafmu {

struct Model {
  Mechanism mechanism;             // without its modal data
  std::string guid;                // hash of modelDescription.xml
  std::string interface_of_build;  // interface_checksum (interface.h) of the mechanism that the FMU was built from
  std::uint64_t resources = kNoChecksum;  // of all that was read
};

// `location` is that of the resources, which a master may leave out. Throws std::exception with one sentence.
Model make_model(const char* location);

// Throws Refused when the resources have been edited since the build in a way that modelDescription.xml, with these
// variables, does not allow.
void check_interface(const Model& model, const std::vector<Port>& variables);

}  // namespace sigmafmu
