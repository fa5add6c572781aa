// Sigma-modified Lie group generalized-alpha method for constrained mechanisms
// (Holzinger, Arnold, Gerstmayr 2025), on any group and coordinate map.
//
// corrector = residual: Eqs. (11)-(16), (20) solved exactly for every sigma. Eliminating a_{n+1} gives, body by body,
//
//   P(theta) V_{n+1} = gamma' [T(theta) (theta - c_n) + B(q_n)^T mu],   P = sigma I + (1 - sigma) T(theta),
//   c_n = h (1 - beta/gamma) V_n + h^2 (1/2 - beta/gamma) a_n,   gamma' = gamma/(h beta),   mu = h eta,
//
// (T(theta) theta = theta for exp) and a_{n+1} from (14), Vdot_{n+1} from (15), q_{n+1} = q_n o psi(theta): the result
// does not depend on the predictor nor on the iteration matrix. sigma = 0 is geom1; sigma = 1 needs no tangent operator
// in the iteration. Every body may have a sigma of its own, and another one in every step: order 2 does not depend on
// it.
//
// a belongs to a step size: for another one a_n = Vdot_n + h/h_last (a - Vdot_n) keeps order 2. What a has besides of
// the order of h, from constraints, unresolved oscillations and rounding, grows with the ratio, so that longer steps in
// turn with ones some hundred times shorter would be unstable. Steps that start anew are therefore done by the member
// of the family that needs no a, the trapezoidal rule (alpha_m = alpha_f = 0, beta = 1/4, gamma = 1/2, a = Vdot).
//
// corrector = incremental: the increments of Algorithms 1 (index 3), 3 (stabilized index 2) and 2 (sigma != 1) as
// printed. They never re-evaluate (12), so their leading error depends on the predictor; for reproducing the paper.
#pragma once

#include "integrator/alpha_parameters.h"
#include "integrator/implicit_integrator.h"
#include "integrator/spin_sigma.h"

namespace sigmafmu {

class GeneralizedAlpha final : public ImplicitIntegrator {
 public:
  GeneralizedAlpha(const System& system, const IntegratorSettings& settings, KktPlans plans);

  State make_state() const override;
  void shift_accelerations(State& state, const VectorXd& jump) override;

 private:
  void remember_start(State& state, const VectorXd& V, const VectorXd& Vdot, const VectorXd& jerk) override;
  void begin(const State& state) override;
  void finish(State& state) override;
  void shift_memory(State& state, const VectorXd& dV, const VectorXd& dVdot) override;
  void apply_increments(const State& state) override;
  LocalCoordinates::Derivative derivative() const override;
  bool quadratic() const override { return residual_form_; }
  double position_error() const override { return of_step().position_error(); }
  const AlphaParameters& of_step() const { return fresh_ ? trapezoidal_ : alpha_; }
  void choose_sigma();

  const AlphaParameters alpha_, trapezoidal_ = AlphaParameters::trapezoidal();
  const bool residual_form_;
  SpinSigma spin_sigma_;
  VectorXd a_, a_n_;
};

}  // namespace sigmafmu
