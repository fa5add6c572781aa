// Sigma-modified Lie group generalized-alpha method for constrained mechanisms
// (Holzinger, Arnold, Gerstmayr 2025), on any group and coordinate map: Eqs. (11)-(16), (20), solved exactly for every
// sigma. Eliminating a_{n+1} gives, body by body,
//
//   P(theta) V_{n+1} = gamma' [T(theta) (theta - c_n) + B(q_n)^T mu],   P = sigma I + (1 - sigma) T(theta),
//   c_n = h (1 - beta/gamma) V_n + h^2 (1/2 - beta/gamma) a_n,   gamma' = gamma/(h beta),   mu = h eta,
//
// (T(theta) theta = theta for exp) and a_{n+1} from (14), Vdot_{n+1} from (15), q_{n+1} = q_n o psi(theta): the result
// does not depend on the prediction nor on the iteration matrix. sigma = 0 is geom1; sigma = 1 needs no tangent
// operator in the iteration. Every body may have a sigma of its own, and another one in every step: order 2 does not
// depend on it.
//
// a belongs to a step size: for another one a_n = Vdot_n + h/h_last (a - Vdot_n) keeps order 2. What a has besides of
// the order of h, from constraints, unresolved oscillations and rounding, grows with the ratio, so that longer steps in
// turn with ones some hundred times shorter would be unstable. Steps that start anew are therefore done by the member
// of the family that needs no a, the trapezoidal rule (alpha_m = alpha_f = 0, beta = 1/4, gamma = 1/2, a = Vdot).
#pragma once

#include "integrator/implicit/step_ends.h"
#include "integrator/methods/alpha_parameters.h"
#include "integrator/methods/spin_sigma.h"

namespace sigmafmu {

class GeneralizedAlpha final : public IntegrationMethod {
 public:
  explicit GeneralizedAlpha(Problem& problem);

  void make_state(State& state) const override;
  void start(State& state, const VectorXd& V, const VectorXd& Vdot, const VectorXd& jerk) const override;
  [[nodiscard]] bool attempt(State& state, double h, const InputSignal& input, StepFailure& failure) override;
  void jump(State& state, const VectorXd& dVdot) const override { state.a += dVdot; }

 private:
  void set_equations(const AlphaParameters& parameters, const State& state);
  void predict(const AlphaParameters& parameters);
  void choose_sigma();

  const Problem& problem_;
  const AlphaParameters alpha_, trapezoidal_ = AlphaParameters::trapezoidal();
  const SpinSigma spin_sigma_;
  StepEnds ends_;
  NewtonMethod newton_;
  StepStart start_;
  StepEquations equations_;
  Iterate at_;
  VectorXd a_n_, a_;
};

}  // namespace sigmafmu
