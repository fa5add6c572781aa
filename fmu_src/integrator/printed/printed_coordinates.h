// What the printed algorithms need of a group besides local_coordinates.h.
#pragma once

#include <memory>

#include "integrator/implicit/step_equations.h"
#include "model/settings.h"

namespace sigmafmu {

class PrintedCoordinates {
 public:
  virtual ~PrintedCoordinates() = default;

  // theta -= sigma/gamma' [V, theta]: line 6 of Algorithm 1.
  virtual void modify(const StepEquations& e, const VectorXd& V, VectorXd& theta) const = 0;
  // dV := P^-1 dV.
  virtual void solve_P(const StepEquations& e, const VectorXd& theta, VectorXd& dV) const = 0;
  // Of the iteration matrix of Algorithm 2: P^-1, no other tangent operator.
  virtual void tangents(const StepEquations& e, const VectorXd& q_n, const Iterate& at, BodyTangents& out) const = 0;
};

std::unique_ptr<PrintedCoordinates> make_printed_coordinates(const IntegratorSettings& settings);

}  // namespace sigmafmu
