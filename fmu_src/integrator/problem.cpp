#include "integrator/problem.h"

#include <algorithm>
#include <utility>

namespace sigmafmu {

Problem::Problem(const System& system, const IntegratorSettings& settings, KktPlans kkt_plans)
    : system(system),
      settings(settings),
      stabilized(settings.is(Formulation::stabilized_index2) && system.constraint_size() > 0),
      coordinates(make_local_coordinates(system, settings)),
      measure(system),
      plans(std::move(kkt_plans)),
      solver(system, plans) {}

bool Problem::unambiguous(const VectorXd& theta, StepFailure& failure) const {
  constexpr double kPi = 3.14159265358979323846;
  int body = -1;
  const double angle = coordinates->largest_rotation(theta, body);
  if (angle < kPi) return true;
  failure.body = body;
  failure.measure = angle;
  return failure.because(StepFailure::Reason::rotation);
}

void Problem::commit(State& s, double h, const VectorXd& q, const VectorXd& v, const VectorXd& vdot,
                     const VectorXd& lambda, const Evaluation& e, double error) const {
  if (s.turned.size() > 0) system.count_turns(e, h, s.turned);
  s.time += h;
  s.elapsed += h;
  coordinates->store(q, s.q);
  s.v = v;
  s.vdot = vdot;
  s.lambda = lambda;
  s.error = error;
  s.largest_error = std::max(s.largest_error, error);
  ++s.counters.steps;
}

}  // namespace sigmafmu
