// Sigma-modified Lie group generalized-alpha method for constrained mechanisms on R^3 x SO(3)
// (Holzinger, Arnold, Gerstmayr 2025).
//
// corrector = residual: Eqs. (11)-(16), (20) solved exactly for every sigma. Eliminating a_{n+1} gives, body by body,
//
//   P(theta) v_{n+1} = gamma' [theta - T(theta) c_n + B(q_n)^T mu],   P = sigma I + (1 - sigma) T(theta),
//   c_n = h (1 - beta/gamma) v_n + h^2 (1/2 - beta/gamma) a_n,   gamma' = gamma/(h beta),   mu = h eta,
//
// and a_{n+1} from (14), vdot_{n+1} from (15), q_{n+1} = q_n o exp(theta): the result does not depend on the
// predictor nor on the iteration matrix. sigma = 0 is geom1; sigma = 1 needs no tangent operator in the iteration.
// Every body may have a sigma of its own, and another one in every step: order 2 does not depend on it.
//
// corrector = incremental: the increments of Algorithms 1 (index 3), 3 (stabilized index 2) and 2 (sigma != 1) as
// printed. They never re-evaluate (12), so their leading error depends on the predictor; for reproducing the paper.
//
// A GeneralizedAlpha owns its work space: one per thread. step() does not allocate.
#pragma once

#include "integrator/initial_conditions.h"
#include "integrator/newton_matrix.h"
#include "integrator/spin_sigma.h"
#include "integrator/state.h"

namespace sigmafmu {

struct StepFailure {
  enum class Reason { none, rotation, singular, not_finite, no_convergence };
  Reason reason = Reason::none;
  double time = 0;       // end of the step that failed [s]
  double step_size = 0;  // [s]
  int body = -1;         // with the largest scaled increment or rotation
  double measure = 0;    // rotation in the step [rad], or last increment over its tolerance
  int iterations = 0;
};

class GeneralizedAlpha {
 public:
  GeneralizedAlpha(const System& system, const IntegratorSettings& settings);

  // Sizes a State; no values but zeros, unit quaternions and zero counters.
  State make_state() const;
  // Completes a state whose q and v are consistent: vdot, lambda, and a = vdot(t + shift h) to first order.
  [[nodiscard]] bool initialize(State& state, const InputSignal& input);
  // Adds a jump of vdot (after a jump of inputs or parameters) to vdot and a.
  void shift_accelerations(State& state, const VectorXd& jump) const;

  // state.time -> t_end. Attempts that fail are repeated with halved steps; when that fails too, false is returned,
  // the state stays where the last good step ended and `failure` tells why. The counters count every attempt.
  [[nodiscard]] bool step(State& state, double t_end, const InputSignal& input, StepFailure& failure);

  // Newton (full) keeps its matrix within a step while it is as good as new: rotations changed by less than ...
  static constexpr double kNegligibleRotation = 1e-4;   // [rad]
  static constexpr double kNewtonContractivity = 0.01;  // and the last increment shrank at least to this
  static constexpr double kMaxContractivity = 0.5;      // modified Newton makes a new matrix above it (section 7)
  static constexpr int kMaxStaleIterations = 10;        // ... or after so many iterations

 private:
  bool attempt(State& state, double t, double h, const InputSignal& input, StepFailure& failure);
  void choose_sigma(const State& state);
  void predict(const State& state);
  bool prepare_matrix(const VectorXd& u);
  void correct(const State& state);
  void velocities_from_motion(const State& state);
  double scaled_increment(const State& state, double fraction, int& worst_body) const;
  double largest_rotation_increment() const;
  void commit(State& state, double t);

  const System& system_;
  IntegratorSettings settings_;
  AlphaParameters alpha_;
  Evaluation evaluation_;
  std::vector<JointEvaluation> start_;  // B(q_n)
  SpinSigma spin_sigma_;
  std::vector<double> sigma_;  // per body; changes in mode spin_optimal alone
  NewtonMatrix matrix_;
  Factorization factorization_;

  double h_ = 0, beta_prime_ = 0, gamma_prime_ = 0;  // Eq. (64)
  bool stabilized_, residual_form_, matrix_is_new_ = false;
  // Iterates of the step under way; theta is the motion from q_n, c as above, *_old the values before a correction.
  VectorXd q_, v_, v_old_, vdot_, a_, a_n_, lambda_, mu_, theta_, c_, B_mu_;
  VectorXd u_, r_, x_;
};

}  // namespace sigmafmu
