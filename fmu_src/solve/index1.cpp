#include "solve/index1.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "lie/r3xso3.h"
#include "solve/start/dependent_equations.h"
#include "text/text.h"

namespace sigmafmu {
namespace {

// Of the joints' equations after a solution, against the accelerations: rounding leaves less.
constexpr double kNegligibleDefect = 2e-12;
// Of soft equations against a step's: refinement takes it out again, and what contradictions of dependent equations do
// to multipliers is that much smaller. Near singular positions that takes too long, and they get a step's.
constexpr double kFirstCompliance = 100;

template <typename Vector>
double largest(const Vector& x) {
  double result = 0;
  for (double entry : x) result = std::max(result, std::abs(entry));
  return result;
}

}  // namespace

ConsistentSolver::ConsistentSolver(const System& system, KktPlans plans)
    : system_(system),
      evaluation_(system.make_evaluation()),
      lu_(plans.get(system.pattern(), Kkt::index1)),
      factorization_(lu_->make_factorization()),
      u_(system.make_inputs()) {
  const BlockPattern& pattern = system.pattern();
  for (int p = 0; p < pattern.inertia_pairs; ++p) {
    pairs_.push_back(lu_->handle(pattern.pairs[p].row, pattern.pairs[p].column));
  }
  for (const auto& [constraint, unknown, offset] : pattern.incidences) {
    rows_.push_back(lu_->handle(pattern.lambda_node(constraint), unknown));
    columns_.push_back(lu_->handle(unknown, pattern.lambda_node(constraint)));
  }
  for (const auto& [constraint, row, force, motion] : system.compliance().equations) {
    const int node = pattern.lambda_node(constraint), count = pattern.constraint_sizes[constraint];
    soft_.push_back({lu_->handle(node, node) + row * count + row, force});
  }
  for (int c = 0; c < system.constraint_count(); ++c) {
    const int node = pattern.lambda_node(c), count = pattern.constraint_sizes[c];
    for (int row = count - pattern.velocity_equations[c]; row < count; ++row) {
      velocity_diagonals_.push_back(lu_->handle(node, node) + row * (count + 1));
    }
  }
  const int n = system.velocity_size();
  for (VectorXd* x : {&zero_velocity_, &r_, &v_s_, &vdot_minus_, &vdot_plus_}) x->setZero(n);
  for (VectorXd* x : {&zero_lambda_, &lambda_s_, &gamma_, &defect_}) x->setZero(system.constraint_size());
  x_.setZero(n + system.constraint_size());
  q_s_.setZero(system.position_size());
}

bool ConsistentSolver::factorize(double compliance, bool positions) {
  lu_->clear(factorization_);
  const BlockPattern& pattern = system_.pattern();
  double* values = factorization_.values.data();
  for_each_pair(pattern, pattern.inertia_pairs, [&](int p, auto R, auto C) {
    const auto& [i, j, offset] = pattern.pairs[p];
    const int rows = pattern.unknowns[i].size, columns = pattern.unknowns[j].size;
    Eigen::Map<Eigen::Matrix<double, R, C, Eigen::RowMajor>> block(values + pairs_[p], rows, columns);
    block = ConstPairBlock<R, C>(evaluation_.M.data() + offset, rows, columns);
  });
  for (std::size_t k = 0; k < pattern.incidences.size(); ++k) {
    const auto& [constraint, unknown, offset] = pattern.incidences[k];
    const int m = pattern.constraint_sizes[constraint], size = pattern.unknowns[unknown].size;
    const double* B = evaluation_.B.data() + offset;
    std::copy_n(B, m * size, values + rows_[k]);
    double* column = values + columns_[k];
    for (int r = 0; r < m; ++r) {
      for (int c = 0; c < size; ++c) column[c * m + r] = B[r * size + c];
    }
  }
  for (const SoftEquation& soft : soft_) values[soft.place] -= compliance * soft.compliance;
  if (positions) {
    for (int diagonal : velocity_diagonals_) values[diagonal] -= 1;
  }
  return lu_->factorize(factorization_);
}

void ConsistentSolver::solve() { lu_->solve(factorization_, x_.data()); }

bool ConsistentSolver::accelerations(const VectorXd& q, const VectorXd& v, const Inputs& u, VectorXd& vdot,
                                     VectorXd& lambda) {
  system_.evaluate(q, v, u, evaluation_);
  system_.constraint_rates(u, evaluation_);
  gamma_ = -evaluation_.W;
  system_.subtract_rows_times(evaluation_.Z, v.data(), gamma_);
  const bool solved = soft() ? solve_accelerations(kFirstCompliance, 1e-6, u, vdot, lambda) ||
                                   solve_accelerations(1, 1e-3, u, vdot, lambda)
                             : solve_accelerations(1, 1e-8, u, vdot, lambda);
  return solved && x_.allFinite();
}

// False when the equations of joints miss by more than `tolerable` of all accelerations, and of what any force
// explains.
bool ConsistentSolver::solve_accelerations(double compliance, double tolerable, const Inputs& u, VectorXd& vdot,
                                           VectorXd& lambda) {
  singular_ = !factorize(compliance);
  if (singular_) return false;
  system_.residual(evaluation_, zero_velocity_, zero_lambda_, u, r_);
  motion() = -r_;
  multipliers() = gamma_;
  solve();
  if (constraint_defect() > kNegligibleDefect && !refine(tolerable, u, vdot, lambda)) return false;
  vdot = motion();
  lambda = multipliers();
  return true;
}

// Largest entry of defect_ = -Z v - W - B vdot, over that of all accelerations. Bodies are eliminated before their
// joints, which leaves their equations no error but rounding: where light bodies cost digits, it is the joints'
// equations that show it.
double ConsistentSolver::constraint_defect() {
  defect_ = gamma_;
  system_.subtract_rows_times(evaluation_.B, x_.data(), defect_);
  return largest(defect_) / std::max(largest(motion()), std::numeric_limits<double>::min());
}

// Iterative refinement of x_ until the defect no longer falls; false when it stays above what any motion explains. In
// positions or with velocities off their constraints dependent equations contradict each other by as much.
bool ConsistentSolver::refine(double tolerable, const Inputs& u, VectorXd& vdot, VectorXd& lambda) {
  constexpr int kMaxRefinements = 20;
  double driving = 0;  // an acceleration that the forces can give to the heaviest body
  for (int part = 0; part < 2; ++part) {
    double force = 0, inertia = 0;
    for (int i = 0; i < system_.body_count(); ++i) {
      const ConstPairBlock<6, 6> M(evaluation_.M.data() + system_.pattern().pairs[i].offset);
      force = std::max(force, r_.segment<3>(6 * i + 3 * part).cwiseAbs().maxCoeff());
      inertia = std::max(inertia, M.diagonal().segment<3>(3 * part).maxCoeff());
    }
    driving = std::max(driving, force / inertia);
  }
  double defect = INFINITY, before;
  int count = 0;
  do {
    before = defect;
    vdot = motion();
    lambda = multipliers();
    system_.residual(evaluation_, vdot, lambda, u, r_);
    motion() = -r_;
    multipliers() = defect_;
    solve();
    motion() += vdot;
    multipliers() += lambda;
    defect = constraint_defect();
  } while (defect < 0.5 * before && ++count < kMaxRefinements);
  singular_ = defect > tolerable && largest(defect_) > tolerable * driving;
  return !singular_;
}

void ConsistentSolver::displace(const VectorXd& q, const VectorXd& v, const VectorXd& vdot, double s, VectorXd& q_s,
                                VectorXd& v_s) const {
  v_s = v + s * vdot;
  for (int i = 0; i < system_.body_count(); ++i) {
    const lie::Vector6d theta = s * v.segment<6>(6 * i) + (0.5 * s * s) * vdot.segment<6>(6 * i);
    q_s.segment<7>(7 * i) = lie::compose(q.segment<7>(7 * i), theta);
  }
  const int f = system_.modal_count();
  q_s.tail(f) = q.tail(f) + s * v.tail(f) + (0.5 * s * s) * vdot.tail(f);
}

double ConsistentSolver::difference_time(const VectorXd& v) const {
  double w = 1.0;  // [rad/s]
  for (int i = 0; i < system_.body_count(); ++i) w = std::max(w, v.segment<3>(6 * i + 3).norm());
  for (int f = 0; f < system_.flexible_count(); ++f) w = std::max(w, system_.flexible(f).highest_frequency());
  double lightest = INFINITY, least_inertia = INFINITY;
  for (int i = 0; i < system_.body_count(); ++i) {
    const RigidBody* body = system_.rigid(i);
    if (!body) continue;
    lightest = std::min(lightest, body->mass);
    least_inertia = std::min(least_inertia, body->J.diagonal().minCoeff());
  }
  const Stiffest springs = system_.stiffest();  // energies swing twice as fast, and bars rock faster still
  w = std::max(w, 4 * std::sqrt(springs.translation / lightest));
  w = std::max(w, 4 * std::sqrt(springs.rotation / least_inertia));
  return 1e-4 / w;
}

bool ConsistentSolver::jerk(const VectorXd& q, const VectorXd& v, const VectorXd& vdot, const InputSignal& input,
                            const VectorXd& turned, double t, VectorXd& vddot) {
  const double s = difference_time(v);
  displace(q, v, vdot, -s, q_s_, v_s_);
  input.value(t - s, turned, u_);
  if (!accelerations(q_s_, v_s_, u_, vdot_minus_, lambda_s_)) return false;
  displace(q, v, vdot, s, q_s_, v_s_);
  input.value(t + s, turned, u_);
  if (!accelerations(q_s_, v_s_, u_, vdot_plus_, lambda_s_)) return false;
  vddot = (vdot_plus_ - vdot_minus_) / (2 * s);
  return true;
}

ConsistentSolver::Assembly ConsistentSolver::project_positions(const Inputs& u, VectorXd& q) {
  constexpr int kMaxIterations = 50;
  constexpr double kReached = 1e-12, kRounding = 1e-15, kMaxRotation = 0.5;  // [m or 1], [rad]
  Assembly result{true, -1, 0, 0};
  double previous = INFINITY;
  for (;; ++result.iterations) {
    system_.evaluate(q, zero_velocity_, u, evaluation_);
    system_.clear_velocity_rows(evaluation_);
    result.residual = 0;
    for (int c = 0; c < system_.constraint_count(); ++c) {
      const auto phi = evaluation_.phi.segment(system_.lambda_index(c), system_.constraint(c).equations());
      const double largest = phi.allFinite() ? phi.lpNorm<Eigen::Infinity>() : INFINITY;  // the norm may drop a NaN
      if (largest > result.residual) result.residual = largest, result.worst_joint = c;
    }
    const double scale = 1.0 + q.lpNorm<Eigen::Infinity>();
    const bool reached = std::isfinite(result.residual) && result.residual <= kReached * scale;
    if (reached && (result.residual <= kRounding * scale || result.residual >= 0.5 * previous)) return result;
    result.possible = reached;
    if (result.iterations == kMaxIterations || !std::isfinite(result.residual) || !factorize(1, true)) return result;
    previous = result.residual;

    motion().setZero();
    multipliers() = -evaluation_.phi;
    solve();
    double rotation = 0;
    for (int i = 0; i < system_.body_count(); ++i) {
      rotation = std::max(rotation, motion().segment<3>(6 * i + 3).norm());
    }
    if (rotation > kMaxRotation) motion() *= kMaxRotation / rotation;
    for (int i = 0; i < system_.body_count(); ++i) {
      q.segment<7>(7 * i) = lie::compose(q.segment<7>(7 * i), motion().segment<6>(6 * i));
    }
    q.tail(system_.modal_count()) += motion().tail(system_.modal_count());
    result.possible = true;
  }
}

bool ConsistentSolver::project_velocities(const VectorXd& q, const Inputs& u, VectorXd& v) {
  // The second time removes the rounding of the first, more of them what compliance leaves.
  for (int repeat = 0; repeat < (soft() ? 4 : 2); ++repeat) {
    system_.evaluate(q, v, u, evaluation_);
    if (!factorize()) return false;
    motion().setZero();
    multipliers() = -evaluation_.phidot;
    solve();
    v += motion();
  }
  return v.allFinite();
}

}  // namespace sigmafmu
