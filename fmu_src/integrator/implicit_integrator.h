// Newton's method for one step of an implicit method whose velocities and accelerations at the end of the step are
//
//   P V = gamma' [T(theta) (theta - c) + B(q_n)^T mu],   Vdot = slope (V - V_n) + offset   (VelocityRule, StepScales)
//
// with c and offset known at the start: unknowns are theta, lambda and, in the stabilized index-2 form, mu. A method
// tells the four in begin() and keeps what it needs of the step in finish().
//
// Every theta, V and Vdot is computed anew from the unknowns, so the result depends neither on the predictor nor on the
// iteration matrix. A method may instead accumulate increments, in apply_increments().
//
// What a method remembers of a step is divided by its length or is a difference over it, and serves the next one as far
// as that is not much longer. Steps of any length may follow each other:
//
//   h > memory() last_step      the method starts anew, from accelerations that the index-1 equations give
//   or kMemory h < last_step    index 3 projects the velocities onto their constraints
//   h < kDrift                  nothing moves by more than rounding: Heun's explicit method, which divides by no h; the
//                               memory stays as it is
#pragma once

#include "integrator/integrator.h"

namespace sigmafmu {

class ImplicitIntegrator : public Integrator {
 public:
  State make_state() const override;

  // Newton (full) keeps its matrix within a step while it is as good as new: rotations changed by less than ...
  static constexpr double kNegligibleRotation = 1e-4;   // [rad]
  static constexpr double kNewtonContractivity = 0.01;  // and the last increment shrank at least to this
  static constexpr double kMaxContractivity = 0.5;      // modified Newton makes a new matrix above it (section 7)
  static constexpr int kMaxStaleIterations = 10;        // ... or after so many iterations
  static constexpr double kMemory = 1.5;
  static constexpr double kDrift = 1e-12;  // [s]

 protected:
  ImplicitIntegrator(const System& system, const IntegratorSettings& settings, KktPlans plans);

  // Sets scales_, c_, slope_, offset_ and the predicted theta_, lambda_ for a step of h_ from V_n_, Vdot_n_,
  // if `fresh_` with lambda_n_ and without what the method remembers.
  virtual void begin(const State& state) = 0;
  // Stores what the method remembers of the step; V_n_, Vdot_n_ are those at its start, state.vdot is not yet new.
  virtual void finish(State& state) = 0;
  // Moves what the method remembers with V and Vdot.
  virtual void shift_memory(State& state, const VectorXd& dV, const VectorXd& dVdot) = 0;
  // The error of the step in positions over h^3 and the derivative of Vdot.
  virtual double position_error() const = 0;
  // How many times longer than the step before a step may be that uses what is remembered of it.
  virtual double memory() const { return kMemory; }
  // The iterate after a solution x_ of the linear system.
  virtual void apply_increments(const State& state);
  virtual LocalCoordinates::Derivative derivative() const { return LocalCoordinates::Derivative::exact; }
  // Whether the exact matrix makes Newton's method converge quadratically.
  virtual bool quadratic() const { return true; }

  VelocityRule rule() const { return {scales_.gamma_prime, transported_, sigma_}; }
  // q, V, Vdot and the mixed velocities from theta_ and B_mu_.
  void iterate_from_motion(const State& state);
  void update_mixed_velocities() { coordinates_->to_mixed(q_, V_, Vdot_, v_, vdot_); }
  // B_mu_ = B(q_n)^T mu, or of the last increment of mu, in the group's velocities.
  void gradient_times_mu(const State& state, bool increment);

  std::vector<double> sigma_;  // per body
  const bool stabilized_, transported_;
  NewtonMatrix matrix_;
  double h_ = 0;
  bool fresh_ = false;  // the step starts anew
  StepScales scales_{};
  double slope_ = 0;
  // Of the step under way: at its start; known in it; the iterate, in the group's velocities.
  VectorXd V_n_, Vdot_n_, lambda_n_, c_, offset_;
  VectorXd theta_, V_, Vdot_, q_, lambda_, mu_, B_mu_;
  VectorXd x_;  // solution of the linear system; it begins with the motion increments of all bodies

 private:
  bool attempt(State& state, double h, const InputSignal& input, StepFailure& failure) final;
  int control_order() const final { return settings_.is(StepControl::error) ? 3 : 0; }
  double largest_growth() const final { return 0.99 * kMemory; }
  bool drift(State& state, double h, const InputSignal& input, StepFailure& failure);
  bool start_anew(State& state, const InputSignal& input, StepFailure& failure);
  bool satisfy_velocity_constraints(StepFailure& failure);
  bool renew_matrix(const State& state);
  void solve(const State& state);
  double scaled_increment(const State& state, double fraction, int& worst_body) const;
  double largest_rotation_increment() const;

  VectorXd own_v_, own_vdot_;
  VectorXd &v_, &vdot_;  // mixed velocities and accelerations of the iterate: V_ and Vdot_ themselves, or the own ones
  Evaluation evaluation_;
  Evaluation start_;  // at the start of the step, for B(q_n)
  Factorization factorization_;
  bool matrix_is_new_ = false;
  VectorXd v_n_, vdot_n_;  // mixed, at the start of a step that starts anew
  VectorXd v_old_, u_, r_;
};

}  // namespace sigmafmu
