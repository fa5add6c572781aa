#include "integrator/methods/generalized_alpha.h"

namespace sigmafmu {

GeneralizedAlpha::GeneralizedAlpha(Problem& problem)
    : IntegrationMethod(StepEnds::error_control(problem.settings)),
      problem_(problem),
      alpha_(problem.settings.spectral_radius),
      spin_sigma_(problem.system, problem.settings),
      ends_(problem),
      newton_(problem),
      start_(problem.system),
      equations_(problem.system, true, problem.settings.sigma),
      at_(problem.system, problem.coordinates->mixed) {
  for (VectorXd* x : {&a_n_, &a_}) x->setZero(problem.system.velocity_size());
}

void GeneralizedAlpha::make_state(State& s) const {
  s.a = s.vdot;
  newton_.make_state(s);
}

// a = Vdot(t + shift h) to first order.
void GeneralizedAlpha::start(State& s, const VectorXd&, const VectorXd& Vdot, const VectorXd& jerk) const {
  s.a = Vdot + alpha_.shift() * s.last_step * jerk;
  s.jacobian_step = 0;
}

bool GeneralizedAlpha::attempt(State& s, double h, const InputSignal& input, StepFailure& failure) {
  if (h < StepEnds::kDrift) {
    if (!ends_.drift(s, h, input, failure)) return false;
    s.a += ends_.dVdot();
    return true;
  }
  if (!ends_.begin(s, h, StepEnds::kMemory, input, start_, failure)) return false;
  const AlphaParameters& p = start_.fresh ? trapezoidal_ : alpha_;
  set_equations(p, s);
  predict(p);
  if (!newton_.solve(start_, equations_, s, at_, failure)) return false;
  if (!ends_.complete(start_, p.position_error(), newton_, at_, s, failure)) return false;
  if (start_.fresh) {
    s.a = at_.Vdot + alpha_.shift() * (at_.Vdot - start_.Vdot);
  } else {
    s.a = (at_.V - start_.V) / (h * p.gamma) - ((1 - p.gamma) / p.gamma) * a_n_;  // (14)
  }
  return true;
}

// (11)-(16) without a_{n+1}.
void GeneralizedAlpha::set_equations(const AlphaParameters& p, const State& s) {
  const auto& [alpha_m, alpha_f, beta, gamma] = p;
  const double h = start_.h;
  const VectorXd &V_n = start_.V, &Vdot_n = start_.Vdot;
  if (start_.fresh) {
    a_n_ = Vdot_n;
  } else {
    a_n_ = Vdot_n + (h / s.last_step) * (s.a - Vdot_n);
  }
  StepEquations& e = equations_;
  e.scales = p.scales(h);
  e.c = h * (1 - beta / gamma) * V_n + h * h * (0.5 - beta / gamma) * a_n_;
  e.slope = (1 - alpha_m) / ((1 - alpha_f) * gamma * h);
  e.offset = ((alpha_m - (1 - alpha_m) * (1 - gamma) / gamma) * a_n_ - alpha_f * Vdot_n) / (1 - alpha_f);
  if (problem_.settings.is(SigmaMode::spin_optimal)) choose_sigma();
}

// From the start of the step alone, so that nothing of it has to be kept.
void GeneralizedAlpha::choose_sigma() {
  for (int i = 0; i < problem_.system.body_count(); ++i) {
    const int w = kVelocitiesPerBody * i + 3;
    equations_.sigma[i] = spin_sigma_(i, start_.V.segment<3>(w), start_.Vdot.segment<3>(w), start_.h);
  }
}

// With Vdot_{n+1} = Vdot_n and lambda_{n+1} = lambda_n: a_{n+1} from (15), V_{n+1} from (14), theta from (12) with
// (16), on whose right side is the theta of exact velocities.
void GeneralizedAlpha::predict(const AlphaParameters& p) {
  const auto& [alpha_m, alpha_f, beta, gamma] = p;
  const double h = start_.h;
  const VectorXd &V_n = start_.V, &Vdot_n = start_.Vdot;
  a_ = ((1 - alpha_f) * Vdot_n + alpha_f * Vdot_n - alpha_m * a_n_) / (1 - alpha_m);
  at_.V = V_n + h * ((1 - gamma) * a_n_ + gamma * a_);
  at_.theta = h * V_n + h * h * ((0.5 - beta) * a_n_ + beta * a_);
  problem_.coordinates->modify(equations_, at_.V, at_.theta);
  at_.lambda = start_.lambda;
}

}  // namespace sigmafmu
