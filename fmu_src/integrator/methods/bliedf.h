// BLieDF: backward differentiation on Lie groups, two steps (Wieloch, Arnold 2021: BDF integrators for constrained
// mechanical systems on Lie groups). With omega = h/(h + h_old), which is 1/2 for equal steps,
//
//   V_{n+1}    = (1 + omega) theta_n/h - omega theta_{n-1}/h_old + (1 + omega) B(q_n)^T eta
//   Vdot_{n+1} = (1 + omega) (V_{n+1} - V_n)/h - omega (V_n - V_{n-1})/h_old
//
// and q_{n+1} = q_n o psi(theta_n). Means over steps are velocities in their middle up to O(h^2), and brackets enter
// with the same order, so that two steps need no bracket. Damps all that is stiff. A step that follows a much
// shorter one is done by the trapezoidal rule.
#pragma once

#include "integrator/implicit/step_ends.h"

namespace sigmafmu {

class BLieDF final : public IntegrationMethod {
 public:
  explicit BLieDF(Problem& problem);

  void make_state(State& state) const override;
  void start(State& state, const VectorXd& V, const VectorXd& Vdot, const VectorXd& jerk) const override;
  [[nodiscard]] bool attempt(State& state, double h, const InputSignal& input, StepFailure& failure) override;
  void jump(State& state, const VectorXd& dVdot) const override;

 private:
  void set_equations(const State& state);

  const double memory_;
  StepEnds ends_;
  NewtonMethod newton_;
  StepStart start_;
  StepEquations equations_;
  Iterate at_;
};

}  // namespace sigmafmu
