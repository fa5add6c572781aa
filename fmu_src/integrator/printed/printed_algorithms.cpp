#include "integrator/printed/printed_algorithms.h"

namespace sigmafmu {

PrintedAlgorithms::PrintedAlgorithms(Problem& problem)
    : IntegrationMethod(StepEnds::error_control(problem.settings)),
      problem_(problem),
      alpha_(problem.settings.spectral_radius),
      printed_(make_printed_coordinates(problem.settings)),
      ends_(problem),
      newton_(problem, false),
      start_(problem.system),
      equations_(problem.system, true, problem.settings.sigma),
      at_(problem.system, problem.coordinates->mixed),
      tangents_(problem.system.body_count()) {
  for (VectorXd* x : {&a_n_, &a_, &dV_}) x->setZero(problem.system.velocity_size());
}

void PrintedAlgorithms::make_state(State& s) const {
  s.a = s.vdot;
  newton_.make_state(s);
}

void PrintedAlgorithms::start(State& s, const VectorXd&, const VectorXd& Vdot, const VectorXd& jerk) const {
  s.a = Vdot + alpha_.shift() * s.last_step * jerk;
  s.jacobian_step = 0;
}

// Steps of another length than the last one are done as in generalized_alpha.h.
bool PrintedAlgorithms::attempt(State& s, double h, const InputSignal& input, StepFailure& failure) {
  if (h < StepEnds::kDrift) {
    if (!ends_.drift(s, h, input, failure)) return false;
    s.a += ends_.dVdot();
    return true;
  }
  if (!ends_.begin(s, h, StepEnds::kMemory, input, start_, failure)) return false;
  const AlphaParameters& p = start_.fresh ? trapezoidal_ : alpha_;
  predict(p, s);
  if (!iterate(s, failure)) return false;
  if (!ends_.complete(start_, p.position_error(), newton_, at_, s, failure)) return false;
  if (start_.fresh) {
    s.a = at_.Vdot + alpha_.shift() * (at_.Vdot - start_.Vdot);
  } else {
    find_a(p, s.a);  // the last line
  }
  return true;
}

// a_{n+1} of (15).
void PrintedAlgorithms::find_a(const AlphaParameters& p, VectorXd& a) const {
  a = ((1 - p.alpha_f) * at_.Vdot + p.alpha_f * start_.Vdot - p.alpha_m * a_n_) / (1 - p.alpha_m);
}

// Lines 1-7 of Alg. 1.
void PrintedAlgorithms::predict(const AlphaParameters& p, const State& s) {
  const double h = start_.h;
  const VectorXd &V_n = start_.V, &Vdot_n = start_.Vdot;
  equations_.scales = p.scales(h);
  if (start_.fresh) {
    a_n_ = Vdot_n;
  } else {
    a_n_ = Vdot_n + (h / s.last_step) * (s.a - Vdot_n);
  }
  at_.Vdot.setZero();
  at_.lambda.setZero();
  find_a(p, a_);
  at_.V = V_n + h * ((1 - p.gamma) * a_n_ + p.gamma * a_);
  at_.theta = h * V_n + h * h * ((0.5 - p.beta) * a_n_ + p.beta * a_);
  printed_->modify(equations_, at_.V, at_.theta);
  problem_.coordinates->compose(s.q, at_.theta, at_.q);
  problem_.coordinates->iterate_to_mixed(at_);
}

// The loop of the algorithms.
bool PrintedAlgorithms::iterate(State& s, StepFailure& failure) {
  const StepScales& scales = equations_.scales;
  if (!problem_.unambiguous(at_.theta, failure)) return false;
  newton_.begin(start_, s);
  while (newton_.evaluate(start_, at_, failure)) {
    if (newton_.matrix_due()) {
      if (problem_.settings.is(Jacobian::full)) {
        printed_->tangents(equations_, s.q, at_, tangents_);
      } else {
        problem_.coordinates->tangents(equations_, s.q, at_, false, tangents_);
      }
      if (!newton_.factorize(start_, scales, tangents_, at_, s, failure)) return false;
    }
    at_.mu.setZero();
    correct(s.q, newton_.increments(scales, s, at_, failure));
    if (newton_.converged(scales, s, at_, failure)) return true;
  }
  return false;
}

// Lines 14-18 of Alg. 1 and 3; lines 15-18 of Alg. 2 for sigma != 1.
void PrintedAlgorithms::correct(const VectorXd& q_n, const VectorXd& x) {
  const LocalCoordinates& coordinates = *problem_.coordinates;
  dV_ = x.head(dV_.size());
  coordinates.turn_to_group(at_.q, dV_);
  if (problem_.settings.sigma == 1.0) {
    coordinates.compose(at_.q, dV_, at_.q);
  } else {
    coordinates.add_motion(at_.q, x, at_.theta);
    coordinates.compose(q_n, at_.theta, at_.q);
  }
  if (problem_.stabilized) {
    problem_.system.gradient_times(start_.evaluation, at_.mu, at_.B_mu);
    coordinates.turn_to_group(q_n, at_.B_mu);
    dV_ += at_.B_mu;
  }
  printed_->solve_P(equations_, at_.theta, dV_);
  at_.V += equations_.scales.gamma_prime * dV_;
  at_.Vdot += equations_.scales.beta_prime * dV_;
  coordinates.iterate_to_mixed(at_);
}

}  // namespace sigmafmu
