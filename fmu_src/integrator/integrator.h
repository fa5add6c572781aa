// Time integration of a System: what others need of it.
//
// An Integrator owns its work space: one per thread. step() does not allocate.
#pragma once

#include <memory>

#include "integrator/method.h"
#include "integrator/problem.h"

namespace sigmafmu {

class Integrator {
 public:
  Integrator(const System& system, const IntegratorSettings& settings, KktPlans plans = {});

  // Sizes a State; no values but zeros, unit quaternions and zero counters.
  State make_state() const;
  // Completes a state whose q, v and turned are consistent: vdot, lambda and what the method remembers.
  [[nodiscard]] bool initialize(State& state, const InputSignal& input);
  // Adds a jump of vdot (after a jump of inputs or parameters) to all that depends on it.
  void shift_accelerations(State& state, const VectorXd& jump);
  // One internal step of h [s], in as many parts as it takes (step_control.h).
  [[nodiscard]] bool step(State& state, double h, const InputSignal& input, StepFailure& failure);

 private:
  Problem problem_;
  std::unique_ptr<IntegrationMethod> method_;
  VectorXd jump_;
};

}  // namespace sigmafmu
