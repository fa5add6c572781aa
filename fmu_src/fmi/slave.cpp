#include "fmi/slave.h"

#include <algorithm>
#include <cmath>
#include <new>

#include "solve/start/assembly.h"
#include "solve/start/dependent_equations.h"
#include "text/text.h"

namespace sigmafmu {
namespace {

constexpr char kDamaged[] = "The serialized FMU state is damaged.";

Mechanism with_joint_values(Mechanism mechanism, const KktPlans& plans) {
  validate(mechanism);
  find_joint_values(mechanism.multibody, plans);
  return mechanism;
}

}  // namespace

Slave::Slave(Mechanism mechanism, std::string identity, Listener* listener)
    : identity_(std::move(identity)),
      mechanism_(with_joint_values(std::move(mechanism), plans_)),
      default_settings_(mechanism_.integrator),
      engine_(make_engine(mechanism_, 0)),
      variables_(make_variables(mechanism_, engine_->system).list),
      outputs_(variables_),
      remarks_(listener) {
  for (unsigned i = 0; i < variables_.size(); ++i) {
    if (variables_[i].causality == Causality::parameter) parameter_references_.push_back(i);
  }
  read_parameters(mechanism_, default_parameters_);
  engine_parameters_ = default_parameters_;
  data_ = first_snapshot();
}

// --- parameters and the engine that is built from them ---------------------------------------------------------------

void Slave::read_parameters(const Mechanism& mechanism, std::vector<double>& values) const {
  values.resize(parameter_references_.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = variables_[parameter_references_[i]].value(mechanism);
  }
}

// Allocates nothing where only tunable parameters change, or initial values go back to what they came with.
void Slave::set_parameters(Mechanism& mechanism, const std::vector<double>& values) const {
  for (std::size_t i = 0; i < values.size(); ++i) {
    variables_[parameter_references_[i]].set_value(mechanism, values[i]);
  }
}

bool Slave::same_fixed(const std::vector<double>& a, const std::vector<double>& b) const {
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i] != b[i] && variables_[parameter_references_[i]].variability == Variability::fixed) return false;
  }
  return true;
}

// The parameters with the experiment's tolerance in place of the error tolerance of methods that control their error,
// where nothing else was set.
IntegratorSettings Slave::settings(const Mechanism& mechanism, double tolerance) const {
  IntegratorSettings s = mechanism.integrator;
  if (tolerance == 0) return s;
  const IntegratorSettings& d = default_settings_;
  if (s.is(Method::rkmk54)) {
    const double relative = std::min(tolerance, 1e-2);
    if (s.absolute_tolerance == d.absolute_tolerance) s.absolute_tolerance *= relative / d.relative_tolerance;
    if (s.relative_tolerance == d.relative_tolerance) s.relative_tolerance = relative;
  }
  if (s.error_tolerance == d.error_tolerance) s.error_tolerance = tolerance;
  return s;
}

std::unique_ptr<Engine> Slave::make_engine(const Mechanism& mechanism, double tolerance) const {
  return std::make_unique<Engine>(mechanism.multibody, settings(mechanism, tolerance), plans_);
}

// Makes the engine that of a snapshot, whose parameters `mechanism` has.
void Slave::fit_engine(const Mechanism& mechanism, const Snapshot& data) {
  if (!engine_fits(data)) {
    std::vector<double> parameters = data.parameters;
    engine_ = make_engine(mechanism, data.tolerance);
    engine_parameters_ = std::move(parameters);
    engine_tolerance_ = data.tolerance;
  }
  engine_->system.set_values(mechanism.multibody);
}

// Whether the engine needs no more than the tunable parameters to be that of a snapshot.
bool Slave::engine_fits(const Snapshot& data) const {
  return engine_tolerance_ == data.tolerance && same_fixed(engine_parameters_, data.parameters);
}

// --- life ------------------------------------------------------------------------------------------------------------

Snapshot Slave::first_snapshot() const {
  const System& system = engine_->system;
  Snapshot data;
  data.parameters = default_parameters_;
  data.input = system.make_signal();
  data.last_input = system.make_inputs();
  data.vdot_before_jump.setZero(system.velocity_size());
  for (const Port& v : variables_) {
    if (v.prescribed >= 0) data.input.drive[v.derivative][v.prescribed] = v.start;
  }
  return data;
}

// The definition takes over what the master prescribes at the start.
void Slave::tell_prescribed() {
  const auto& drive = data_.input.drive;
  MultibodyDef& d = mechanism_.multibody;
  for (std::size_t i = 0; i < d.drives.size(); ++i) {
    if (!d.drives[i].input) continue;
    const auto index = static_cast<Eigen::Index>(i);
    const auto order = static_cast<int>(d.drives[i].motion);
    d.drives[i].value = drive[order][index];
    d.drives[i].first_derivative = drive[order + 1][index];
    d.drives[i].second_derivative = drive[order + 2][index];
  }
  auto first = static_cast<Eigen::Index>(d.drives.size() + d.couplings.size());
  for (MotionDef& motion : d.motions) {
    for (std::size_t k = 0; motion.input && k < motion.start.size(); ++k) {
      for (std::size_t i = 0; i < 6; ++i) motion.start[k][i] = drive[k][first + static_cast<Eigen::Index>(i)];
    }
    first += kPrescribedPerMotion;
  }
}

void Slave::reset() {
  Snapshot data = first_snapshot();
  set_parameters(mechanism_, data.parameters);
  data_ = std::move(data);
  forget_outputs();
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
  remarks_.about_start(mechanism_, engine_->system, engine_->solver, data_.state);
}

// Everything from the parameters and initial values; the slave stays as it was (stale) when that fails.
void Slave::initialize() {
  State& s = data_.state;
  try {
    tell_prescribed();
    validate(mechanism_.multibody);
    fit_engine(mechanism_, data_);
    s = engine_->integrator->make_state();
    s.time = data_.start_time;
    start_prescribed(mechanism_.multibody, engine_->system, data_.input);
    assemble(mechanism_.multibody, engine_->system, engine_->solver, s.q, s.v);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    throw Discarded(e.what());
  }
  Engine& engine = *engine_;
  s.turned = coordinates_at_start(mechanism_.multibody, engine.system, s.q);
  mesh_couplings(mechanism_.multibody, s.turned, data_.input);
  if (!engine.integrator->initialize(s, data_.input)) {
    data_.input.value(s.elapsed, s.turned, engine.u);
    accelerations_or_discard(s.q, s.v, engine.u, engine.vdot, engine.lambda);
    throw Discarded("The derivatives of the accelerations at the start overflow.");
  }
  data_.input.value(s.elapsed, s.turned, data_.last_input);
  data_.parameter_jump = false;
  data_.stale = false;
  forget_outputs();
}

void Slave::ensure_initialized() {
  if (data_.stale) initialize();
}

// --- values ----------------------------------------------------------------------------------------------------------

const Port& Slave::variable(unsigned reference) const {
  if (reference >= variables_.size()) {
    fail<Refused>("Value reference ", reference, " is unknown; this FMU has 0 to ", variables_.size() - 1, ".");
  }
  return variables_[reference];
}

const Port& Slave::typed_variable(unsigned reference, bool integer, const char* done) const {
  const Port& v = variable(reference);
  if (v.integer != integer) {
    fail<Refused>(v.name, " is ", v.integer ? "an Integer" : "a Real", "; it was ", done, " as ",
                  integer ? "an Integer." : "a Real.");
  }
  return v;
}

SlaveView Slave::view() const {
  const State& s = data_.state;
  const Engine& engine = *engine_;
  const View view{mechanism_, engine.system, s.q, s.v, engine.u, engine.evaluation, engine.vdot, engine.lambda};
  return {view, s};
}

void Slave::accelerations_or_discard(const VectorXd& q, const VectorXd& v, const Inputs& u, VectorXd& vdot,
                                     VectorXd& lambda) {
  if (engine_->solver.accelerations(q, v, u, vdot, lambda)) return;
  const auto& definition = mechanism_.multibody;
  fail<Discarded>("The accelerations at t = ", time(), " s cannot be computed. ",
                  engine_->solver.singular() ? describe_singularity(definition, engine_->system, q)
                                             : "A velocity or a force overflows.");
}

void Slave::forget_outputs() {
  engine_->has_motion = engine_->has_accelerations = false;
  outputs_.forget();
}

void Slave::evaluate(bool accelerations) {
  ensure_initialized();
  const State& s = data_.state;
  Engine& engine = *engine_;
  if (!engine.has_motion) {
    data_.input.value(s.elapsed, s.turned, engine.u);
    engine.system.evaluate(s.q, s.v, engine.u, engine.evaluation);
    engine.has_motion = true;
  }
  if (accelerations && !engine.has_accelerations) {
    accelerations_or_discard(s.q, s.v, engine.u, engine.vdot, engine.lambda);
    engine.has_accelerations = true;
  }
}

void Slave::get(const unsigned* references, std::size_t count, bool integer, double* values) {
  for (std::size_t i = 0; i < count; ++i) {
    const Port& v = typed_variable(references[i], integer, "read");
    if (v.output) {
      evaluate(v.needs_accelerations);
      values[i] = outputs_(v, view());
    } else if (v.input >= 0) {
      values[i] = data_.input.derivative[0][v.input];
    } else if (v.prescribed >= 0) {
      values[i] = data_.input.drive[v.derivative][v.prescribed];
    } else {
      values[i] = v.value(mechanism_);
    }
  }
}

void Slave::require_settable(const Port& v) const {
  if (v.causality == Causality::output) fail<Refused>(v.name, " is an output; it cannot be set.");
  if (v.causality == Causality::local) fail<Refused>(v.name, " is computed; it cannot be set.");
  if (v.variability == Variability::fixed && data_.phase != Phase::instantiated &&
      data_.phase != Phase::initialization) {
    fail<Refused>(v.name, " is a fixed parameter; it can be set only before the simulation starts, or after a reset.");
  }
}

// Throws Refused for what cannot be set.
Slave::Changes Slave::check_values(const unsigned* references, std::size_t count, bool integer,
                                   const double* values) const {
  Changes changes;
  for (std::size_t i = 0; i < count; ++i) {
    const Port& v = typed_variable(references[i], integer, "set");
    require_settable(v);
    const std::string complaint = v.complaint(values[i]);
    if (!complaint.empty()) throw Refused(complaint);
    if (v.is_input()) {
      changes.inputs = true;
    } else if (v.value(mechanism_) != values[i]) {
      changes.parameters = true;
    }
  }
  return changes;
}

// All or, when there is no memory to note which initial values are held, none.
void Slave::store_values(const unsigned* references, std::size_t count, const double* values) {
  try {
    for (std::size_t i = 0; i < count; ++i) {
      const Port& v = variables_[references[i]];
      if (!v.is_input()) v.set_value(mechanism_, values[i]);
    }
  } catch (...) {
    set_parameters(mechanism_, data_.parameters);
    throw;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Port& v = variables_[references[i]];
    if (v.input >= 0) data_.input.derivative[0][v.input] = values[i];
    if (v.prescribed < 0) continue;
    for (int k = 0; k <= InputSignal::kMaxDerivative; ++k) {  // derivatives are zero until they are set
      data_.input.drive[v.derivative + k][v.prescribed] = k == 0 ? values[i] : 0.0;
    }
  }
}

// Before the first change of a tunable parameter since the last step.
void Slave::remember_acceleration() {
  if (data_.parameter_jump) return;
  const State& s = data_.state;
  accelerations_or_discard(s.q, s.v, data_.last_input, data_.vdot_before_jump, engine_->lambda_scratch);
  data_.parameter_jump = true;
}

void Slave::set(const unsigned* references, std::size_t count, bool integer, const double* values) {
  const Changes changes = check_values(references, count, integer, values);
  if (!changes.inputs && !changes.parameters) return;
  const bool running = data_.phase == Phase::step;
  if (changes.parameters && running) remember_acceleration();
  store_values(references, count, values);
  if (changes.inputs) data_.state.elapsed = 0;
  if (changes.parameters) read_parameters(mechanism_, data_.parameters);
  if (!running) {
    data_.stale = true;
  } else if (changes.parameters) {
    engine_->system.set_values(mechanism_.multibody);
  }
  forget_outputs();
}

// --- snapshots -------------------------------------------------------------------------------------------------------

void Slave::restore(const Snapshot& snapshot) {
  if (snapshot.parameters.size() != parameter_references_.size()) {
    throw Refused("The FMU state belongs to another mechanism.");
  }
  if (same_fixed(data_.parameters, snapshot.parameters) && same_sizes(data_, snapshot) &&
      (snapshot.stale || engine_fits(snapshot))) {  // copies and nothing else
    set_parameters(mechanism_, snapshot.parameters);
    data_ = snapshot;
    engine_->system.set_values(mechanism_.multibody);
  } else {
    Snapshot data = snapshot;
    Mechanism mechanism = mechanism_;
    set_parameters(mechanism, data.parameters);
    if (!data.stale) fit_engine(mechanism, data);
    mechanism_ = std::move(mechanism);
    data_ = std::move(data);
  }
  forget_outputs();
}

Snapshot Slave::deserialize(const char* bytes, std::size_t size) const {
  Snapshot snapshot = sigmafmu::deserialize(bytes, size, identity_);
  Snapshot expected = first_snapshot();
  if (snapshot.parameters.size() != expected.parameters.size()) throw Refused(kDamaged);
  for (std::size_t i = 0; i < parameter_references_.size(); ++i) {
    const std::string complaint = variables_[parameter_references_[i]].complaint(snapshot.parameters[i]);
    if (!complaint.empty()) throw Refused(kDamaged + (" " + complaint));
  }
  if (snapshot.stale) {
    expected.state = snapshot.state;  // any: it is computed anew
  } else if (engine_fits(snapshot)) {
    expected.state = engine_->integrator->make_state();
  } else {
    Mechanism mechanism = mechanism_;
    set_parameters(mechanism, snapshot.parameters);
    expected.state = make_engine(mechanism, snapshot.tolerance)->integrator->make_state();
  }
  if (!same_sizes(expected, snapshot)) throw Refused(kDamaged);
  return snapshot;
}

}  // namespace sigmafmu
