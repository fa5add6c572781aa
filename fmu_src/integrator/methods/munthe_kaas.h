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

#include "integrator/method.h"
#include "integrator/problem.h"

namespace sigmafmu {

class MuntheKaas final : public IntegrationMethod {
 public:
  explicit MuntheKaas(Problem& problem);

  void make_state(State&) const override {}
  void start(State&, const VectorXd&, const VectorXd&, const VectorXd&) const override {}
  [[nodiscard]] bool attempt(State& state, double h, const InputSignal& input, StepFailure& failure) override;
  void jump(State&, const VectorXd&) const override {}

  static constexpr int kMaxStages = 7;
  struct Tableau {
    int stages;
    double a[kMaxStages][kMaxStages];
    double b[kMaxStages];
    double c[kMaxStages];
    double error[kMaxStages + 1];  // b minus the weights of the embedded method; last the rates at the end of the step
    int order;                     // in h, of that error
  };

 private:
  bool evaluate(int stage, double elapsed, const VectorXd& q_n, const InputSignal& input, State& state,
                StepFailure& failure);
  void combine(double h, const double* weights, int count);
  void advance(double h, const double* weights, int count);
  bool accelerations(double elapsed, const InputSignal& input, State& state, StepFailure& failure);
  bool project(State& state, StepFailure& failure);
  double estimate(double h, int rates);
  double scaled_error(double h, int& worst_body) const;
  bool accepted(StepFailure& failure) const;

  Problem& problem_;
  const Tableau& tableau_;
  const bool embedded_;
  std::array<VectorXd, kMaxStages + 1> theta_rate_, V_rate_;  // of the stages, then at the end of the step
  Inputs u_;
  VectorXd V_n_, theta_, V_, q_, lambda_;
  VectorXd v_, vdot_;  // mixed
};

}  // namespace sigmafmu
