#include "integrator/generalized_alpha.h"

namespace sigmafmu {

GeneralizedAlpha::GeneralizedAlpha(const System& system, const IntegratorSettings& settings, KktPlans plans)
    : ImplicitIntegrator(system, settings, plans),
      alpha_(settings.spectral_radius),
      residual_form_(settings.is(Corrector::residual)),
      spin_sigma_(system, settings) {
  for (VectorXd* x : {&a_, &a_n_}) x->setZero(system.velocity_size());
}

State GeneralizedAlpha::make_state() const {
  State s = ImplicitIntegrator::make_state();
  s.a = s.vdot;
  if (settings_.is(Predictor::extrapolated)) {
    s.vdot_old = s.vdot;
    s.lambda_old = s.lambda;
  }
  return s;
}

// a = Vdot(t + shift h) to first order.
void GeneralizedAlpha::remember_start(State& s, const VectorXd&, const VectorXd& Vdot, const VectorXd& jerk) {
  s.a = Vdot + alpha_.shift() * s.last_step * jerk;
  if (settings_.is(Predictor::extrapolated)) {
    s.vdot_old = s.vdot - s.last_step * jerk;
    s.lambda_old = s.lambda;
  }
  s.jacobian_step = 0;
}

void GeneralizedAlpha::shift_accelerations(State& s, const VectorXd& jump) {
  Integrator::shift_accelerations(s, jump);
  if (settings_.is(Predictor::extrapolated)) s.vdot_old += jump;
  s.a += jump_of_group(s, jump);
}

void GeneralizedAlpha::shift_memory(State& s, const VectorXd&, const VectorXd& dVdot) { s.a += dVdot; }

// From the start of the step alone, so that nothing of it has to be kept.
void GeneralizedAlpha::choose_sigma() {
  for (int i = 0; i < system_.body_count(); ++i) {
    sigma_[i] = spin_sigma_(i, V_n_.segment<3>(6 * i + 3), Vdot_n_.segment<3>(6 * i + 3), h_);
  }
}

// Lines 1-7 of Alg. 1. The residual form may start from any Vdot and lambda: they do not change its result.
void GeneralizedAlpha::begin(const State& s) {
  const auto& [alpha_m, alpha_f, beta, gamma] = of_step();
  if (settings_.is(SigmaMode::spin_optimal)) choose_sigma();
  scales_.gamma_prime = gamma / (h_ * beta);  // Eq. (64)
  scales_.beta_prime = (1 - alpha_m) / (h_ * h_ * beta * (1 - alpha_f));
  scales_.scale = beta * h_ * h_;
  if (fresh_) {
    a_n_ = Vdot_n_;
  } else {
    a_n_ = Vdot_n_ + (h_ / s.last_step) * (s.a - Vdot_n_);
  }
  slope_ = (1 - alpha_m) / ((1 - alpha_f) * gamma * h_);
  offset_ = ((alpha_m - (1 - alpha_m) * (1 - gamma) / gamma) * a_n_ - alpha_f * Vdot_n_) / (1 - alpha_f);
  c_ = h_ * (1 - beta / gamma) * V_n_ + h_ * h_ * (0.5 - beta / gamma) * a_n_;

  if (!residual_form_ || settings_.is(Predictor::zero)) {
    Vdot_.setZero();
    lambda_.setZero();
  } else {
    Vdot_ = Vdot_n_;
    lambda_ = fresh_ ? lambda_n_ : s.lambda;
    if (settings_.is(Predictor::extrapolated)) {
      Vdot_ += (h_ / s.last_step) * (s.vdot - s.vdot_old);
      lambda_ += (h_ / s.last_step) * (s.lambda - s.lambda_old);
    }
  }
  a_ = ((1 - alpha_f) * Vdot_ + alpha_f * Vdot_n_ - alpha_m * a_n_) / (1 - alpha_m);
  V_ = V_n_ + h_ * ((1 - gamma) * a_n_ + gamma * a_);
  theta_ = h_ * V_n_ + h_ * h_ * ((0.5 - beta) * a_n_ + beta * a_);
  if (residual_form_) {  // (12) with (16), theta on its right side from the line above
    coordinates_->modify(rule(), V_, theta_);
    iterate_from_motion(s);
  } else {
    coordinates_->modify_as_printed(rule(), V_, theta_);
    coordinates_->compose(s.q, theta_, q_);
    update_mixed_velocities();
  }
}

LocalCoordinates::Derivative GeneralizedAlpha::derivative() const {
  return residual_form_ ? LocalCoordinates::Derivative::exact : LocalCoordinates::Derivative::printed;
}

// Lines 14-18 of Alg. 1 and 3; lines 15-18 of Alg. 2 for sigma != 1.
void GeneralizedAlpha::apply_increments(const State& s) {
  if (residual_form_) {
    ImplicitIntegrator::apply_increments(s);
    return;
  }
  VectorXd& dV = c_;  // free in this form
  dV = x_.head(system_.velocity_size());
  coordinates_->turn_to_group(q_, dV);
  if (settings_.sigma == 1.0) {
    coordinates_->compose(q_, dV, q_);
  } else {
    coordinates_->add_motion(q_, x_, theta_);
    coordinates_->compose(s.q, theta_, q_);
  }
  gradient_times_mu(s, true);
  dV += B_mu_;
  coordinates_->solve_P(rule(), theta_, dV);
  V_ += scales_.gamma_prime * dV;
  Vdot_ += scales_.beta_prime * dV;
  update_mixed_velocities();
}

void GeneralizedAlpha::finish(State& s) {
  const auto& [alpha_m, alpha_f, beta, gamma] = of_step();
  if (fresh_) {
    s.a = Vdot_ + alpha_.shift() * (Vdot_ - Vdot_n_);
  } else if (residual_form_) {
    s.a = (V_ - V_n_) / (h_ * gamma) - ((1 - gamma) / gamma) * a_n_;  // (14)
  } else {                                                            // last line of the algorithms
    s.a = ((1 - alpha_f) * Vdot_ + alpha_f * Vdot_n_ - alpha_m * a_n_) / (1 - alpha_m);
  }
  if (settings_.is(Predictor::extrapolated)) {
    s.vdot_old = s.vdot;
    s.lambda_old = s.lambda;
  }
}

}  // namespace sigmafmu
