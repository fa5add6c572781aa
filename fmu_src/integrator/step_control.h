// Which steps a method attempts. Knows no method.
#pragma once

#include "integrator/method.h"

namespace sigmafmu {

// From state.time on by h [s]. Attempts that fail are repeated with halved steps; with error control h is divided into
// steps whose errors keep the tolerance. When that fails too, false is returned, the state stays where the last good
// step ended and `failure` tells why. The counters count every attempt.
[[nodiscard]] bool do_step(IntegrationMethod& method, int max_halvings, State& state, double h,
                           const InputSignal& input, StepFailure& failure);

}  // namespace sigmafmu
