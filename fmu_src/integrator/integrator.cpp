#include "integrator/integrator.h"

#include <utility>

#include "integrator/methods/bliedf.h"
#include "integrator/methods/generalized_alpha.h"
#include "integrator/methods/munthe_kaas.h"
#include "integrator/printed/printed_algorithms.h"
#include "integrator/step_control.h"

namespace sigmafmu {
namespace {

std::unique_ptr<IntegrationMethod> make_method(Problem& problem) {
  switch (static_cast<Method>(problem.settings.method)) {
    case Method::rkmk4:
    case Method::rkmk54:
      return std::make_unique<MuntheKaas>(problem);
    case Method::bliedf2:
      return std::make_unique<BLieDF>(problem);
    default:
      if (problem.settings.is(Corrector::incremental)) return std::make_unique<PrintedAlgorithms>(problem);
      return std::make_unique<GeneralizedAlpha>(problem);
  }
}

}  // namespace

Integrator::Integrator(const System& system, const IntegratorSettings& settings, KktPlans plans)
    : problem_(system, settings, std::move(plans)), method_(make_method(problem_)) {
  jump_.setZero(system.velocity_size());
}

State Integrator::make_state() const {
  const System& system = problem_.system;
  State s;
  s.q.setZero(system.position_size());
  for (int i = 0; i < system.body_count(); ++i) s.q[kPositionsPerBody * i + 3] = 1.0;
  for (VectorXd* x : {&s.v, &s.vdot}) x->setZero(system.velocity_size());
  s.lambda.setZero(system.constraint_size());
  s.turned.setZero(system.coordinate_count());
  method_->make_state(s);
  return s;
}

bool Integrator::initialize(State& s, const InputSignal& input) {
  const System& system = problem_.system;
  const LocalCoordinates& coordinates = *problem_.coordinates;
  ConsistentSolver& solver = problem_.solver;
  const VectorXd assembled = s.q;
  coordinates.store(assembled, s.q);
  Inputs u = system.make_inputs();
  VectorXd jerk(system.velocity_size()), V, Vdot;
  input.value(s.elapsed, s.turned, u);
  if (!solver.accelerations(s.q, s.v, u, s.vdot, s.lambda)) return false;
  if (!solver.jerk(s.q, s.v, s.vdot, input, s.turned, s.elapsed, jerk) || !jerk.allFinite()) return false;
  coordinates.to_group(s.q, s.v, s.vdot, V, Vdot);
  coordinates.jerk_to_group(s.q, s.v, s.vdot, jerk);
  s.last_step = problem_.settings.step_size;
  method_->start(s, V, Vdot, jerk);
  return true;
}

void Integrator::shift_accelerations(State& s, const VectorXd& jump) {
  s.vdot += jump;
  jump_ = jump;
  problem_.coordinates->turn_to_group(s.q, jump_);
  method_->jump(s, jump_);
}

bool Integrator::step(State& s, double h, const InputSignal& input, StepFailure& failure) {
  return do_step(*method_, problem_.settings.max_halvings, s, h, input, failure);
}

}  // namespace sigmafmu
