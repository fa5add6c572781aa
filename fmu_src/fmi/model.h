// What tells one FMU from another. Two files define it: model.cpp, which the build generates for each mechanism of
// models/, and model_of_file.cpp for mechanisms that are a file in the FMU's resources.
#pragma once

#include <cstdint>
#include <string>

#include "model/mechanism.h"
#include "text/checksum.h"

namespace sigmafmu {

struct Model {
  Mechanism mechanism;                    // without its modal data
  std::string guid;                       // hash of modelDescription.xml
  std::string variables;                  // variables_checksum at the build; empty: they have been compiled
  std::uint64_t resources = kNoChecksum;  // of all that was read
};

// `location` is that of the resources, which a master may leave out. Throws std::exception with one sentence.
Model make_model(const char* location);

}  // namespace sigmafmu
