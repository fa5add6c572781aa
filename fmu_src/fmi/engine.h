// All that is built from the parameters of a mechanism, with its work space.
#pragma once

#include <memory>
#include <vector>

#include "integrator/integrator.h"
#include "model/mechanism.h"
#include "solve/start/dependent_equations.h"

namespace sigmafmu {

struct Engine {
  Engine(const MultibodyDef& multibody, const IntegratorSettings& settings, const KktPlans& plans)
      : system(multibody, find_compliance(multibody)),
        solver(system, plans),
        integrator(std::make_unique<Integrator>(system, settings, plans)),
        evaluation(system.make_evaluation()),
        u(system.make_inputs()) {
    q_scratch.setZero(system.position_size());
    for (VectorXd* x : {&vdot, &vdot_before, &vdot_after, &v_scratch}) x->setZero(system.velocity_size());
    for (VectorXd* x : {&lambda, &lambda_scratch}) x->setZero(system.constraint_size());
  }

  System system;
  ConsistentSolver solver;
  std::unique_ptr<Integrator> integrator;

  // The point of which outputs are asked, computed as far as they need it.
  Evaluation evaluation;
  VectorXd vdot, lambda;
  Inputs u;
  bool has_motion = false, has_accelerations = false;

  VectorXd vdot_before, vdot_after, lambda_scratch, q_scratch, v_scratch;  // of a jump
};

}  // namespace sigmafmu
