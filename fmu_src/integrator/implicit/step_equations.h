// One step of an implicit method, as far as it is known at its start, and an iterate for its end.
//
// With theta the motion of all bodies in local coordinates, velocities and accelerations at the end of the step are
//
//   P V  = gamma' [T(theta) (theta - c) + B(q_n)^T mu],   P = sigma I + (1 - sigma) T(theta)
//   Vdot = slope (V - V_n) + offset
//
// or theta - c without T in front, where c is not `transported`. Unknowns are theta, the multipliers lambda and, in the
// stabilized index-2 form, mu.
#pragma once

#include <vector>

#include "solve/newton_matrix.h"

namespace sigmafmu {

// What is known at the start of a step of any method; V and Vdot are the group's.
struct StepStart {
  explicit StepStart(const System& system) : u(system.make_inputs()), evaluation(system.make_evaluation()) {
    for (VectorXd* x : {&V, &Vdot}) x->setZero(system.velocity_size());
    lambda.setZero(system.constraint_size());
  }
  double h = 0;
  bool fresh = false;     // nothing that is remembered of the last step is of use
  VectorXd V, Vdot;       // V_n, Vdot_n
  VectorXd lambda;        // lambda_n
  Inputs u;               // at the end of the step
  Evaluation evaluation;  // has B(q_n) but for velocity equations, in the stabilized index-2 form alone
};

// The constants of the equations above: what tells methods apart.
struct StepEquations {
  StepEquations(const System& system, bool transported, double sigma)
      : transported(transported), sigma(system.body_count(), sigma) {
    for (VectorXd* x : {&c, &offset}) x->setZero(system.velocity_size());
  }
  StepScales scales{};  // gamma' and the scales of the Newton matrix
  bool transported;
  std::vector<double> sigma;  // of each body
  VectorXd c, offset;
  double slope = 0;
};

// One end that a step might have.
class Iterate {
 public:
  // `mixed`: whether the group's velocities are mixed ones.
  Iterate(const System& system, bool mixed) : mixed_(mixed) {
    q.setZero(system.position_size());
    for (VectorXd* x : {&theta, &B_mu, &V, &Vdot, &v_, &vdot_}) x->setZero(system.velocity_size());
    for (VectorXd* x : {&lambda, &mu}) x->setZero(system.constraint_size());
  }
  VectorXd theta, lambda, mu;  // the unknowns; what follows is made of them
  VectorXd B_mu;               // B(q_n)^T mu, of the group's velocities
  VectorXd q;
  VectorXd V, Vdot;  // of the group
  // Mixed; V and Vdot themselves, if those are.
  const VectorXd& v() const { return mixed_ ? V : v_; }
  const VectorXd& vdot() const { return mixed_ ? Vdot : vdot_; }
  VectorXd& v() { return mixed_ ? V : v_; }
  VectorXd& vdot() { return mixed_ ? Vdot : vdot_; }

 private:
  const bool mixed_;
  VectorXd v_, vdot_;
};

}  // namespace sigmafmu
