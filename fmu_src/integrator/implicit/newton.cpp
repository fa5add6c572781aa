#include "integrator/implicit/newton.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sigmafmu {

namespace {

// With the exact matrix convergence is quadratic and what remains is far below the last increment. Otherwise it is
// linear, and the remainders of many steps add up: ask for more. The multipliers of index 3 see them over h^2: with
// about one iteration more they have no other noise than that of rounded positions.
double fraction_of_tolerance(const IntegratorSettings& settings, bool exact) {
  if (settings.is(Newton::modified)) return settings.is(Formulation::index3) ? 1e-5 : 0.01;
  return exact && settings.is(Jacobian::full) ? 1.0 : 0.01;
}

}  // namespace

NewtonMethod::NewtonMethod(const Problem& problem, bool exact)
    : problem_(problem),
      modified_(problem.settings.is(Newton::modified)),
      full_(problem.settings.is(Jacobian::full)),
      fraction_(fraction_of_tolerance(problem.settings, exact)),
      matrix_(problem.system, static_cast<Formulation>(problem.settings.formulation), problem.plans,
              kLeastScale * problem.settings.step_size * problem.settings.step_size),
      tangents_(problem.system.body_count()),
      factorization_(matrix_.make_factorization()),
      evaluation_(problem.system.make_evaluation()) {
  for (VectorXd* x : {&r_, &v_old_}) x->setZero(problem.system.velocity_size());
  x_.setZero(matrix_.size());
}

void NewtonMethod::make_state(State& s) const {
  if (modified_) s.jacobian = matrix_.make_factorization();
}

bool NewtonMethod::solve(const StepStart& start, const StepEquations& equations, State& s, Iterate& at,
                         StepFailure& failure) {
  const LocalCoordinates& coordinates = *problem_.coordinates;
  if (!problem_.unambiguous(at.theta, failure)) return false;
  at.mu.setZero();
  at.B_mu.setZero();
  follow(equations, start, s.q, at);
  begin(start, s);
  while (evaluate(start, at, failure)) {
    if (matrix_due()) {
      coordinates.tangents(equations, s.q, at, full_, tangents_);
      if (!factorize(start, equations.scales, tangents_, at, s, failure)) return false;
    }
    const VectorXd& x = increments(equations.scales, s, at, failure);
    coordinates.add_motion(at.q, x, at.theta);
    if (problem_.stabilized) {
      problem_.system.gradient_times(start.evaluation, at.mu, at.B_mu);
      coordinates.turn_to_group(s.q, at.B_mu);
    }
    follow(equations, start, s.q, at);
    if (converged(equations.scales, s, at, failure)) return true;
  }
  return false;
}

// All that theta and mu make of an iterate.
void NewtonMethod::follow(const StepEquations& equations, const StepStart& start, const VectorXd& q_n,
                          Iterate& at) const {
  const LocalCoordinates& coordinates = *problem_.coordinates;
  coordinates.velocities(equations, at.theta, problem_.stabilized ? &at.B_mu : nullptr, at.V);
  coordinates.compose(q_n, at.theta, at.q);
  at.Vdot = equations.slope * (at.V - start.V) + equations.offset;
  coordinates.iterate_to_mixed(at);
}

void NewtonMethod::begin(const StepStart& start, const State& s) {
  matrix_is_new_ = false;
  due_ = !modified_ || start.fresh || std::abs(s.jacobian_step - start.h) > 1e-6 * start.h;
}

bool NewtonMethod::evaluate(const StepStart& start, const Iterate& at, StepFailure& failure) {
  if (failure.reason != StepFailure::Reason::none) return false;
  if (failure.iterations == problem_.settings.max_newton_iterations) {
    return failure.because(StepFailure::Reason::no_convergence);
  }
  problem_.system.evaluate(at.q, at.v(), start.u, evaluation_);
  problem_.system.residual(evaluation_, at.vdot(), at.lambda, start.u, r_);
  return true;
}

bool NewtonMethod::factorize(const StepStart& start, const StepScales& scales, const BodyTangents& tangents,
                             const Iterate& at, State& s, StepFailure& failure) {
  const System& system = problem_.system;
  ++s.counters.jacobian_evaluations;
  const bool of_velocities = !problem_.settings.is(Formulation::index3) || !system.velocity_equations().empty();
  if (of_velocities) system.constraint_rates(start.u, evaluation_);
  system.linearize(at.vdot(), at.lambda, start.u, evaluation_);
  matrix_is_new_ = true;
  if (matrix_.factorize(evaluation_, start.evaluation, scales, tangents, factorization_)) return true;
  if (std::isfinite(r_.squaredNorm())) return failure.because(StepFailure::Reason::singular);
  Eigen::Index largest = 0;  // forces that overflow in the factorization
  r_.head(kVelocitiesPerBody * system.body_count()).cwiseAbs().maxCoeff(&largest);
  failure.body = static_cast<int>(largest) / kVelocitiesPerBody;
  return failure.because(StepFailure::Reason::not_finite);
}

const VectorXd& NewtonMethod::increments(const StepScales& scales, State& s, Iterate& at, StepFailure& failure) {
  ++s.counters.newton_iterations;
  ++failure.iterations;
  v_old_ = at.v();
  matrix_.right_side(evaluation_, r_, scales, x_);
  if (matrix_.soft()) matrix_.add_compliance(at.lambda, at.mu, scales, x_);
  matrix_.solve(modified_ && !matrix_is_new_ ? s.jacobian : factorization_, x_);
  matrix_.add_multipliers(x_, scales, at.lambda, at.mu);
  return x_;
}

// Whether the next increment is below the tolerance; if not, whether the next iteration needs another matrix.
bool NewtonMethod::converged(const StepScales& scales, const State& s, const Iterate& at, StepFailure& failure) {
  const double previous = failure.measure;
  const double increment = failure.measure = scaled_increment(scales, s, at, failure.body);
  if (!std::isfinite(increment)) return failure.because(StepFailure::Reason::not_finite);
  const bool first = failure.iterations == 1;
  const double contractivity = first ? 0.0 : increment / previous;
  const bool contracts = !first && contractivity < 1.0;
  if (increment <= 1.0 || (contracts && increment * contractivity <= 1.0 - contractivity)) return true;
  if (modified_) {
    due_ = contractivity > kMaxContractivity || failure.iterations % kMaxStaleIterations == 0;
  } else {  // the matrix depends on the rotations above all; unless they changed, a new one would be the same
    due_ = contractivity > kNewtonContractivity || largest_rotation_increment() > kNegligibleRotation;
  }
  return false;
}

// Largest velocity increment over a fraction of its tolerance, all bodies, translation, rotation and modes apart. The
// floor is the rounding of the positions, of this body and of what joints hold it to, seen through gamma'.
double NewtonMethod::scaled_increment(const StepScales& scales, const State& s, const Iterate& at,
                                      int& worst_body) const {
  constexpr double kFloor = 8 * std::numeric_limits<double>::epsilon();
  const System& system = problem_.system;
  const IntegratorSettings& settings = problem_.settings;
  const VectorXd& v = at.v();
  double largest = 0;
  // Norms of a part of body i: its velocity, the increments of velocity and motion, its position [m] or [rad].
  const auto add = [&](int i, double v, double dv, double dq, double size) {
    const double tolerance = fraction_ * (settings.absolute_tolerance + settings.relative_tolerance * v) +
                             kFloor * scales.gamma_prime * size;
    const double scaled = std::max(dv, scales.gamma_prime * dq) / tolerance;
    if (scaled <= largest || std::isnan(largest)) return;
    largest = scaled;
    worst_body = i;
  };
  for (int i = 0; i < system.body_count(); ++i) {
    const double size[2] = {std::max(s.q.segment<3>(kPositionsPerBody * i).norm(), system.size()), 1.0};
    for (int part = 0; part < 2; ++part) {
      const int k = kVelocitiesPerBody * i + 3 * part;
      add(i, v.segment<3>(k).norm(), (v.segment<3>(k) - v_old_.segment<3>(k)).norm(), x_.segment<3>(k).norm(),
          size[part]);
    }
  }
  for (int f = 0; f < system.flexible_count(); ++f) {
    const int k = system.modal_velocity(f), count = system.flexible(f).modes();
    add(system.flexible_body(f), v.segment(k, count).norm(), (v.segment(k, count) - v_old_.segment(k, count)).norm(),
        x_.segment(k, count).norm(),
        std::max(s.q.segment(system.modal_position(f), count).norm(), problem_.measure.modal_size(f)));
  }
  return largest;
}

double NewtonMethod::largest_rotation_increment() const {
  double largest = 0;
  for (int i = 0; i < problem_.system.body_count(); ++i) {
    largest = std::max(largest, x_.segment<3>(kVelocitiesPerBody * i + 3).norm());
  }
  return largest;
}

void NewtonMethod::keep_matrix(const StepStart& start, State& s) {
  if (!modified_ || !matrix_is_new_) return;
  std::swap(s.jacobian, factorization_);
  s.jacobian_step = start.fresh ? 0 : start.h;  // that of another method, if fresh
}

}  // namespace sigmafmu
