// Why an internal step did not succeed.
#pragma once

namespace sigmafmu {

struct StepFailure {
  enum class Reason { none, rotation, singular, not_finite, no_convergence, inaccurate };
  Reason reason = Reason::none;
  double time = 0;       // end of the step that failed [s]
  double step_size = 0;  // [s]
  int body = -1;         // with the largest scaled increment, error or rotation
  double measure = 0;    // rotation in the step [rad]; last increment or estimated error over its tolerance
  int iterations = 0;

  // For `return failure.because(...)`.
  bool because(Reason why) {
    reason = why;
    return false;
  }
};

}  // namespace sigmafmu
