#include "integrator/methods/munthe_kaas.h"

#include <algorithm>
#include <cmath>

namespace sigmafmu {

using Reason = StepFailure::Reason;

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

const Tableau& tableau_of(const IntegratorSettings& settings) {
  return settings.is(Method::rkmk54) ? kDormandPrince : kClassical;
}

ErrorControl error_control_of(const IntegratorSettings& settings) {
  const bool controlled = settings.is(Method::rkmk54) || settings.is(StepControl::error);
  return {controlled ? tableau_of(settings).order : 0};
}

}  // namespace

MuntheKaas::MuntheKaas(Problem& problem)
    : IntegrationMethod(error_control_of(problem.settings)),
      problem_(problem),
      tableau_(tableau_of(problem.settings)),
      embedded_(problem.settings.is(Method::rkmk54)),
      u_(problem.system.make_inputs()) {
  const System& system = problem.system;
  const int n = system.velocity_size();
  for (auto& k : theta_rate_) k.setZero(n);
  for (auto& k : V_rate_) k.setZero(n);
  for (VectorXd* x : {&V_n_, &theta_, &V_, &v_, &vdot_}) x->setZero(n);
  q_.setZero(system.position_size());
  lambda_.setZero(system.constraint_size());
}

bool MuntheKaas::attempt(State& s, double h, const InputSignal& input, StepFailure& failure) {
  const LocalCoordinates& coordinates = *problem_.coordinates;
  const int stages = tableau_.stages;
  coordinates.to_group(s.q, s.v, s.vdot, V_n_, V_rate_[0]);
  theta_rate_[0] = V_n_;
  for (int i = 1; i < stages; ++i) {
    advance(h, tableau_.a[i], i);
    if (!evaluate(i, s.elapsed + tableau_.c[i] * h, s.q, input, s, failure)) return false;
  }
  double error = 0;
  if (embedded_) {
    error = estimate(h, stages);
    failure.measure = scaled_error(h, failure.body);
    if (!accepted(failure)) return false;
  }
  advance(h, tableau_.b, stages);
  if (!problem_.unambiguous(theta_, failure)) return false;
  coordinates.compose(s.q, theta_, q_);
  coordinates.to_mixed(q_, V_, V_rate_[0], v_, vdot_);
  if (!embedded_) coordinates.rate(theta_, V_, theta_rate_[stages]);
  input.value(s.elapsed + h, s.turned, u_);
  if (!project(s, failure) || !accelerations(s.elapsed + h, input, s, failure)) return false;
  if (!embedded_) {
    coordinates.to_group(q_, v_, vdot_, V_, V_rate_[stages]);
    error = estimate(h, stages + 1);
    failure.measure = error / problem_.settings.error_tolerance;
    if (error_control.order > 0 && !accepted(failure)) {
      failure.body = problem_.measure.worst_body(V_);
      return false;
    }
  }
  problem_.commit(s, h, q_, v_, vdot_, lambda_, problem_.solver.evaluation(), error);
  return true;
}

// theta_ and V_ := h times the sum of the first rates, weighted.
void MuntheKaas::combine(double h, const double* weights, int count) {
  theta_.setZero();
  V_.setZero();
  for (int j = 0; j < count; ++j) {
    if (weights[j] == 0.0) continue;
    theta_ += (h * weights[j]) * theta_rate_[j];
    V_ += (h * weights[j]) * V_rate_[j];
  }
}

void MuntheKaas::advance(double h, const double* weights, int count) {
  combine(h, weights, count);
  V_ += V_n_;
}

// Leaves the errors of theta and V in theta_ and V_. That of V moves the body during the step as well.
double MuntheKaas::estimate(double h, int rates) {
  combine(h, tableau_.error, rates);
  return std::max(problem_.measure(theta_), h * problem_.measure(V_));
}

bool MuntheKaas::accepted(StepFailure& failure) const {
  if (failure.measure <= 1.0) return true;
  return failure.because(std::isfinite(failure.measure) ? Reason::inaccurate : Reason::not_finite);
}

// The rates of a stage at (theta_, V_), `elapsed` since the communication point.
bool MuntheKaas::evaluate(int stage, double elapsed, const VectorXd& q_n, const InputSignal& input, State& s,
                          StepFailure& failure) {
  const LocalCoordinates& coordinates = *problem_.coordinates;
  if (!theta_.allFinite() || !V_.allFinite()) return failure.because(Reason::not_finite);
  if (!problem_.unambiguous(theta_, failure)) return false;
  coordinates.compose(q_n, theta_, q_);
  coordinates.to_mixed(q_, V_, V_rate_[0], v_, vdot_);
  if (!accelerations(elapsed, input, s, failure)) return false;
  coordinates.rate(theta_, V_, theta_rate_[stage]);
  coordinates.to_group(q_, v_, vdot_, V_, V_rate_[stage]);
  return true;
}

// vdot_ and lambda_ at (q_, v_).
bool MuntheKaas::accelerations(double elapsed, const InputSignal& input, State& s, StepFailure& failure) {
  input.value(elapsed, s.turned, u_);
  ++s.counters.jacobian_evaluations;
  return problem_.solver.accelerations(q_, v_, u_, vdot_, lambda_) || failure.because(Reason::singular);
}

// Moves q_ and v_ onto the constraints.
bool MuntheKaas::project(State& s, StepFailure& failure) {
  if (problem_.system.constraint_size() == 0) return true;
  const auto assembly = problem_.solver.project_positions(u_, q_);
  s.counters.newton_iterations += assembly.iterations;
  s.counters.jacobian_evaluations += assembly.iterations + 2;
  if (assembly.possible && problem_.solver.project_velocities(q_, u_, v_)) return true;
  return failure.because(Reason::singular);
}

// Largest error of theta/h and V, which theta_ and V_ hold, over the tolerance: both are velocities.
double MuntheKaas::scaled_error(double h, int& worst_body) const {
  const System& system = problem_.system;
  const IntegratorSettings& settings = problem_.settings;
  double largest = 0;
  const auto add = [&](int body, int at, int count) {
    const double tolerance = settings.absolute_tolerance + settings.relative_tolerance * V_n_.segment(at, count).norm();
    const double scaled = std::max(theta_.segment(at, count).norm() / h, V_.segment(at, count).norm()) / tolerance;
    if (scaled <= largest || std::isnan(largest)) return;
    largest = scaled;
    worst_body = body;
  };
  for (int i = 0; i < system.body_count(); ++i) {
    add(i, 6 * i, 3);
    add(i, 6 * i + 3, 3);
  }
  for (int f = 0; f < system.flexible_count(); ++f) {
    add(system.flexible_body(f), system.modal_velocity(f), system.flexible(f).modes());
  }
  return largest;
}

}  // namespace sigmafmu
