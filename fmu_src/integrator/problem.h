// What a method integrates: a System on a group, in local coordinates, as its user has set it; and what every method
// does alike.
//
// A Problem owns work space (that of its solver): one per thread.
#pragma once

#include <memory>

#include "integrator/coordinates/local_coordinates.h"
#include "integrator/error_measure.h"
#include "integrator/state.h"
#include "integrator/step_failure.h"
#include "solve/index1.h"

namespace sigmafmu {

struct Problem {
  Problem(const System& system, const IntegratorSettings& settings, KktPlans kkt_plans);

  const System& system;
  const IntegratorSettings settings;
  const bool stabilized;  // the stabilized index-2 form, of a system that has constraints
  const std::unique_ptr<const LocalCoordinates> coordinates;
  const ErrorMeasure measure;
  KktPlans plans;  // of factorization, shared with others of the same topology
  ConsistentSolver solver;

  // False, with the reason in `failure`, when theta turns a body by pi or more: coordinates are not one-to-one there.
  [[nodiscard]] bool unambiguous(const VectorXd& theta, StepFailure& failure) const;
  // Takes over the end of a step of h: q, v, vdot, lambda, the turns of revolute joints, `e` being the evaluation at q
  // and v, and the step's error.
  void commit(State& state, double h, const VectorXd& q, const VectorXd& v, const VectorXd& vdot,
              const VectorXd& lambda, const Evaluation& e, double error) const;
};

}  // namespace sigmafmu
