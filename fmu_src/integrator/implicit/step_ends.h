// The two ends of a step of an implicit method, whatever its length.
//
// What a method remembers of a step is divided by its length or is a difference over it, and serves the next one as far
// as that is not much longer. Steps of any length may follow each other:
//
//   h > memory last_step        the method starts anew, from accelerations that the index-1 equations give
//   or kMemory h < last_step    index 3 projects the velocities onto their constraints
//   h < kDrift                  nothing moves by more than rounding: Heun's explicit method, which divides by no h; the
//                               memory stays as it is
#pragma once

#include "integrator/implicit/newton.h"
#include "integrator/method.h"

namespace sigmafmu {

class StepEnds {
 public:
  static constexpr double kMemory = 1.5;
  static constexpr double kDrift = 1e-12;  // [s]

  explicit StepEnds(Problem& problem);

  // Of a method of second order; with steps that are not longer than its memory.
  static ErrorControl error_control(const IntegratorSettings& settings);

  // V_n, Vdot_n, lambda_n and what else is known; `memory`: how many times longer than the step before a step may be
  // that uses what is remembered of it.
  [[nodiscard]] bool begin(State& state, double h, double memory, const InputSignal& input, StepStart& start,
                           StepFailure& failure);
  // Takes over the end of the step, unless its error is too large. That in positions is h^3 and the derivative of Vdot
  // times `position_error`.
  [[nodiscard]] bool complete(const StepStart& start, double position_error, NewtonMethod& newton, Iterate& at,
                              State& state, StepFailure& failure);
  // The whole of a step below kDrift. What is remembered of V and Vdot changes by dV and dVdot.
  [[nodiscard]] bool drift(State& state, double h, const InputSignal& input, StepFailure& failure);
  const VectorXd& dV() const { return dV_; }
  const VectorXd& dVdot() const { return dVdot_; }

 private:
  bool satisfy_velocity_constraints(const Inputs& u, Iterate& at);

  Problem& problem_;
  VectorXd dV_, dVdot_;
  Inputs u_;
  VectorXd q_, v_, vdot_, lambda_, V_, Vdot_;
};

}  // namespace sigmafmu
