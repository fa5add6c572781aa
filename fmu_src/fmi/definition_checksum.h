// What of a mechanism an FMU that reads it from a file compares with the build.
#pragma once

#include <string>

#include "model/mechanism.h"

namespace sigmafmu {

// A checksum of all that is no parameter: names, what is connected with what, geometry, the choice of variables.
// Masses, initial values, gravity, parameters of forces, values of drives, settings, texts and modal data do not count.
std::string definition_checksum(const Mechanism& mechanism);

}  // namespace sigmafmu
