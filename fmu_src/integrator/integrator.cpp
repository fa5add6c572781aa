#include "integrator/integrator.h"

#include <algorithm>
#include <cmath>

#include "integrator/bliedf.h"
#include "integrator/generalized_alpha.h"
#include "integrator/munthe_kaas.h"

namespace sigmafmu {
namespace {

constexpr double kPi = 3.14159265358979323846;

}  // namespace

Integrator::Integrator(const System& system, const IntegratorSettings& settings, KktPlans plans)
    : system_(system),
      settings_(settings),
      coordinates_(make_local_coordinates(system, settings)),
      solver_(system, plans),
      measure_(system) {
  jump_.setZero(system.velocity_size());
}

State Integrator::make_state() const {
  State s;
  s.q.setZero(system_.position_size());
  for (int i = 0; i < system_.body_count(); ++i) s.q[7 * i + 3] = 1.0;
  for (VectorXd* x : {&s.v, &s.vdot}) x->setZero(system_.velocity_size());
  s.lambda.setZero(system_.constraint_size());
  s.angle.setZero(system_.joint_count());
  return s;
}

bool Integrator::initialize(State& s, const InputSignal& input) {
  const VectorXd assembled = s.q;
  coordinates_->store(assembled, s.q);
  VectorXd u(system_.input_size()), jerk(system_.velocity_size()), V, Vdot;
  input.value(s.elapsed, u);
  if (!solver_.accelerations(s.q, s.v, u, s.vdot, s.lambda)) return false;
  const Evaluation& e = solver_.evaluation();
  for (int j = 0; j < system_.joint_count(); ++j) {
    const Joint& joint = system_.joint(j);
    if (joint.type() == JointType::revolute) {
      s.angle[j] = joint.coordinate(system_.attachment(e, j, 0), system_.attachment(e, j, 1));
    }
  }
  if (!solver_.jerk(s.q, s.v, s.vdot, input, s.elapsed, jerk) || !jerk.allFinite()) return false;
  coordinates_->to_group(s.q, s.v, s.vdot, V, Vdot);
  coordinates_->jerk_to_group(s.q, s.v, s.vdot, jerk);
  s.last_step = settings_.step_size;
  remember_start(s, V, Vdot, jerk);
  return true;
}

void Integrator::shift_accelerations(State& s, const VectorXd& jump) { s.vdot += jump; }

const VectorXd& Integrator::jump_of_group(const State& s, const VectorXd& jump) {
  jump_ = jump;
  coordinates_->turn_to_group(s.q, jump_);
  return jump_;
}

bool Integrator::step(State& state, double h, const InputSignal& input, StepFailure& failure) {
  return control_order() > 0 ? controlled_step(state, h, input, failure) : fixed_step(state, h, input, failure);
}

bool Integrator::fixed_step(State& state, double remaining, const InputSignal& input, StepFailure& failure) {
  double h = remaining;
  const double smallest = std::ldexp(h, -settings_.max_halvings) * 0.75;
  while (true) {
    const bool last = h > 0.75 * remaining;
    if (last) h = remaining;
    if (attempt(state, h, input, failure)) {
      if (last) return true;
      remaining -= h;
      continue;
    }
    h *= 0.5;
    if (h < smallest) return false;
    ++state.counters.retries;
  }
}

// The next step is as long as the error lets expect.
bool Integrator::controlled_step(State& state, double remaining, const InputSignal& input, StepFailure& failure) {
  constexpr double kSafety = 0.9, kShrink = 0.2;
  const double grow = largest_growth();
  const double smallest = std::ldexp(remaining, -settings_.max_halvings) * 0.75;
  while (true) {
    const double proposed = state.next_step > 0 ? state.next_step : remaining;
    // Rather two equal steps than a tiny last one.
    const double h = proposed >= remaining ? remaining : std::min(proposed, 0.5 * remaining + 0.25 * proposed);
    const bool last = h == remaining;
    const bool done = attempt(state, h, input, failure);
    const bool measured = done || failure.reason == StepFailure::Reason::inaccurate;
    const double factor =
        measured ? std::clamp(kSafety * std::pow(failure.measure, -1.0 / control_order()), kShrink, grow) : 0.5;
    if (done) {
      state.next_step = last ? std::max(state.next_step, factor * h) : factor * h;
      if (last) return true;
      remaining -= h;
      continue;
    }
    state.next_step = std::min(factor, 0.9) * h;
    if (state.next_step < smallest) return false;
    ++state.counters.retries;
  }
}

bool Integrator::unambiguous(const VectorXd& theta, StepFailure& failure) const {
  int body = -1;
  const double angle = coordinates_->largest_rotation(theta, body);
  if (angle < kPi) return true;
  failure.reason = StepFailure::Reason::rotation;
  failure.body = body;
  failure.measure = angle;
  return false;
}

void Integrator::commit(State& s, double h, const VectorXd& q, const VectorXd& v, const Evaluation& e, double error) {
  for (int j = 0; j < system_.joint_count(); ++j) {  // the turn nearest to the angle that the rate predicts
    const Joint& joint = system_.joint(j);
    if (joint.type() != JointType::revolute) continue;
    const auto &k1 = system_.attachment(e, j, 0), &k2 = system_.attachment(e, j, 1);
    const double wrapped = joint.coordinate(k1, k2);
    const double predicted = s.angle[j] + h * joint.coordinate_rate(k1, k2);
    s.angle[j] = wrapped + 2 * kPi * std::round((predicted - wrapped) / (2 * kPi));
  }
  s.time += h;
  s.elapsed += h;
  coordinates_->store(q, s.q);
  s.v = v;
  s.error = error;
  s.largest_error = std::max(s.largest_error, error);
  ++s.counters.steps;
}

std::unique_ptr<Integrator> make_integrator(const System& system, const IntegratorSettings& settings, KktPlans plans) {
  switch (static_cast<Method>(settings.method)) {
    case Method::rkmk4:
    case Method::rkmk54:
      return std::make_unique<MuntheKaas>(system, settings, plans);
    case Method::bliedf2:
      return std::make_unique<BLieDF>(system, settings, plans);
    default:
      return std::make_unique<GeneralizedAlpha>(system, settings, plans);
  }
}

}  // namespace sigmafmu
