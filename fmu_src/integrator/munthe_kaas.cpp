#include "integrator/munthe_kaas.h"

#include <algorithm>
#include <cmath>

namespace sigmafmu {
namespace {

using Tableau = MuntheKaas::Tableau;

// With the rates at the end of the step, which the next one needs anyhow, weights (1/6, 1/3, 1/3, 0, 1/6) have order 3.
constexpr Tableau kClassical = {4,
                                {{0}, {1. / 2}, {0, 1. / 2}, {0, 0, 1}},
                                {1. / 6, 1. / 3, 1. / 3, 1. / 6},
                                {0, 1. / 2, 1. / 2, 1},
                                {0, 0, 0, 1. / 6, -1. / 6},
                                4};

constexpr Tableau kDormandPrince = {7,
                                    {{0},
                                     {1. / 5},
                                     {3. / 40, 9. / 40},
                                     {44. / 45, -56. / 15, 32. / 9},
                                     {19372. / 6561, -25360. / 2187, 64448. / 6561, -212. / 729},
                                     {9017. / 3168, -355. / 33, 46732. / 5247, 49. / 176, -5103. / 18656},
                                     {35. / 384, 0, 500. / 1113, 125. / 192, -2187. / 6784, 11. / 84}},
                                    {35. / 384, 0, 500. / 1113, 125. / 192, -2187. / 6784, 11. / 84, 0},
                                    {0, 1. / 5, 3. / 10, 4. / 5, 8. / 9, 1, 1},
                                    {71. / 57600, 0, -71. / 16695, 71. / 1920, -17253. / 339200, 22. / 525, -1. / 40},
                                    5};

// x := sum_j weights[j] k[j]
void combine(const double* weights, const MuntheKaas::Rates& k, int count, VectorXd& x) {
  x.setZero();
  for (int j = 0; j < count; ++j) {
    if (weights[j] != 0.0) x += weights[j] * k[j];
  }
}

}  // namespace

MuntheKaas::MuntheKaas(const System& system, const IntegratorSettings& settings, KktPlans plans)
    : Integrator(system, settings, plans),
      tableau_(settings.is(Method::rkmk54) ? kDormandPrince : kClassical),
      embedded_(settings.is(Method::rkmk54)),
      controlled_(embedded_ || settings.is(StepControl::error)) {
  const int n = system.velocity_size();
  for (auto& k : theta_rate_) k.setZero(n);
  for (auto& k : V_rate_) k.setZero(n);
  for (VectorXd* x : {&V_n_, &theta_, &V_, &v_, &vdot_}) x->setZero(n);
  q_.setZero(system.position_size());
  lambda_.setZero(system.constraint_size());
  u_.setZero(system.input_size());
}

bool MuntheKaas::attempt(State& state, double h, const InputSignal& input, StepFailure& failure) {
  failure = {StepFailure::Reason::none, state.time + h, h, -1, 0, 0};
  coordinates_->to_group(state.q, state.v, state.vdot, V_n_, V_rate_[0]);
  theta_rate_[0] = V_n_;
  double weights[kMaxStages];
  const auto scaled = [&](const double* from) {
    for (int j = 0; j < kMaxStages; ++j) weights[j] = h * from[j];
    return weights;
  };
  const int stages = tableau_.stages;
  for (int s = 1; s < stages; ++s) {
    combine(scaled(tableau_.a[s]), theta_rate_, s, theta_);
    combine(weights, V_rate_, s, V_);
    V_ += V_n_;
    if (!evaluate(s, state.elapsed + tableau_.c[s] * h, state.q, input, state, failure)) return false;
  }
  double error = 0;
  if (embedded_) {
    error = estimate(h, stages);
    failure.measure = scaled_error(h, failure.body);
    if (!accepted(failure)) return false;
  }
  combine(scaled(tableau_.b), theta_rate_, stages, theta_);
  combine(weights, V_rate_, stages, V_);
  V_ += V_n_;
  if (!unambiguous(theta_, failure)) return false;
  coordinates_->compose(state.q, theta_, q_);
  coordinates_->to_mixed(q_, V_, V_rate_[0], v_, vdot_);
  if (!embedded_) coordinates_->rate(theta_, V_, theta_rate_[stages]);
  if (!project(state, failure)) return false;
  input.value(state.elapsed + h, u_);
  ++state.counters.jacobian_evaluations;
  if (!solver_.accelerations(q_, v_, u_, vdot_, lambda_)) {
    failure.reason = StepFailure::Reason::singular;
    return false;
  }
  if (!embedded_) {
    coordinates_->to_group(q_, v_, vdot_, V_, V_rate_[stages]);
    error = estimate(h, stages + 1);
    failure.measure = error / settings_.error_tolerance;
    if (controlled_ && !accepted(failure)) {
      failure.body = measure_.worst_body(V_);
      return false;
    }
  }
  state.vdot = vdot_;
  state.lambda = lambda_;
  commit(state, h, q_, v_, solver_.evaluation(), error);
  return true;
}

bool MuntheKaas::accepted(StepFailure& failure) const {
  if (failure.measure <= 1.0) return true;
  failure.reason = std::isfinite(failure.measure) ? StepFailure::Reason::inaccurate : StepFailure::Reason::not_finite;
  return false;
}

// Leaves the errors of theta and V in theta_ and V_. That of V moves the body during the step as well.
double MuntheKaas::estimate(double h, int rates) {
  double weights[kMaxStages + 1];
  for (int j = 0; j < rates; ++j) weights[j] = h * tableau_.error[j];
  combine(weights, theta_rate_, rates, theta_);
  combine(weights, V_rate_, rates, V_);
  return std::max(measure_(theta_), h * measure_(V_));
}

// The rates of a stage at (theta_, V_), `elapsed` since the communication point.
bool MuntheKaas::evaluate(int stage, double elapsed, const VectorXd& q_n, const InputSignal& input, State& state,
                          StepFailure& failure) {
  if (!theta_.allFinite() || !V_.allFinite()) {
    failure.reason = StepFailure::Reason::not_finite;
    return false;
  }
  if (!unambiguous(theta_, failure)) return false;
  coordinates_->compose(q_n, theta_, q_);
  coordinates_->to_mixed(q_, V_, V_rate_[0], v_, vdot_);
  input.value(elapsed, u_);
  ++state.counters.jacobian_evaluations;
  if (!solver_.accelerations(q_, v_, u_, vdot_, lambda_)) {
    failure.reason = StepFailure::Reason::singular;
    return false;
  }
  coordinates_->rate(theta_, V_, theta_rate_[stage]);
  coordinates_->to_group(q_, v_, vdot_, V_, V_rate_[stage]);
  return true;
}

bool MuntheKaas::project(State& state, StepFailure& failure) {
  if (system_.constraint_size() == 0) return true;
  const auto assembly = solver_.project_positions(q_);
  state.counters.newton_iterations += assembly.iterations;
  state.counters.jacobian_evaluations += assembly.iterations + 2;
  if (assembly.possible && solver_.project_velocities(q_, v_)) return true;
  failure.reason = StepFailure::Reason::singular;
  return false;
}

// Largest error of theta/h and V, which theta_ and V_ hold, over the tolerance: both are velocities.
double MuntheKaas::scaled_error(double h, int& worst_body) {
  double largest = 0;
  const auto add = [&](int body, int at, int count) {
    const double tolerance =
        settings_.absolute_tolerance + settings_.relative_tolerance * V_n_.segment(at, count).norm();
    const double scaled = std::max(theta_.segment(at, count).norm() / h, V_.segment(at, count).norm()) / tolerance;
    if (scaled <= largest || std::isnan(largest)) return;
    largest = scaled;
    worst_body = body;
  };
  for (int i = 0; i < system_.body_count(); ++i) {
    add(i, 6 * i, 3);
    add(i, 6 * i + 3, 3);
  }
  for (int f = 0; f < system_.flexible_count(); ++f) {
    add(system_.flexible_body(f), system_.modal_velocity(f), system_.flexible(f).modes());
  }
  return largest;
}

}  // namespace sigmafmu
