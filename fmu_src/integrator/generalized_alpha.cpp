#include "integrator/generalized_alpha.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sigmafmu {
namespace {

constexpr double kPi = 3.14159265358979323846;

auto rotation(VectorXd& x, int body) { return x.segment<3>(6 * body + 3); }

Formulation formulation_of(const IntegratorSettings& s) { return static_cast<Formulation>(s.formulation); }

}  // namespace

GeneralizedAlpha::GeneralizedAlpha(const System& system, const IntegratorSettings& settings)
    : system_(system),
      settings_(settings),
      alpha_(settings.spectral_radius),
      evaluation_(system.make_evaluation()),
      start_(evaluation_.joints),
      spin_sigma_(system, settings),
      sigma_(system.body_count(), settings.sigma),
      matrix_(system, formulation_of(settings)),
      factorization_(matrix_.make_factorization()),
      stabilized_(settings.is(Formulation::stabilized_index2)),
      residual_form_(settings.is(Corrector::residual)) {
  matrix_.identity_P = settings.sigma == 1.0;
  q_.setZero(system.position_size());
  for (VectorXd* x : {&v_, &v_old_, &vdot_, &a_, &a_n_, &theta_, &c_, &B_mu_, &r_}) {
    x->setZero(system.velocity_size());
  }
  for (VectorXd* x : {&lambda_, &mu_}) x->setZero(system.constraint_size());
  u_.setZero(system.input_size());
  x_.setZero(matrix_.size());
}

State GeneralizedAlpha::make_state() const {
  State s;
  s.q = q_;
  s.q.setZero();
  for (int i = 0; i < system_.body_count(); ++i) s.q[7 * i + 3] = 1.0;
  for (VectorXd* x : {&s.v, &s.vdot, &s.a}) x->setZero(system_.velocity_size());
  s.lambda.setZero(system_.constraint_size());
  s.angle.setZero(system_.joint_count());
  if (settings_.is(Newton::modified)) s.jacobian = matrix_.make_factorization();
  if (settings_.is(Predictor::extrapolated)) {
    s.vdot_old = s.vdot;
    s.lambda_old = s.lambda;
  }
  return s;
}

bool GeneralizedAlpha::initialize(State& s, const InputSignal& input) {
  ConsistentSolver consistent(system_);
  input.value(s.time, u_);
  if (!consistent.accelerations(s.q, s.v, u_, s.vdot, s.lambda)) return false;
  const Evaluation& e = consistent.evaluation();
  for (int j = 0; j < system_.joint_count(); ++j) {
    const Joint& joint = system_.joint(j);
    if (joint.type() == JointType::revolute) {
      s.angle[j] = joint.coordinate(system_.kinematics(e, joint.body1()), system_.kinematics(e, joint.body2()));
    }
  }
  if (!consistent.jerk(s.q, s.v, s.vdot, input, s.time, r_)) return false;
  s.a_step = settings_.step_size;
  s.a = s.vdot + alpha_.shift() * s.a_step * r_;
  if (settings_.is(Predictor::extrapolated)) {
    s.vdot_old = s.vdot - s.a_step * r_;
    s.lambda_old = s.lambda;
  }
  s.jacobian_step = 0;
  return s.a.allFinite();
}

void GeneralizedAlpha::shift_accelerations(State& s, const VectorXd& jump) const {
  s.vdot += jump;
  if (settings_.is(Predictor::extrapolated)) s.vdot_old += jump;
  s.a += jump;
}

bool GeneralizedAlpha::step(State& state, double t_end, const InputSignal& input, StepFailure& failure) {
  double h = t_end - state.time;
  const double smallest = std::ldexp(h, -settings_.max_halvings) * 0.75;
  while (state.time < t_end) {
    const double remaining = t_end - state.time;
    const bool last = h > 0.75 * remaining;
    if (last) h = remaining;
    if (attempt(state, last ? t_end : state.time + h, h, input, failure)) continue;
    h *= 0.5;
    if (h < smallest) return false;
    ++state.counters.retries;
  }
  return true;
}

// One step (Alg. 1 to 3): predict, then Newton iterations on r = 0, Phi = 0 and/or Phi' = 0.
bool GeneralizedAlpha::attempt(State& state, double t, double h, const InputSignal& input, StepFailure& failure) {
  failure = {StepFailure::Reason::no_convergence, t, h, -1, 0, 0};
  h_ = h;
  beta_prime_ = (1 - alpha_.alpha_m) / (h * h * alpha_.beta * (1 - alpha_.alpha_f));
  gamma_prime_ = alpha_.gamma / (h * alpha_.beta);
  input.value(t, u_);

  if (stabilized_) {
    system_.evaluate(state.q, state.v, evaluation_);
    start_.swap(evaluation_.joints);
  }
  if (settings_.is(SigmaMode::spin_optimal)) choose_sigma(state);
  predict(state);
  for (int i = 0; i < system_.body_count(); ++i) {
    const double angle = rotation(theta_, i).norm();
    if (!(angle < kPi)) {  // exp is not one-to-one beyond pi: the rotation in a step would be ambiguous
      failure.reason = StepFailure::Reason::rotation;
      failure.body = i;
      failure.measure = angle;
      return false;
    }
  }

  const bool modified = settings_.is(Newton::modified);
  // With the exact matrix convergence is quadratic and what remains is far below the last increment. Otherwise it is
  // linear, and the remainders of many steps add up: ask for more.
  const bool exact = !modified && residual_form_ && settings_.is(Jacobian::full);
  const double fraction = exact ? 1.0 : 0.01;
  matrix_is_new_ = false;
  bool renew = !modified || std::abs(state.jacobian_step - h) > 1e-6 * h;
  double previous = 0;
  for (int iteration = 1; iteration <= settings_.max_newton_iterations; ++iteration) {
    system_.evaluate(q_, v_, evaluation_);
    system_.residual(evaluation_, vdot_, lambda_, u_, r_);
    if (renew) {
      ++state.counters.jacobian_evaluations;
      if (!prepare_matrix(u_)) {
        failure.reason = StepFailure::Reason::singular;
        return false;
      }
    }
    ++state.counters.newton_iterations;
    failure.iterations = iteration;
    correct(state);

    const double increment = scaled_increment(state, fraction, failure.body);
    failure.measure = increment;
    if (!std::isfinite(increment)) {
      failure.reason = StepFailure::Reason::not_finite;
      return false;
    }
    const double contractivity = iteration > 1 ? increment / previous : 0.0;
    const bool contracts = iteration > 1 && contractivity < 1.0;
    if (increment <= 1.0 || (contracts && increment * contractivity <= 1.0 - contractivity)) {
      commit(state, t);
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

// From the state at the start of the step alone, so that nothing of it has to be kept.
void GeneralizedAlpha::choose_sigma(const State& s) {
  matrix_.identity_P = true;
  for (int i = 0; i < system_.body_count(); ++i) {
    sigma_[i] = spin_sigma_(i, s.v.segment<3>(6 * i + 3), s.vdot.segment<3>(6 * i + 3), h_);
    matrix_.identity_P = matrix_.identity_P && sigma_[i] == 1.0;
  }
}

// Lines 1-7 of Alg. 1. The residual form may start from any vdot and lambda: they do not change its result.
void GeneralizedAlpha::predict(const State& s) {
  const auto& [alpha_m, alpha_f, beta, gamma] = alpha_;
  a_n_ = s.vdot + (h_ / s.a_step) * (s.a - s.vdot);  // a_n belongs to a step size: keeps order 2 when h changes
  mu_.setZero();
  B_mu_.setZero();
  if (!residual_form_ || settings_.is(Predictor::zero)) {
    vdot_.setZero();
    lambda_.setZero();
  } else {
    vdot_ = s.vdot;
    lambda_ = s.lambda;
    if (settings_.is(Predictor::extrapolated)) {
      vdot_ += (h_ / s.a_step) * (s.vdot - s.vdot_old);
      lambda_ += (h_ / s.a_step) * (s.lambda - s.lambda_old);
    }
  }
  a_ = ((1 - alpha_f) * vdot_ + alpha_f * s.vdot - alpha_m * a_n_) / (1 - alpha_m);
  v_ = s.v + h_ * ((1 - gamma) * a_n_ + gamma * a_);
  theta_ = h_ * s.v + h_ * h_ * ((0.5 - beta) * a_n_ + beta * a_);
  c_ = h_ * (1 - beta / gamma) * s.v + h_ * h_ * (0.5 - beta / gamma) * a_n_;
  for (int i = 0; i < system_.body_count(); ++i) {
    const Vector3d theta = rotation(theta_, i);
    const Vector3d v = rotation(v_, i);
    if (residual_form_) {  // (12) with (16), theta on its right side from the line above
      rotation(theta_, i) += sigma_[i] / gamma_prime_ * (lie::tangent_inverse_times(theta, v) - v);
    } else {  // line 6, as printed
      rotation(theta_, i) -= sigma_[i] / gamma_prime_ * v.cross(theta);
    }
  }
  if (residual_form_) {
    velocities_from_motion(s);
  } else {
    for (int i = 0; i < system_.body_count(); ++i) {
      q_.segment<7>(7 * i) = lie::compose(s.q.segment<7>(7 * i), theta_.segment<6>(6 * i));
    }
  }
}

bool GeneralizedAlpha::prepare_matrix(const VectorXd& u) {
  const bool full = settings_.is(Jacobian::full);
  for (int i = 0; i < system_.body_count(); ++i) {
    if (!full || (matrix_.identity_P && !residual_form_)) continue;
    const Vector3d theta = rotation(theta_, i);
    if (!matrix_.identity_P) {
      const Matrix3d P = sigma_[i] * Matrix3d::Identity() + (1 - sigma_[i]) * lie::tangent(theta);
      matrix_.P_inverse[i] = P.inverse();
    }
    if (residual_form_) {  // gamma' U = P^-1 d(gamma' (theta - T c) - P v)/dtheta T^-1
      const Vector3d w = rotation(c_, i) + (1 - sigma_[i]) / gamma_prime_ * rotation(v_, i);
      const Matrix3d dtheta = Matrix3d::Identity() - lie::tangent_derivative(theta, w);
      matrix_.U_rot[i] = dtheta * lie::tangent_inverse(theta);
      if (!matrix_.identity_P) matrix_.U_rot[i] = (matrix_.P_inverse[i] * matrix_.U_rot[i]).eval();
    } else {
      matrix_.U_rot[i] = matrix_.P_inverse[i];
    }
  }
  if (!settings_.is(Formulation::index3)) system_.constraint_rates(evaluation_);
  system_.linearize(lambda_, u, evaluation_);
  matrix_is_new_ = true;
  return matrix_.factorize(evaluation_, start_, h_, alpha_, factorization_);
}

// Solves for the increments and applies them.
void GeneralizedAlpha::correct(const State& s) {
  const double beta_h2 = alpha_.beta * h_ * h_;
  for (int i = 0; i < system_.body_count(); ++i) {
    x_.segment<6>(matrix_.body_offset(i)) = -beta_h2 * r_.segment<6>(6 * i);
  }
  for (int j = 0; j < system_.joint_count(); ++j) {
    const JointEvaluation& e = evaluation_.joints[j];
    const int m = static_cast<int>(e.phi.size());
    auto first = x_.segment(matrix_.lambda_offset(j), m);
    if (settings_.is(Formulation::index2)) {
      first = e.phidot / -gamma_prime_;
    } else {
      first = -e.phi;
    }
    if (stabilized_) x_.segment(matrix_.mu_offset(j), m) = e.phi - e.phidot / gamma_prime_;
  }
  const Factorization& f = settings_.is(Newton::modified) && !matrix_is_new_ ? s.jacobian : factorization_;
  matrix_.solve(f, x_);

  v_old_ = v_;
  B_mu_.setZero();
  for (int j = 0; j < system_.joint_count(); ++j) {
    const int m = system_.joint(j).equations();
    lambda_.segment(system_.lambda_index(j), m) += x_.segment(matrix_.lambda_offset(j), m) / beta_h2;
    if (stabilized_) mu_.segment(system_.lambda_index(j), m) += x_.segment(matrix_.mu_offset(j), m);
  }
  if (stabilized_) {
    for (const auto& [joint, body, side] : system_.pattern().incidences) {
      const double* row = start_[joint].B[side].data();
      const double* multiplier =
          residual_form_ ? mu_.data() + system_.lambda_index(joint) : x_.data() + matrix_.mu_offset(joint);
      double* out = B_mu_.data() + 6 * body;
      for (int m = 0; m < system_.joint(joint).equations(); ++m, row += 6) {
        for (int c = 0; c < 6; ++c) out[c] += multiplier[m] * row[c];
      }
    }
  }
  if (residual_form_) {
    for (int i = 0; i < system_.body_count(); ++i) {
      const Vector6d dq = x_.segment<6>(matrix_.body_offset(i));
      theta_.segment<3>(6 * i) += dq.head<3>();
      rotation(theta_, i) += lie::tangent_inverse_times(rotation(theta_, i), dq.tail<3>());
    }
    velocities_from_motion(s);
    return;
  }
  for (int i = 0; i < system_.body_count(); ++i) {  // lines 14-18; lines 15-18 of Alg. 2 for sigma != 1
    const Vector6d dq = x_.segment<6>(matrix_.body_offset(i));
    Vector6d dv = gamma_prime_ * (dq + B_mu_.segment<6>(6 * i));
    if (matrix_.identity_P) {
      q_.segment<7>(7 * i) = lie::compose(q_.segment<7>(7 * i), dq);
    } else {
      theta_.segment<3>(6 * i) += dq.head<3>();
      rotation(theta_, i) += lie::tangent_inverse_times(rotation(theta_, i), dq.tail<3>());
      q_.segment<7>(7 * i) = lie::compose(s.q.segment<7>(7 * i), theta_.segment<6>(6 * i));
      const Matrix3d P = sigma_[i] * Matrix3d::Identity() + (1 - sigma_[i]) * lie::tangent(rotation(theta_, i));
      dv.tail<3>() = P.inverse() * dv.tail<3>();
    }
    v_.segment<6>(6 * i) += dv;
    vdot_.segment<6>(6 * i) += beta_prime_ / gamma_prime_ * dv;
  }
}

// v_{n+1} from theta and mu as in the head of generalized_alpha.h, then (14), (15) and (11).
void GeneralizedAlpha::velocities_from_motion(const State& s) {
  const auto& [alpha_m, alpha_f, beta, gamma] = alpha_;
  for (int i = 0; i < system_.body_count(); ++i) {
    const double sigma = sigma_[i];
    const Vector3d theta = rotation(theta_, i);
    Vector6d w = theta_.segment<6>(6 * i) - c_.segment<6>(6 * i);
    w.tail<3>() = theta - lie::tangent_times(theta, rotation(c_, i));
    if (stabilized_) w += B_mu_.segment<6>(6 * i);
    if (sigma != 1.0) {
      const Matrix3d P = sigma * Matrix3d::Identity() + (1 - sigma) * lie::tangent(theta);
      w.tail<3>() = (P.inverse() * w.tail<3>()).eval();
    }
    v_.segment<6>(6 * i) = gamma_prime_ * w;
    q_.segment<7>(7 * i) = lie::compose(s.q.segment<7>(7 * i), theta_.segment<6>(6 * i));
  }
  a_ = (v_ - s.v) / (h_ * gamma) - ((1 - gamma) / gamma) * a_n_;
  vdot_ = ((1 - alpha_m) * a_ + alpha_m * a_n_ - alpha_f * s.vdot) / (1 - alpha_f);
}

// Largest velocity increment over a fraction of its tolerance, all bodies, translation and rotation apart. The floor is
// the rounding of the positions, seen through gamma'.
double GeneralizedAlpha::scaled_increment(const State& s, double fraction, int& worst_body) const {
  constexpr double kFloor = 8 * std::numeric_limits<double>::epsilon();
  double largest = 0;
  for (int i = 0; i < system_.body_count(); ++i) {
    const double size[2] = {s.q.segment<3>(7 * i).norm(), 1.0};  // [m], [rad]
    for (int part = 0; part < 2; ++part) {
      const auto v = v_.segment<3>(6 * i + 3 * part);
      const double dv = (v - v_old_.segment<3>(6 * i + 3 * part)).norm();
      const double dq = gamma_prime_ * x_.segment<3>(matrix_.body_offset(i) + 3 * part).norm();
      const double tolerance = fraction * (settings_.absolute_tolerance + settings_.relative_tolerance * v.norm()) +
                               kFloor * gamma_prime_ * size[part];
      const double scaled = std::max(dv, dq) / tolerance;
      if (!(scaled <= largest)) {
        largest = scaled;
        worst_body = i;
      }
      if (!std::isfinite(scaled)) return scaled;
    }
  }
  return largest;
}

double GeneralizedAlpha::largest_rotation_increment() const {
  double largest = 0;
  for (int i = 0; i < system_.body_count(); ++i) {
    largest = std::max(largest, x_.segment<3>(matrix_.body_offset(i) + 3).norm());
  }
  return largest;
}

void GeneralizedAlpha::commit(State& s, double t) {
  if (!residual_form_) {  // last line of the algorithms
    a_ = ((1 - alpha_.alpha_f) * vdot_ + alpha_.alpha_f * s.vdot - alpha_.alpha_m * a_n_) / (1 - alpha_.alpha_m);
  }
  for (int j = 0; j < system_.joint_count(); ++j) {  // the turn nearest to the angle that the rate predicts
    const Joint& joint = system_.joint(j);
    if (joint.type() != JointType::revolute) continue;
    const auto& k1 = system_.kinematics(evaluation_, joint.body1());
    const auto& k2 = system_.kinematics(evaluation_, joint.body2());
    const double wrapped = joint.coordinate(k1, k2);
    const double predicted = s.angle[j] + h_ * joint.coordinate_rate(k1, k2);
    s.angle[j] = wrapped + 2 * kPi * std::round((predicted - wrapped) / (2 * kPi));
  }
  s.time = t;
  s.q = q_;
  s.v = v_;
  if (settings_.is(Predictor::extrapolated)) {
    s.vdot_old = s.vdot;
    s.lambda_old = s.lambda;
  }
  s.vdot = vdot_;
  s.a = a_;
  s.lambda = lambda_;
  s.a_step = h_;
  ++s.counters.steps;
  if (settings_.is(Newton::modified) && matrix_is_new_) {
    std::swap(s.jacobian, factorization_);
    s.jacobian_step = h_;
  }
}

}  // namespace sigmafmu
