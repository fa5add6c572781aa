// A parameter set by its name before there is an FMU: mechanisms of files and Python.
#pragma once

#include <string>

#include "model/mechanism.h"

namespace sigmafmu {

// By the name that it has in the FMU, with the FMU's checks: throws std::invalid_argument with one sentence.
void set_parameter(Mechanism& mechanism, const std::string& name, double value);

}  // namespace sigmafmu
