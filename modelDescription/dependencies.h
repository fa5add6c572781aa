// Which outputs depend directly on which inputs, found by probing the equations of motion themselves.
#pragma once

#include <vector>

#include "model/mechanism.h"

namespace sigmafmu {

// [i][j]: whether variable i (an output) depends on variable j (an input), by index into the variable table.
using Dependencies = std::vector<std::vector<bool>>;

// Holds for every value of the parameters and every reachable state: the mechanism is probed with full inertia
// matrices and modes without symmetry at points of a motion driven by arbitrary inputs. Where it cannot move so far,
// every output that may depend on inputs is said to. Empty where there are more than a million pairs of an output and
// an input: nothing is known then.
Dependencies probe_dependencies(Mechanism mechanism);

}  // namespace sigmafmu
