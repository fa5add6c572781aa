// Every mechanism of models/; the build generates the definition from the files it finds there.
#pragma once

#include <vector>

#include "model/mechanism.h"

namespace sigmafmu {

std::vector<Mechanism> mechanisms();

}  // namespace sigmafmu
