// Runge-Kutta-Munthe-Kaas methods (Mueller 2022, Eqs. (52)-(54)): an explicit Runge-Kutta method in each step solves
//
//   dtheta/dt = T(theta)^-1 V,   dV/dt = Vdot(tau(q_n, theta), V, t),   theta(t_n) = 0
//
// with the accelerations of the index-1 form; then q and v are moved onto the constraints Phi = 0 and B v = 0, with the
// least change in the mass metric. T^-1 is exact, not a truncated series, so that the order is that of the tableau on
// every group and coordinate map.
//
//   rkmk4    classical method of order 4, with an error estimate of order 3
//   rkmk54   Dormand and Prince 1980, order 5 with an error estimate of order 4 and step size control: internal steps
//            are as long as the tolerances allow, at most integrator.stepSize
//
// The last acceleration of a step is the first of the next one.
#pragma once

#include <array>

#include "integrator/integrator.h"

namespace sigmafmu {

class MuntheKaas final : public Integrator {
 public:
  MuntheKaas(const System& system, const IntegratorSettings& settings, KktPlans plans);

  static constexpr int kMaxStages = 7;
  using Rates = std::array<VectorXd, kMaxStages + 1>;
  struct Tableau {
    int stages;
    double a[kMaxStages][kMaxStages];
    double b[kMaxStages];
    double c[kMaxStages];
    double error[kMaxStages + 1];  // b minus the weights of the embedded method; last the rates at the end of the step
    int order;                     // in h, of that error
  };

 private:
  bool attempt(State& state, double h, const InputSignal& input, StepFailure& failure) override;
  int control_order() const override { return controlled_ ? tableau_.order : 0; }
  bool evaluate(int stage, double elapsed, const VectorXd& q_n, const InputSignal& input, State& state,
                StepFailure& failure);
  bool project(State& state, StepFailure& failure);
  double estimate(double h, int rates);
  double scaled_error(double h, int& worst_body);
  bool accepted(StepFailure& failure) const;

  const Tableau& tableau_;
  const bool embedded_, controlled_;
  Rates theta_rate_, V_rate_;  // of the stages, then at the end of the step
  VectorXd V_n_, theta_, V_, q_, lambda_, u_;
  VectorXd v_, vdot_;  // mixed
};

}  // namespace sigmafmu
