#include "integrator/step_control.h"

#include <algorithm>
#include <cmath>

namespace sigmafmu {
namespace {

bool attempt(IntegrationMethod& method, State& s, double h, const InputSignal& input, StepFailure& failure) {
  failure = {};
  failure.time = s.time + h;
  failure.step_size = h;
  return method.attempt(s, h, input, failure);
}

bool fixed_step(IntegrationMethod& method, double smallest, State& s, double remaining, const InputSignal& input,
                StepFailure& failure) {
  double h = remaining;
  while (true) {
    const bool last = h > 0.75 * remaining;
    if (last) h = remaining;
    if (attempt(method, s, h, input, failure)) {
      if (last) return true;
      remaining -= h;
      continue;
    }
    h *= 0.5;
    if (h < smallest) return false;
    ++s.counters.retries;
  }
}

// The next step is as long as the error lets expect.
bool controlled_step(IntegrationMethod& method, double smallest, State& s, double remaining, const InputSignal& input,
                     StepFailure& failure) {
  constexpr double kSafety = 0.9, kShrink = 0.2;
  const auto [order, largest_growth] = method.error_control;
  while (true) {
    const double proposed = s.next_step > 0 ? s.next_step : remaining;
    // Rather two equal steps than a tiny last one.
    const double h = proposed >= remaining ? remaining : std::min(proposed, 0.5 * remaining + 0.25 * proposed);
    const bool last = h == remaining;
    const bool done = attempt(method, s, h, input, failure);
    const bool measured = done || failure.reason == StepFailure::Reason::inaccurate;
    const double factor =
        measured ? std::clamp(kSafety * std::pow(failure.measure, -1.0 / order), kShrink, largest_growth) : 0.5;
    if (done) {
      s.next_step = last ? std::max(s.next_step, factor * h) : factor * h;
      if (last) return true;
      remaining -= h;
      continue;
    }
    s.next_step = std::min(factor, 0.9) * h;
    if (s.next_step < smallest) return false;
    ++s.counters.retries;
  }
}

}  // namespace

bool do_step(IntegrationMethod& method, int max_halvings, State& s, double h, const InputSignal& input,
             StepFailure& failure) {
  const double smallest = std::ldexp(h, -max_halvings) * 0.75;
  return method.error_control.order > 0 ? controlled_step(method, smallest, s, h, input, failure)
                                        : fixed_step(method, smallest, s, h, input, failure);
}

}  // namespace sigmafmu
