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

#include "integrator/implicit_integrator.h"

namespace sigmafmu {

class BLieDF final : public ImplicitIntegrator {
 public:
  BLieDF(const System& system, const IntegratorSettings& settings, KktPlans plans)
      : ImplicitIntegrator(system, settings, plans) {}

  State make_state() const override;
  void shift_accelerations(State& state, const VectorXd& jump) override;

 private:
  void remember_start(State& state, const VectorXd& V, const VectorXd& Vdot, const VectorXd& jerk) override;
  void begin(const State& state) override;
  void finish(State& state) override;
  void shift_memory(State& state, const VectorXd& dV, const VectorXd& dVdot) override;
  double position_error() const override { return fresh_ ? 1.0 / 12.0 : 2.0 / 9.0; }
  // A mean over a short step has the error of its positions, as far as constraints hold them, over h: that of the
  // method in index 3, else rounding.
  double memory() const override { return settings_.is(Formulation::index3) ? kMemory : 1e4; }
};

}  // namespace sigmafmu
