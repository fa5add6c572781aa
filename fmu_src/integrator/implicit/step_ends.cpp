#include "integrator/implicit/step_ends.h"

#include <cmath>

namespace sigmafmu {

using Reason = StepFailure::Reason;

StepEnds::StepEnds(Problem& problem) : problem_(problem), u_(problem.system.make_inputs()) {
  const System& system = problem.system;
  q_.setZero(system.position_size());
  for (VectorXd* x : {&dV_, &dVdot_, &v_, &vdot_, &V_, &Vdot_}) x->setZero(system.velocity_size());
  lambda_.setZero(system.constraint_size());
}

ErrorControl StepEnds::error_control(const IntegratorSettings& settings) {
  return {settings.is(StepControl::error) ? 3 : 0, 0.99 * kMemory};
}

// Of what the last step left a fresh one uses nothing but q and v: short steps leave rounding in accelerations and
// multipliers.
bool StepEnds::begin(State& s, double h, double memory, const InputSignal& input, StepStart& start,
                     StepFailure& failure) {
  const LocalCoordinates& coordinates = *problem_.coordinates;
  ConsistentSolver& solver = problem_.solver;
  start.h = h;
  start.fresh = h > memory * s.last_step;
  if (start.fresh) {
    input.value(s.elapsed, s.turned, u_);
    ++s.counters.jacobian_evaluations;
    if (!solver.accelerations(s.q, s.v, u_, vdot_, start.lambda)) return failure.because(Reason::singular);
    coordinates.to_group(s.q, s.v, vdot_, start.V, start.Vdot);
  } else {
    start.lambda = s.lambda;
    coordinates.to_group(s.q, s.v, s.vdot, start.V, start.Vdot);
  }
  input.value(s.elapsed + h, s.turned, start.u);
  if (problem_.stabilized) {
    input.drives(s.elapsed, s.turned, u_);
    problem_.system.evaluate(s.q, s.v, u_, start.evaluation);
    if (!problem_.system.velocity_equations().empty()) problem_.system.clear_velocity_rows(start.evaluation);
  }
  return true;
}

bool StepEnds::complete(const StepStart& start, double position_error, NewtonMethod& newton, Iterate& at, State& s,
                        StepFailure& failure) {
  const IntegratorSettings& settings = problem_.settings;
  const double h = start.h;
  dVdot_ = at.Vdot - start.Vdot;  // h times the derivative
  const double error = std::abs(position_error) * h * h * problem_.measure(dVdot_);
  if (settings.is(StepControl::error)) {
    failure.measure = error / settings.error_tolerance;
    if (!(failure.measure <= 1.0)) {
      failure.body = problem_.measure.worst_body(dVdot_);
      return failure.because(Reason::inaccurate);
    }
  }
  const bool equal = h <= kMemory * s.last_step && kMemory * h >= s.last_step;
  if (!equal && !satisfy_velocity_constraints(start.u, at)) return failure.because(Reason::singular);
  newton.keep_matrix(start, s);
  s.last_step = h;
  problem_.commit(s, h, at.q, at.v(), at.vdot(), at.lambda, newton.evaluation(), error);
  return true;
}

// Index 3 leaves the velocities off the constraints by what positions of the last steps differ over h: an error that
// only equal steps keep small.
bool StepEnds::satisfy_velocity_constraints(const Inputs& u, Iterate& at) {
  if (!problem_.settings.is(Formulation::index3) || problem_.system.constraint_size() == 0) return true;
  if (!problem_.solver.project_velocities(at.q, u, at.v())) return false;
  problem_.coordinates->iterate_to_group(at);
  return true;
}

// Heun's method (explicit, order 2). Constraints hold to h^3, and the next step of another kind restores them.
bool StepEnds::drift(State& s, double h, const InputSignal& input, StepFailure& failure) {
  const LocalCoordinates& coordinates = *problem_.coordinates;
  ConsistentSolver& solver = problem_.solver;
  solver.displace(s.q, s.v, s.vdot, h, q_, v_);
  input.value(s.elapsed + h, s.turned, u_);
  if (!solver.accelerations(q_, v_, u_, vdot_, lambda_)) return failure.because(Reason::singular);
  v_ = s.v + (0.5 * h) * (s.vdot + vdot_);
  coordinates.to_group(s.q, s.v, s.vdot, V_, Vdot_);
  coordinates.to_group(q_, v_, vdot_, dV_, dVdot_);
  dV_ -= V_;
  dVdot_ -= Vdot_;
  problem_.commit(s, h, q_, v_, vdot_, lambda_, solver.evaluation(), s.error);
  return true;
}

}  // namespace sigmafmu
