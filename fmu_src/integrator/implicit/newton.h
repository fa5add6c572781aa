// Newton's method on the equations at the end of a step of an implicit method,
//
//   r(q, v, vdot, lambda, u) = 0   and   Phi(q) = 0 and/or Phi' = 0
//
// Every theta, V and Vdot is computed anew from the unknowns of step_equations.h, so the solution depends neither on
// the prediction nor on the iteration matrix.
#pragma once

#include "integrator/implicit/step_equations.h"
#include "integrator/problem.h"

namespace sigmafmu {

class NewtonMethod {
 public:
  // Newton (full) keeps its matrix within a step while it is as good as new: rotations changed by less than ...
  static constexpr double kNegligibleRotation = 1e-4;   // [rad]
  static constexpr double kNewtonContractivity = 0.01;  // and the last increment shrank at least to this
  static constexpr double kMaxContractivity = 0.5;      // modified Newton makes a new matrix above it (section 7)
  static constexpr int kMaxStaleIterations = 10;        // ... or after so many iterations
  // Joints that yield get stiffer with shorter steps down to this part of the settings' step size squared, beta of the
  // trapezoidal rule: repeated steps, as near singular positions, are there to be easier.
  static constexpr double kLeastScale = 0.25;

  // `exact`: whether full Newton's matrix is the derivative of how iterates are made.
  explicit NewtonMethod(const Problem& problem, bool exact = true);

  // Sizes what modified Newton keeps from step to step.
  void make_state(State& state) const;
  // From the prediction at.theta, at.lambda to the end of the step.
  [[nodiscard]] bool solve(const StepStart& start, const StepEquations& equations, State& state, Iterate& at,
                           StepFailure& failure);
  // Once the step is accepted.
  void keep_matrix(const StepStart& start, State& state);
  // At the last iterate but one.
  const Evaluation& evaluation() const { return evaluation_; }

  // The parts of solve(), for iterates that are made of the increments in another way, in their order: begin, then
  // evaluate, factorize if matrix_due, increments and converged of each iteration.
  void begin(const StepStart& start, const State& state);
  // Residual and constraints; false after the last iteration.
  [[nodiscard]] bool evaluate(const StepStart& start, const Iterate& at, StepFailure& failure);
  bool matrix_due() const { return due_; }
  [[nodiscard]] bool factorize(const StepStart& start, const StepScales& scales, const BodyTangents& tangents,
                               const Iterate& at, State& state, StepFailure& failure);
  // Those of the motions of all bodies are at the beginning; those of lambda and mu are added here.
  const VectorXd& increments(const StepScales& scales, State& state, Iterate& at, StepFailure& failure);
  [[nodiscard]] bool converged(const StepScales& scales, const State& state, const Iterate& at, StepFailure& failure);

 private:
  void follow(const StepEquations& equations, const StepStart& start, const VectorXd& q_n, Iterate& at) const;
  double scaled_increment(const StepScales& scales, const State& state, const Iterate& at, int& worst_body) const;
  double largest_rotation_increment() const;

  const Problem& problem_;
  const bool modified_, full_;
  const double fraction_;  // of the tolerance
  NewtonMatrix matrix_;
  BodyTangents tangents_;
  Factorization factorization_;
  bool due_ = true, matrix_is_new_ = false;
  Evaluation evaluation_;
  VectorXd r_, v_old_, x_;
};

}  // namespace sigmafmu
