#include "integrator/bliedf.h"

namespace sigmafmu {

State BLieDF::make_state() const {
  State s = ImplicitIntegrator::make_state();
  for (VectorXd* x : {&s.mean_velocity, &s.mean_acceleration}) *x = s.v;
  return s;
}

// The step before the first: the motion continued backwards to second order.
void BLieDF::remember_start(State& s, const VectorXd& V, const VectorXd& Vdot, const VectorXd& jerk) {
  const double h = s.last_step;
  s.mean_velocity = V - (h / 2) * Vdot + (h * h / 6) * jerk;
  s.mean_acceleration = Vdot - (h / 2) * jerk;
  s.jacobian_step = 0;
}

// As if the loads after the jump had acted before it as well.
void BLieDF::shift_accelerations(State& s, const VectorXd& jump) {
  Integrator::shift_accelerations(s, jump);
  s.mean_acceleration += jump_of_group(s, jump);
  s.mean_velocity -= (s.last_step / 2) * jump_of_group(s, jump);
}

void BLieDF::shift_memory(State& s, const VectorXd& dV, const VectorXd& dVdot) {
  s.mean_velocity += dV;
  s.mean_acceleration += dVdot;
}

void BLieDF::begin(const State& s) {
  if (fresh_) {  // the trapezoidal rule
    slope_ = 2 / h_;
    offset_ = -Vdot_n_;
    c_ = (h_ / 2) * V_n_;
  } else {
    const double omega = h_ / (h_ + s.last_step);
    slope_ = (1 + omega) / h_;
    offset_ = -omega * s.mean_acceleration;
    c_ = (omega / slope_) * s.mean_velocity;
  }
  scales_.gamma_prime = slope_;
  scales_.beta_prime = slope_ * slope_;
  scales_.scale = 1 / scales_.beta_prime;
  theta_ = c_ + (V_n_ + (Vdot_n_ - offset_) / slope_) / slope_;  // with Vdot_n at the end as well
  lambda_ = fresh_ ? lambda_n_ : s.lambda;
  iterate_from_motion(s);
}

void BLieDF::finish(State& s) {
  s.mean_velocity = theta_ / h_;
  s.mean_acceleration = (V_ - V_n_) / h_;
}

}  // namespace sigmafmu
