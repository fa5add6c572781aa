#include "integrator/munthe_kaas.h"

#include <algorithm>
#include <cmath>

namespace sigmafmu {
namespace {

using Tableau = MuntheKaas::Tableau;

constexpr Tableau kClassical = {
    4, {{0}, {1. / 2}, {0, 1. / 2}, {0, 0, 1}}, {1. / 6, 1. / 3, 1. / 3, 1. / 6}, {0, 1. / 2, 1. / 2, 1}, {}};

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
                                    {71. / 57600, 0, -71. / 16695, 71. / 1920, -17253. / 339200, 22. / 525, -1. / 40}};

// x := sum_j weights[j] k[j]
void combine(const double* weights, const std::array<VectorXd, MuntheKaas::kMaxStages>& k, int count, VectorXd& x) {
  x.setZero();
  for (int j = 0; j < count; ++j) {
    if (weights[j] != 0.0) x += weights[j] * k[j];
  }
}

}  // namespace

MuntheKaas::MuntheKaas(const System& system, const IntegratorSettings& settings)
    : Integrator(system, settings),
      tableau_(settings.is(Method::rkmk54) ? kDormandPrince : kClassical),
      adaptive_(settings.is(Method::rkmk54)),
      solver_(system) {
  const int n = system.velocity_size();
  for (auto& k : theta_rate_) k.setZero(n);
  for (auto& k : V_rate_) k.setZero(n);
  for (VectorXd* x : {&V_n_, &theta_, &V_, &v_, &vdot_}) x->setZero(n);
  q_.setZero(system.position_size());
  lambda_.setZero(system.constraint_size());
  u_.setZero(system.input_size());
}

// Error control: a step is accepted when its error is below the tolerance, and the next one is as long as the error,
// which grows as h^5, lets expect. Steps end at t_end exactly.
bool MuntheKaas::step(State& state, double t_end, const InputSignal& input, StepFailure& failure) {
  if (!adaptive_) return Integrator::step(state, t_end, input, failure);
  constexpr double kSafety = 0.9, kShrink = 0.2, kGrow = 5.0;
  const double smallest = std::ldexp(t_end - state.time, -settings_.max_halvings) * 0.75;
  while (state.time < t_end) {
    const double remaining = t_end - state.time;
    const double proposed = state.next_step > 0 ? state.next_step : remaining;
    // Rather two equal steps than a tiny last one.
    const double h = proposed >= remaining ? remaining : std::min(proposed, 0.5 * remaining + 0.25 * proposed);
    const bool last = h == remaining;
    const bool done = attempt(state, last ? t_end : state.time + h, h, input, failure);
    const double factor =
        failure.measure > 0 && failure.reason != StepFailure::Reason::rotation && std::isfinite(failure.measure)
            ? std::clamp(kSafety * std::pow(failure.measure, -0.2), kShrink, kGrow)
            : (done ? kGrow : 0.5);
    if (done) {
      state.next_step = last ? std::max(state.next_step, factor * h) : factor * h;
      continue;
    }
    state.next_step = std::min(factor, 0.9) * h;
    if (state.next_step < smallest) return false;
    ++state.counters.retries;
  }
  return true;
}

bool MuntheKaas::attempt(State& state, double t, double h, const InputSignal& input, StepFailure& failure) {
  failure = {StepFailure::Reason::none, t, h, -1, 0, 0};
  coordinates_->to_group(state.q, state.v, state.vdot, V_n_, V_rate_[0]);
  theta_rate_[0] = V_n_;
  double weights[kMaxStages];
  const auto scaled = [&](const double* from) {
    for (int j = 0; j < tableau_.stages; ++j) weights[j] = h * from[j];
    return weights;
  };
  const int stages = tableau_.stages;
  for (int s = 1; s < stages; ++s) {
    combine(scaled(tableau_.a[s]), theta_rate_, s, theta_);
    combine(weights, V_rate_, s, V_);
    V_ += V_n_;
    if (!evaluate(s, state.time + tableau_.c[s] * h, state.q, input, state, failure)) return false;
  }
  if (adaptive_) {
    combine(scaled(tableau_.error), theta_rate_, stages, theta_);
    combine(weights, V_rate_, stages, V_);
    const double error = scaled_error(h, failure.body);
    failure.measure = error;
    if (!(error <= 1.0)) {
      failure.reason = std::isfinite(error) ? StepFailure::Reason::inaccurate : StepFailure::Reason::not_finite;
      return false;
    }
  }
  combine(scaled(tableau_.b), theta_rate_, stages, theta_);
  combine(weights, V_rate_, stages, V_);
  V_ += V_n_;
  if (!unambiguous(theta_, failure)) return false;
  coordinates_->compose(state.q, theta_, q_);
  coordinates_->to_mixed(q_, V_, V_rate_[0], v_, vdot_);
  if (!project(state, failure)) return false;
  input.value(t, u_);
  ++state.counters.jacobian_evaluations;
  if (!solver_.accelerations(q_, v_, u_, vdot_, lambda_)) {
    failure.reason = StepFailure::Reason::singular;
    return false;
  }
  state.vdot = vdot_;
  state.lambda = lambda_;
  commit(state, t, h, q_, v_, solver_.evaluation());
  return true;
}

// The rates of a stage at (theta_, V_), time t.
bool MuntheKaas::evaluate(int stage, double t, const VectorXd& q_n, const InputSignal& input, State& state,
                          StepFailure& failure) {
  if (!theta_.allFinite() || !V_.allFinite()) {
    failure.reason = StepFailure::Reason::not_finite;
    return false;
  }
  if (!unambiguous(theta_, failure)) return false;
  coordinates_->compose(q_n, theta_, q_);
  coordinates_->to_mixed(q_, V_, V_rate_[0], v_, vdot_);
  input.value(t, u_);
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
