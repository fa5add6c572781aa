// What modelDescription.xml tells of a mechanism, and what an FMU that reads the mechanism from a file compares with
// it.
#pragma once

#include <string>
#include <vector>

#include "model/mechanism.h"
#include "multibody/ports/ports.h"

namespace sigmafmu {

// A checksum of the table of variables and of all that is no parameter: names, what is held by what, geometry. Masses,
// initial values, gravity, parameters of forces, values of drives, settings, texts and modal data do not count.
std::string interface_checksum(const Mechanism& mechanism, const std::vector<Port>& variables);

}  // namespace sigmafmu
