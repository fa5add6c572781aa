#include "integrator/implicit_integrator.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sigmafmu {

ImplicitIntegrator::ImplicitIntegrator(const System& system, const IntegratorSettings& settings, KktPlans plans)
    : Integrator(system, settings, plans),
      sigma_(system.body_count(), settings.is(Method::generalized_alpha) ? settings.sigma : 1.0),
      stabilized_(settings.is(Formulation::stabilized_index2) && system.constraint_size() > 0),
      transported_(settings.is(Method::generalized_alpha)),
      matrix_(system, static_cast<Formulation>(settings.formulation), plans),
      v_(coordinates_->mixed() ? V_ : own_v_),
      vdot_(coordinates_->mixed() ? Vdot_ : own_vdot_),
      evaluation_(system.make_evaluation()),
      start_(evaluation_),
      factorization_(matrix_.make_factorization()) {
  q_.setZero(system.position_size());
  for (VectorXd* x :
       {&V_n_, &Vdot_n_, &c_, &offset_, &theta_, &V_, &Vdot_, &v_, &vdot_, &B_mu_, &v_n_, &vdot_n_, &v_old_, &r_}) {
    x->setZero(system.velocity_size());
  }
  for (VectorXd* x : {&lambda_n_, &lambda_, &mu_}) x->setZero(system.constraint_size());
  u_.setZero(system.input_size());
  x_.setZero(matrix_.size());
}

State ImplicitIntegrator::make_state() const {
  State s = Integrator::make_state();
  if (settings_.is(Newton::modified)) s.jacobian = matrix_.make_factorization();
  return s;
}

// One step (Alg. 1 to 3): predict, then Newton iterations on r = 0, Phi = 0 and/or Phi' = 0.
bool ImplicitIntegrator::attempt(State& state, double h, const InputSignal& input, StepFailure& failure) {
  failure = {StepFailure::Reason::no_convergence, state.time + h, h, -1, 0, 0};
  if (h < kDrift) return drift(state, h, input, failure);
  h_ = h;
  const bool longer = h > kMemory * state.last_step, shorter = kMemory * h < state.last_step;
  fresh_ = h > memory() * state.last_step;
  if (fresh_) {
    if (!start_anew(state, input, failure)) return false;
  } else {
    coordinates_->to_group(state.q, state.v, state.vdot, V_n_, Vdot_n_);
  }
  input.value(state.elapsed + h, u_);
  if (stabilized_) system_.evaluate(state.q, state.v, start_);
  mu_.setZero();
  B_mu_.setZero();
  begin(state);
  if (!unambiguous(theta_, failure)) return false;

  const bool modified = settings_.is(Newton::modified);
  // With the exact matrix convergence is quadratic and what remains is far below the last increment. Otherwise it is
  // linear, and the remainders of many steps add up: ask for more.
  const double fraction = !modified && quadratic() && settings_.is(Jacobian::full) ? 1.0 : 0.01;
  matrix_is_new_ = false;
  bool renew = !modified || fresh_ || std::abs(state.jacobian_step - h) > 1e-6 * h;
  double previous = 0;
  for (int iteration = 1; iteration <= settings_.max_newton_iterations; ++iteration) {
    system_.evaluate(q_, v_, evaluation_);
    system_.residual(evaluation_, vdot_, lambda_, u_, r_);
    if (renew) {
      ++state.counters.jacobian_evaluations;
      if (!renew_matrix(state)) {
        failure.reason = StepFailure::Reason::singular;
        if (!std::isfinite(r_.squaredNorm())) {  // forces that overflow in the factorization
          Eigen::Index largest = 0;
          r_.head(6 * system_.body_count()).cwiseAbs().maxCoeff(&largest);
          failure.reason = StepFailure::Reason::not_finite;
          failure.body = static_cast<int>(largest) / kVelocitiesPerBody;
        }
        return false;
      }
    }
    ++state.counters.newton_iterations;
    failure.iterations = iteration;
    solve(state);
    v_old_ = v_;
    apply_increments(state);

    const double increment = scaled_increment(state, fraction, failure.body);
    failure.measure = increment;
    if (!std::isfinite(increment)) {
      failure.reason = StepFailure::Reason::not_finite;
      return false;
    }
    const double contractivity = iteration > 1 ? increment / previous : 0.0;
    const bool contracts = iteration > 1 && contractivity < 1.0;
    if (increment <= 1.0 || (contracts && increment * contractivity <= 1.0 - contractivity)) {
      c_ = Vdot_ - Vdot_n_;  // free again; h times the derivative
      const double error = std::abs(position_error()) * h * h * measure_(c_);
      if (control_order() > 0) {
        failure.measure = error / settings_.error_tolerance;
        failure.reason = StepFailure::Reason::inaccurate;
        if (!(failure.measure <= 1.0)) {
          failure.body = measure_.worst_body(c_);
          return false;
        }
      }
      if ((longer || shorter) && !satisfy_velocity_constraints(failure)) return false;
      finish(state);
      state.vdot = vdot_;
      state.lambda = lambda_;
      if (modified && matrix_is_new_) {
        std::swap(state.jacobian, factorization_);
        state.jacobian_step = fresh_ ? 0 : h_;  // that of another method, if fresh
      }
      state.last_step = h;
      commit(state, h, q_, v_, evaluation_, error);
      failure.reason = StepFailure::Reason::none;
      return true;
    }
    if (modified) {
      renew = contractivity > kMaxContractivity || iteration % kMaxStaleIterations == 0;
    } else {  // the matrix depends on the rotations above all; unless they changed, a new one would be the same
      renew = contractivity > kNewtonContractivity || largest_rotation_increment() > kNegligibleRotation;
    }
    previous = increment;
  }
  return false;
}

// Heun's method (explicit, order 2). Constraints hold to h^3, and the next step of another kind restores them.
bool ImplicitIntegrator::drift(State& s, double h, const InputSignal& input, StepFailure& failure) {
  solver_.displace(s.q, s.v, s.vdot, h, q_, v_n_);
  input.value(s.elapsed + h, u_);
  if (!solver_.accelerations(q_, v_n_, u_, vdot_n_, lambda_n_)) {
    failure.reason = StepFailure::Reason::singular;
    return false;
  }
  v_n_ = s.v + (0.5 * h) * (s.vdot + vdot_n_);
  coordinates_->to_group(s.q, s.v, s.vdot, V_n_, Vdot_n_);
  coordinates_->to_group(q_, v_n_, vdot_n_, V_, Vdot_);
  c_ = V_ - V_n_;
  offset_ = Vdot_ - Vdot_n_;
  shift_memory(s, c_, offset_);
  s.vdot = vdot_n_;
  s.lambda = lambda_n_;
  commit(s, h, q_, v_n_, solver_.evaluation(), s.error);
  failure.reason = StepFailure::Reason::none;
  return true;
}

// Of what the last step left nothing but q and v is used: short steps leave rounding in accelerations and multipliers.
bool ImplicitIntegrator::start_anew(State& s, const InputSignal& input, StepFailure& failure) {
  input.value(s.elapsed, u_);
  ++s.counters.jacobian_evaluations;
  if (!solver_.accelerations(s.q, s.v, u_, vdot_n_, lambda_n_)) {
    failure.reason = StepFailure::Reason::singular;
    return false;
  }
  coordinates_->to_group(s.q, s.v, vdot_n_, V_n_, Vdot_n_);
  return true;
}

// Index 3 leaves the velocities off the constraints by what positions of the last steps differ over h: an error that
// only equal steps keep small.
bool ImplicitIntegrator::satisfy_velocity_constraints(StepFailure& failure) {
  if (!settings_.is(Formulation::index3) || system_.constraint_size() == 0) return true;
  if (!solver_.project_velocities(q_, v_)) {
    failure.reason = StepFailure::Reason::singular;
    return false;
  }
  coordinates_->to_group(q_, v_, vdot_, V_, Vdot_);
  return true;
}

bool ImplicitIntegrator::renew_matrix(const State& state) {
  using Derivative = LocalCoordinates::Derivative;
  if (!settings_.is(Formulation::index3)) system_.constraint_rates(evaluation_);
  system_.linearize(vdot_, lambda_, u_, evaluation_);
  matrix_is_new_ = true;
  return coordinates_->factorize(matrix_, evaluation_, start_, scales_, rule(), {state.q, q_, theta_, c_, V_, Vdot_},
                                 settings_.is(Jacobian::full) ? derivative() : Derivative::none, factorization_);
}

// Increments of all unknowns, of which lambda_ and mu_ are done here. Plain loops: joints have few equations.
void ImplicitIntegrator::solve(const State& s) {
  const bool velocity_level = settings_.is(Formulation::index2);
  double* x = x_.data();
  for (int i = 0; i < system_.velocity_size(); ++i) x[i] = -scales_.scale * r_[i];
  for (int j = 0; j < system_.joint_count(); ++j) {
    const JointEvaluation& e = evaluation_.joints[j];
    double* first = x + matrix_.lambda_offset(j);
    double* second = stabilized_ ? x + matrix_.mu_offset(j) : nullptr;
    for (int k = 0; k < e.phi.size(); ++k) {
      const double rate = e.phidot[k] / scales_.gamma_prime;
      first[k] = velocity_level ? -rate : -e.phi[k];
      if (second) second[k] = e.phi[k] - rate;
    }
  }
  const Factorization& f = settings_.is(Newton::modified) && !matrix_is_new_ ? s.jacobian : factorization_;
  matrix_.solve(f, x_);
  for (int j = 0; j < system_.joint_count(); ++j) {
    const int first = system_.lambda_index(j);
    for (int k = 0; k < system_.joint(j).equations(); ++k) {
      lambda_[first + k] += x[matrix_.lambda_offset(j) + k] / scales_.scale;
      if (stabilized_) mu_[first + k] += x[matrix_.mu_offset(j) + k];
    }
  }
}

void ImplicitIntegrator::gradient_times_mu(const State& s, bool increment) {
  if (!stabilized_) return;
  B_mu_.setZero();
  for (const auto& [joint, body, side] : system_.pattern().incidences) {
    const double* row = start_.joints[joint].B[side].data();
    const double* multiplier =
        increment ? x_.data() + matrix_.mu_offset(joint) : mu_.data() + system_.lambda_index(joint);
    double* out = B_mu_.data() + 6 * body;
    for (int m = 0; m < system_.joint(joint).equations(); ++m, row += 6) {
      for (int c = 0; c < 6; ++c) out[c] += multiplier[m] * row[c];
    }
  }
  const auto& pattern = system_.pattern();
  for (std::size_t k = 0; k < pattern.modal_incidences.size(); ++k) {
    const auto& [joint, flexible, side] = pattern.modal_incidences[k];
    const MatrixXd& B = start_.modal_joints[k].B;
    const double* multiplier =
        increment ? x_.data() + matrix_.mu_offset(joint) : mu_.data() + system_.lambda_index(joint);
    for (int m = 0; m < B.rows(); ++m) {
      B_mu_.segment(system_.modal_velocity(flexible), B.cols()) += multiplier[m] * B.row(m).transpose();
    }
  }
  coordinates_->turn_to_group(s.q, B_mu_);
}

void ImplicitIntegrator::apply_increments(const State& s) {
  coordinates_->add_motion(q_, x_, theta_);
  gradient_times_mu(s, false);
  iterate_from_motion(s);
}

void ImplicitIntegrator::iterate_from_motion(const State& s) {
  coordinates_->velocities(rule(), theta_, c_, stabilized_ ? &B_mu_ : nullptr, V_);
  coordinates_->compose(s.q, theta_, q_);
  Vdot_ = slope_ * (V_ - V_n_) + offset_;
  update_mixed_velocities();
}

// Largest velocity increment over a fraction of its tolerance, all bodies, translation, rotation and modes apart. The
// floor is the rounding of the positions, of this body and of what joints hold it to, seen through gamma'.
double ImplicitIntegrator::scaled_increment(const State& s, double fraction, int& worst_body) const {
  constexpr double kFloor = 8 * std::numeric_limits<double>::epsilon();
  double largest = 0;
  // Norms of a part of body i: its velocity, the increments of velocity and motion, its position [m] or [rad].
  const auto add = [&](int i, double v, double dv, double dq, double size) {
    const double tolerance = fraction * (settings_.absolute_tolerance + settings_.relative_tolerance * v) +
                             kFloor * scales_.gamma_prime * size;
    const double scaled = std::max(dv, scales_.gamma_prime * dq) / tolerance;
    if (scaled <= largest || std::isnan(largest)) return;
    largest = scaled;
    worst_body = i;
  };
  for (int i = 0; i < system_.body_count(); ++i) {
    const double size[2] = {std::max(s.q.segment<3>(7 * i).norm(), system_.size()), 1.0};
    for (int part = 0; part < 2; ++part) {
      const int at = 6 * i + 3 * part;
      add(i, v_.segment<3>(at).norm(), (v_.segment<3>(at) - v_old_.segment<3>(at)).norm(), x_.segment<3>(at).norm(),
          size[part]);
    }
  }
  for (int f = 0; f < system_.flexible_count(); ++f) {
    const int at = system_.modal_velocity(f), count = system_.flexible(f).modes();
    add(system_.flexible_body(f), v_.segment(at, count).norm(),
        (v_.segment(at, count) - v_old_.segment(at, count)).norm(), x_.segment(at, count).norm(),
        std::max(s.q.segment(system_.modal_position(f), count).norm(), measure_.modal_size(f)));
  }
  return largest;
}

double ImplicitIntegrator::largest_rotation_increment() const {
  double largest = 0;
  for (int i = 0; i < system_.body_count(); ++i) {
    largest = std::max(largest, x_.segment<3>(6 * i + 3).norm());
  }
  return largest;
}

}  // namespace sigmafmu
