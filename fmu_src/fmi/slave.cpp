#include "fmi/slave.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "solve/start/dependent_equations.h"
#include "text/text.h"

namespace sigmafmu {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kMaxInternalSteps = 1e9;  // per communication step
constexpr double kLargeError = 3e-4;       // of an internal step, relative to the mechanism's size: warn
constexpr double kLargeTurn = 1.0;         // of a body in an internal step [rad]: warn

// Communication points come from masters that add them up, multiply or count nanoseconds: their rounding, which grows
// with the time, is no mistake.
bool same_time(double a, double b, double step) {
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  return std::abs(a - b) <= 1e-4 * step + 4 * kEpsilon * std::max(std::abs(a), std::abs(b));
}

Mechanism with_joint_values(Mechanism mechanism, KktPlans plans) {
  find_joint_values(mechanism.multibody, plans);
  return mechanism;
}

}  // namespace

Slave::Slave(Mechanism defaults, std::string identity, Reporter report)
    : defaults_(with_joint_values(std::move(defaults), plans_)),
      identity_(std::move(identity)),
      report_(std::move(report)),
      mechanism_(defaults_),
      engine_(std::make_unique<Engine>(mechanism_.multibody, mechanism_.integrator, plans_)) {
  variables_ = make_variables(mechanism_, engine_->system);
  for (unsigned i = 0; i < variables_.size(); ++i) {
    if (variables_[i].causality == Causality::parameter) parameter_references_.push_back(i);
  }
  reset();
}

void Slave::reset() {
  mechanism_ = defaults_;
  data_ = Snapshot{};
  build();
  read_parameters();
}

// The parameters with the experiment's tolerance in place of the error tolerance of methods that control their error,
// where nothing else was set.
IntegratorSettings Slave::settings() const {
  IntegratorSettings s = mechanism_.integrator;
  if (data_.tolerance == 0) return s;
  const IntegratorSettings& d = defaults_.integrator;
  if (s.is(Method::rkmk54)) {
    const double relative = std::min(data_.tolerance, 1e-2);
    if (s.absolute_tolerance == d.absolute_tolerance) s.absolute_tolerance *= relative / d.relative_tolerance;
    if (s.relative_tolerance == d.relative_tolerance) s.relative_tolerance = relative;
  }
  if (s.error_tolerance == d.error_tolerance) s.error_tolerance = data_.tolerance;
  return s;
}

// New engine and zero state for the present parameters; inputs keep their values.
void Slave::build() {
  engine_ = std::make_unique<Engine>(mechanism_.multibody, settings(), plans_);
  const System& system = engine_->system;
  data_.state = engine_->integrator->make_state();
  if (data_.input.derivative[0].size() != system.input_size()) data_.input = InputSignal(system.input_size());
  data_.last_input = data_.input.derivative[0];
  data_.vdot_before_jump.setZero(system.velocity_size());
  data_.parameter_jump = false;
  data_.stale = true;
  outputs_.evaluation = system.make_evaluation();
  for (VectorXd* x : {&outputs_.vdot, &vdot_before_, &vdot_after_}) x->setZero(system.velocity_size());
  for (VectorXd* x : {&outputs_.lambda, &lambda_scratch_}) x->setZero(system.constraint_size());
  outputs_.u.setZero(system.input_size());
  outputs_.has_motion = outputs_.has_accelerations = false;
}

void Slave::read_parameters() {
  data_.parameters.clear();
  for (unsigned r : parameter_references_) data_.parameters.push_back(variables_[r].value(mechanism_));
}

// True when a fixed parameter changed, which needs a new engine.
bool Slave::apply_parameters(const std::vector<double>& values) {
  bool rebuild = false;
  for (std::size_t i = 0; i < parameter_references_.size(); ++i) {
    const Variable& v = variables_[parameter_references_[i]];
    if (v.variability == Variability::fixed && v.value(mechanism_) != values[i]) rebuild = true;
    v.set_value(mechanism_, values[i]);
  }
  return rebuild;
}

void Slave::setup_experiment(double start, bool has_stop, double stop, double tolerance) {
  if (!std::isfinite(start)) fail<Refused>("startTime is ", start, " s; it must be finite.");
  if (has_stop && !(stop >= start)) {
    fail<Refused>("stopTime is ", stop, " s; it must not be before startTime ", start, " s.");
  }
  if (!(tolerance >= 0) || !std::isfinite(tolerance)) {
    fail<Refused>("tolerance is ", tolerance, "; it must be finite and not negative.");
  }
  data_.tolerance = tolerance;
  data_.start_time = start;
  data_.has_stop_time = has_stop;
  data_.stop_time = stop;
  data_.stale = true;
}

void Slave::enter_initialization() { data_.phase = Phase::initialization; }

void Slave::exit_initialization() {
  ensure_initialized();
  data_.phase = Phase::step;
  warn_about_initial_values();
  warn_about_settings();
}

// Everything from the parameters and initial values; the slave stays as it was (stale) when that fails.
void Slave::initialize() {
  try {
    validate(mechanism_.multibody);
    build();
    State& s = data_.state;
    s.time = data_.start_time;
    assemble(mechanism_.multibody, engine_->system, engine_->solver, s.q, s.v);
  } catch (const std::exception& e) {
    throw Discarded(e.what());
  }
  if (!engine_->integrator->initialize(data_.state, data_.input)) {
    const State& s = data_.state;
    data_.input.value(s.elapsed, outputs_.u);
    accelerations_or_discard(s.q, s.v, outputs_.u, outputs_.vdot, outputs_.lambda);
    throw Discarded("The derivatives of the accelerations at the start overflow.");
  }
  count_turns(mechanism_.multibody, data_.state.angle);
  data_.last_input = data_.input.derivative[0];
  data_.stale = false;
  warned_of_error_ = warned_of_spin_ = false;
}

void Slave::ensure_initialized() {
  if (data_.stale) initialize();
}

const Variable& Slave::variable(unsigned reference) const {
  if (reference >= variables_.size()) {
    fail<Refused>("Value reference ", reference, " is unknown; this FMU has 0 to ", variables_.size() - 1, ".");
  }
  return variables_[reference];
}

View Slave::view() const {
  const State& s = data_.state;
  return {mechanism_, engine_->system, s, s.q, s.v, outputs_.evaluation, outputs_.vdot, outputs_.lambda};
}

void Slave::accelerations_or_discard(const VectorXd& q, const VectorXd& v, const VectorXd& u, VectorXd& vdot,
                                     VectorXd& lambda) {
  if (engine_->solver.accelerations(q, v, u, vdot, lambda)) return;
  const auto& definition = mechanism_.multibody;
  fail<Discarded>("The accelerations at t = ", time(), " s cannot be computed. ",
                  engine_->solver.singular() ? describe_singularity(definition, engine_->system, q)
                                             : "A velocity or a force overflows.");
}

void Slave::evaluate(bool accelerations) {
  ensure_initialized();
  const State& s = data_.state;
  if (!outputs_.has_motion) {
    engine_->system.evaluate(s.q, s.v, outputs_.evaluation);
    outputs_.has_motion = true;
  }
  if (accelerations && !outputs_.has_accelerations) {
    data_.input.value(s.elapsed, outputs_.u);
    accelerations_or_discard(s.q, s.v, outputs_.u, outputs_.vdot, outputs_.lambda);
    outputs_.has_accelerations = true;
  }
}

void Slave::get(const unsigned* references, std::size_t count, bool integer, double* values) {
  for (std::size_t i = 0; i < count; ++i) {
    const Variable& v = variable(references[i]);
    if (v.integer != integer) {
      fail<Refused>(v.name, " is ", v.integer ? "an Integer" : "a Real", "; it was read as ",
                    integer ? "an Integer." : "a Real.");
    }
    if (v.output) {
      evaluate(v.needs_accelerations);
      values[i] = v.output(view(), v.object, v.component);
    } else if (v.input >= 0) {
      values[i] = data_.input.derivative[0][v.input];
    } else {
      values[i] = v.value(mechanism_);
    }
  }
}

void Slave::require_settable(const Variable& v) const {
  if (v.causality == Causality::output) fail<Refused>(v.name, " is an output; it cannot be set.");
  if (v.causality == Causality::local) fail<Refused>(v.name, " is computed; it cannot be set.");
  if (v.variability == Variability::fixed && data_.phase != Phase::instantiated &&
      data_.phase != Phase::initialization) {
    fail<Refused>(v.name, " is a fixed parameter; it can be set only before the simulation starts, or after a reset.");
  }
}

void Slave::set(const unsigned* references, std::size_t count, bool integer, const double* values) {
  bool changes_input = false, changes_parameter = false;
  for (std::size_t i = 0; i < count; ++i) {  // check all before changing any
    const Variable& v = variable(references[i]);
    if (v.integer != integer) {
      fail<Refused>(v.name, " is ", v.integer ? "an Integer" : "a Real", "; it was set as ",
                    integer ? "an Integer." : "a Real.");
    }
    require_settable(v);
    const std::string complaint = v.complaint(values[i]);
    if (!complaint.empty()) throw Refused(complaint);
    if (v.input >= 0) {
      changes_input = true;
    } else if (v.value(mechanism_) != values[i]) {
      changes_parameter = true;
    }
  }
  const bool running = data_.phase == Phase::step;
  if (changes_parameter && running && !data_.parameter_jump) {
    accelerations_or_discard(data_.state.q, data_.state.v, data_.last_input, data_.vdot_before_jump, lambda_scratch_);
    data_.parameter_jump = true;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Variable& v = variables_[references[i]];
    if (v.input >= 0) {
      data_.input.derivative[0][v.input] = values[i];
    } else {
      v.set_value(mechanism_, values[i]);
    }
  }
  if (changes_input) {
    data_.state.elapsed = 0;
    outputs_.has_accelerations = false;
  }
  if (changes_parameter) {
    read_parameters();
    outputs_.has_motion = outputs_.has_accelerations = false;
  }
  if (running) {
    if (changes_parameter) engine_->system.set_values(mechanism_.multibody);
  } else if (changes_input || changes_parameter) {
    data_.stale = true;
  }
}

void Slave::set_input_derivatives(const unsigned* references, std::size_t count, const int* orders,
                                  const double* values) {
  for (std::size_t i = 0; i < count; ++i) {
    const Variable& v = variable(references[i]);
    if (v.input < 0) fail<Refused>(v.name, " is no input; derivatives can be set for inputs alone.");
    if (orders[i] < 1 || orders[i] > InputSignal::kMaxDerivative) {
      fail<Refused>("The derivative order of ", v.name, " is ", orders[i], "; it must be 1 to ",
                    InputSignal::kMaxDerivative, ".");
    }
    if (!std::isfinite(values[i])) {
      fail<Refused>("Derivative ", orders[i], " of ", v.name, " is ", values[i], "; it must be finite.");
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    data_.input.derivative[orders[i]][variables_[references[i]].input] = values[i];
  }
  data_.state.elapsed = 0;
  if (data_.phase != Phase::step) data_.stale = true;
}

const Variable& Slave::real_output(unsigned reference, const char* purpose) const {
  const Variable& v = variable(reference);
  if (!v.output || v.integer) fail<Refused>(v.name, " is no Real output; ", purpose, " of Real outputs alone.");
  return v;
}

void Slave::get_output_derivatives(const unsigned* references, std::size_t count, const int* orders, double* values) {
  bool accelerations = false;
  for (std::size_t i = 0; i < count; ++i) {
    const Variable& v = real_output(references[i], "derivatives can be had");
    if (orders[i] != 1) fail<Refused>("The derivative order of ", v.name, " is ", orders[i], "; it must be 1.");
    accelerations = accelerations || v.needs_accelerations;
  }
  evaluate(true);  // vdot
  const State& s = data_.state;
  const System& system = engine_->system;
  VectorXd q(s.q.size()), v(s.v.size()), vdot(s.v.size()), lambda(s.lambda.size()), u(system.input_size());
  Evaluation e = system.make_evaluation();
  std::fill_n(values, count, 0.0);
  const double step = engine_->solver.difference_time(s.v);
  for (double sign : {-1.0, 1.0}) {  // central difference along the motion; outputs are functions of (q, v, u) alone
    engine_->solver.displace(s.q, s.v, outputs_.vdot, sign * step, q, v);
    data_.input.value(s.elapsed + sign * step, u);
    if (accelerations) accelerations_or_discard(q, v, u, vdot, lambda);
    system.evaluate(q, v, e);
    const View displaced{mechanism_, system, s, q, v, e, vdot, lambda};
    for (std::size_t i = 0; i < count; ++i) {
      const Variable& variable = variables_[references[i]];
      values[i] += sign * variable.output(displaced, variable.object, variable.component) / (2 * step);
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Variable& variable = variables_[references[i]];
    if (variable.rate) values[i] = variable.rate(view(), variable.object, variable.component);
  }
}

void Slave::directional_derivative(const unsigned* outputs, std::size_t output_count, const unsigned* inputs,
                                   std::size_t input_count, const double* direction, double* derivative) {
  evaluate(false);
  const State& s = data_.state;
  const System& system = engine_->system;
  VectorXd du = VectorXd::Zero(system.input_size());
  for (std::size_t i = 0; i < input_count; ++i) {
    const Variable& v = variable(inputs[i]);
    if (v.input < 0) fail<Refused>(v.name, " is no input; directional derivatives exist with respect to inputs alone.");
    if (!std::isfinite(direction[i])) fail<Refused>("The direction of ", v.name, " must be finite.");
    du[v.input] += direction[i];
  }
  for (std::size_t i = 0; i < output_count; ++i) real_output(outputs[i], "directional derivatives exist");
  // Accelerations and multipliers are affine in u with a slope that q alone determines: a difference over any length is
  // exact, and without velocities it loses no digits to the gyroscopic terms.
  const VectorXd rest = VectorXd::Zero(s.v.size());
  VectorXd vdot(s.v.size()), lambda(s.lambda.size());
  Evaluation e = system.make_evaluation();
  system.evaluate(s.q, rest, e);
  std::fill_n(derivative, output_count, 0.0);
  for (double sign : {-1.0, 1.0}) {
    accelerations_or_discard(s.q, rest, sign * du, vdot, lambda);
    const View probed{mechanism_, system, s, s.q, rest, e, vdot, lambda};
    for (std::size_t i = 0; i < output_count; ++i) {
      const Variable& v = variables_[outputs[i]];
      if (v.needs_accelerations) derivative[i] += 0.5 * sign * v.output(probed, v.object, v.component);
    }
  }
}

// After a jump of inputs or tunable parameters vdot and the algorithmic acceleration jump with the loads; without
// this a step would take the old loads for half of the new ones.
void Slave::absorb_jump() {
  State& s = data_.state;
  data_.input.value(s.elapsed, outputs_.u);
  if (!data_.parameter_jump && outputs_.u == data_.last_input) return;
  if (data_.parameter_jump) {
    vdot_before_ = data_.vdot_before_jump;
  } else {
    accelerations_or_discard(s.q, s.v, data_.last_input, vdot_before_, lambda_scratch_);
  }
  accelerations_or_discard(s.q, s.v, outputs_.u, vdot_after_, lambda_scratch_);
  vdot_after_ -= vdot_before_;
  engine_->integrator->shift_accelerations(s, vdot_after_);
  data_.parameter_jump = false;
  data_.last_input = outputs_.u;
}

bool Slave::do_step(double t, double H) {
  State& s = data_.state;
  if (!std::isfinite(t) || !std::isfinite(H) || H < 0) {
    fail<Refused>("The communication step from ", t, " s by ", H, " s is not possible; both must be finite, the step ",
                  "not negative.");
  }
  const double h = mechanism_.integrator.step_size;
  if (!same_time(t, s.time, std::max(H, h))) {
    fail<Refused>("The communication point is ", t, " s, but the FMU is at ", s.time, " s.");
  }
  if (data_.has_stop_time && t + H > data_.stop_time && !same_time(t + H, data_.stop_time, std::max(H, h))) {
    fail<Refused>("The communication step ends at ", t + H, " s, after the stopTime ", data_.stop_time, " s.");
  }
  const double ratio = H / h;
  if (ratio > kMaxInternalSteps) {
    fail<Refused>("The communication step is ", H, " s; with integrator.stepSize ", h, " s at most ",
                  kMaxInternalSteps * h, " s is allowed.");
  }
  if (H == 0) {
    s.time = t;
    return true;
  }
  const std::int64_t n = std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(ratio * (1 - 1e-9) - 1e-9)));
  const double length = H / static_cast<double>(n);
  s.time = t;
  s.elapsed = 0;
  absorb_jump();
  outputs_.has_motion = outputs_.has_accelerations = false;
  const std::int64_t retries = s.counters.retries;
  bool ok = true;
  for (std::int64_t i = 1; ok && i <= n; ++i) {
    StepFailure failure;
    ok = engine_->integrator->step(s, length, data_.input, failure);
    if (ok) {
      s.elapsed = H * (static_cast<double>(i) / static_cast<double>(n));  // not a sum of internal steps
      s.time = t + s.elapsed;
    } else {
      describe_failure(failure);
    }
  }
  data_.input.value(s.elapsed, data_.last_input);
  data_.input.derivative[0] = data_.last_input;  // where the derivatives led is what holds from here on
  for (int k = 1; k <= InputSignal::kMaxDerivative; ++k) data_.input.derivative[k].setZero();
  s.elapsed = 0;
  if (ok) warn_about_accuracy(s.time, length);
  if (reports_events && s.counters.retries > retries) {
    std::ostringstream text = text_stream(6);
    text << "The communication step to " << t + H << " s needed " << s.counters.retries - retries
         << " repeated internal steps with half the step size.";
    report_(Report::event, text.str());
  }
  return ok;
}

void Slave::describe_failure(const StepFailure& f) {
  std::ostringstream text = text_stream(10);
  const char* body = f.body >= 0 ? mechanism_.multibody.bodies[f.body].name.c_str() : "";
  text << "The internal step to t = " << f.time << " s failed even with a step size of " << f.step_size << " s: ";
  const bool finite = std::isfinite(f.measure);
  switch (finite ? f.reason : StepFailure::Reason::not_finite) {
    case StepFailure::Reason::rotation:
      text << "body " << body << " would turn by " << f.measure << " rad in it, less than pi is allowed";
      break;
    case StepFailure::Reason::singular:
      text << "the iteration matrix is singular";
      break;
    case StepFailure::Reason::inaccurate:
      text << "its error is estimated as " << f.measure << " times the tolerance, largest in body " << body;
      break;
    case StepFailure::Reason::not_finite:
      text << "the motion of body " << body << " is not finite";
      break;
    default:
      text << "Newton's method did not converge in " << f.iterations
           << (f.iterations == 1 ? " iteration" : " iterations") << ", the last increment of body " << body << " is "
           << f.measure << " times the tolerance";
  }
  text << "; the last successful time is " << data_.state.time << " s.";
  if (f.reason != StepFailure::Reason::not_finite) {
    const std::string position = describe_position();
    if (!position.empty()) text << ' ' << position;
  }
  message_ = text.str();
}

void Slave::warn_about_initial_values() const {
  const State& s = data_.state;
  const std::string moved = describe_moved_values(mechanism_.multibody, engine_->system, engine_->solver, s.q, s.v);
  if (!moved.empty()) report_(Report::warning, moved);
}

// What is to be said of the position from which a step failed; nothing when it is a fair one.
std::string Slave::describe_position() {
  const State& s = data_.state;
  const std::string text = describe_nearness(engine_->system, s.q);
  if (!text.empty()) return text;
  ConsistentSolver& solver = engine_->solver;
  if (solver.accelerations(s.q, s.v, data_.last_input, vdot_before_, lambda_scratch_) || !solver.singular()) return "";
  return describe_singularity(mechanism_.multibody, engine_->system, s.q);
}

void Slave::warn_about_settings() {
  const IntegratorSettings& settings = mechanism_.integrator;
  for (int i = 0; i < engine_->system.body_count(); ++i) {
    const double w = data_.state.v.segment<3>(6 * i + 3).norm();
    if (w * settings.step_size > kPi) {
      std::ostringstream text = text_stream(6);
      text << "integrator.stepSize is " << settings.step_size << " s, but " << mechanism_.multibody.bodies[i].name
           << " spins at " << w << " rad/s: internal steps must be halved until the rotation in one is below pi; "
           << "choose at most " << kPi / w / 4 << " s.";
      report_(Report::warning, text.str());
      warned_of_spin_ = true;
    }
  }
  if (settings.is(Formulation::index3) && settings.spectral_radius == 1.0 && engine_->system.constraint_size() > 0) {
    report_(Report::warning,
            "integrator.formulation index3 with integrator.spectralRadius 1 lets the multipliers oscillate; use a "
            "smaller spectral radius or stabilizedIndex2.");
  }
}

// Once each: results go on, but are not what the user expects.
void Slave::warn_about_accuracy(double t, double h) {
  const State& s = data_.state;
  if (!warned_of_error_ && s.largest_error > kLargeError) {
    warned_of_error_ = true;
    std::ostringstream text = text_stream(6);
    text << "Up to t = " << t << " s the position error of an internal step of " << h << " s is estimated as "
         << s.largest_error << " of the mechanism's size, more than " << kLargeError
         << ": choose a smaller integrator.stepSize, or integrator.stepControl error.";
    report_(Report::warning, text.str());
  }
  for (int i = 0; !warned_of_spin_ && i < engine_->system.body_count(); ++i) {
    const double w = s.v.segment<3>(6 * i + 3).norm();
    if (!(w * h > kLargeTurn)) continue;
    warned_of_spin_ = true;
    std::ostringstream text = text_stream(6);
    text << mechanism_.multibody.bodies[i].name << " spins at " << w << " rad/s at t = " << t << " s and turns by "
         << w * h << " rad in an internal step, more than " << kLargeTurn
         << ": choose an integrator.stepSize of at most " << 0.5 * kLargeTurn / w << " s.";
    report_(Report::warning, text.str());
  }
}

Snapshot Slave::save() const { return data_; }

void Slave::restore(const Snapshot& snapshot) {
  if (snapshot.parameters.size() != parameter_references_.size()) {
    throw Refused("The FMU state belongs to another mechanism.");
  }
  // Parameters may have been set that the engine does not know yet.
  const bool outdated = data_.stale || data_.tolerance != snapshot.tolerance;
  data_.tolerance = snapshot.tolerance;
  if (apply_parameters(snapshot.parameters) || outdated) {
    build();
  } else {
    engine_->system.set_values(mechanism_.multibody);
  }
  data_ = snapshot;
  outputs_.has_motion = outputs_.has_accelerations = false;
}

}  // namespace sigmafmu
