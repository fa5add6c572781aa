#include "solve/newton_matrix.h"

#include <algorithm>
#include <set>
#include <utility>

namespace sigmafmu {
namespace {

using Eigen::Dynamic;
template <int R, int C>
using RowMajorBlock = Eigen::Map<Eigen::Matrix<double, R, C, (C == 1 && R != 1) ? Eigen::ColMajor : Eigen::RowMajor>>;

template <int N>
using Block = Eigen::Matrix<double, N, N>;

// Of the last N velocities.
template <int N>
Block<N> last(const Matrix6d& A) {
  return A.bottomRightCorner<N, N>();
}

// row (m x 6) += A_N X in the last N columns, A_N those columns of A (m x 6).
template <int N>
void add_product(int m, const double* A, const Block<N>& X, double* row) {
  constexpr int first = kVelocitiesPerBody - N;
  for (int r = 0; r < m; ++r, row += kVelocitiesPerBody, A += kVelocitiesPerBody) {
    const double* a = A + first;
    for (int c = 0; c < N; ++c) {
      double sum = a[0] * X(0, c);
      for (int k = 1; k < N; ++k) sum += a[k] * X(k, c);
      row[first + c] += sum;
    }
  }
}

// out (Size x m) += D (Size x Columns) A^T, A m x Columns.
template <typename Matrix>
void add_product_transposed(const Matrix& D, int m, const double* A, double* out) {
  constexpr int kColumns = Matrix::ColsAtCompileTime;
  const Eigen::Index columns = D.cols();
  for (Eigen::Index c = 0; c < D.rows(); ++c) {
    const double* a = A;
    if constexpr (kColumns == Dynamic) {
      for (int r = 0; r < m; ++r, a += columns, ++out) {
        for (Eigen::Index k = 0; k < columns; ++k) *out += D(c, k) * a[k];
      }
    } else {
      const Eigen::Matrix<double, 1, kColumns> row = D.row(c);
      for (int r = 0; r < m; ++r, a += columns) *out++ += kernels::dot<kColumns>(kColumns, row.data(), a);
    }
  }
}

}  // namespace

NewtonMatrix::NewtonMatrix(const System& system, Formulation formulation, KktPlans plans, double least_scale)
    : system_(system),
      formulation_(system.constraint_size() > 0 ? formulation : Formulation::index3),
      least_scale_(least_scale),
      lu_(plans.get(system.pattern(), stabilized() ? Kkt::stabilized : Kkt::newton)) {
  const BlockPattern& pattern = system.pattern();
  for (const auto& [constraint, row, force, motion] : system.compliance().equations) {
    const int lambda = pattern.lambda_node(constraint), diagonal = row * (pattern.constraint_sizes[constraint] + 1);
    const bool of_velocities = row >= pattern.constraint_sizes[constraint] - pattern.velocity_equations[constraint];
    SoftEquation soft{system.lambda_index(constraint) + row,
                      force,
                      motion,
                      lu_->handle(lambda, lambda) + diagonal,
                      0,
                      0,
                      of_velocities};
    if (stabilized() && !of_velocities) {
      const int mu = pattern.mu_node(constraint);
      soft.diagonal_mu = lu_->handle(mu, mu) + diagonal;
      soft.below = lu_->handle(mu, lambda) + diagonal;
    }
    soft_.push_back(soft);
  }
  for (const auto& pair : pattern.pairs) pairs_.push_back(lu_->handle(pair.row, pair.column));
  const int last = pattern.inertia_pairs;
  std::vector<std::vector<int>> mixed(pattern.unknown_count()), met(pattern.unknown_count());
  std::vector<int> own(pattern.unknown_count());
  for (int p = 0; p < last; ++p) {
    const auto& pair = pattern.pairs[p];
    if (pair.row == pair.column) {
      own[pair.column] = pair.offset;
    } else {
      mixed[pair.column].push_back(p);
    }
  }
  for (std::size_t k = 0; k < pattern.incidences.size(); ++k) {
    const auto& [constraint, unknown, offset] = pattern.incidences[k];
    const int lambda = pattern.lambda_node(constraint);
    Incident incident{lu_->handle(unknown, lambda), lu_->handle(lambda, unknown), 0, 0, own[unknown]};
    if (stabilized()) {
      const int mu = pattern.mu_node(constraint);
      incident.column_mu = lu_->handle(unknown, mu);
      incident.row_mu = lu_->handle(mu, unknown);
    }
    incidences_.push_back(incident);
    met[unknown].push_back(static_cast<int>(k));
  }
  if (stabilized()) {
    for (const std::vector<int>& incidences : met) {
      for (int a : incidences) {
        for (int b : incidences) {
          const int row = pattern.incidences[a].constraint, column = pattern.incidences[b].constraint;
          shared_.push_back({a, b, lu_->handle(pattern.mu_node(row), pattern.mu_node(column))});
        }
        const auto& [constraint, unknown, offset] = pattern.incidences[a];
        for (int p : mixed[unknown]) {
          mixed_.push_back({a, p, lu_->handle(pattern.pairs[p].row, pattern.mu_node(constraint))});
        }
      }
    }
  }
  if (!system.velocity_equations().empty()) place_velocity_equations();
  S_ = system.make_evaluation().C;
}

void NewtonMatrix::place_velocity_equations() {
  if (formulation_ == Formulation::index2) return;
  const BlockPattern& pattern = system_.pattern();
  for (std::size_t k = 0; k < pattern.incidences.size(); ++k) {
    if (pattern.velocity_equations[pattern.incidences[k].constraint] == 0) continue;
    velocity_incidences_.push_back(static_cast<int>(k));
  }
  if (!stabilized()) return;
  std::set<std::pair<int, int>> pairs;  // of constraints that have an unknown in common
  for (const auto& [a, b, block] : shared_) {
    pairs.emplace(pattern.incidences[a].constraint, pattern.incidences[b].constraint);
  }
  for (auto [a, b] : pairs) {
    const int count = pattern.velocity_equations[a], columns = pattern.constraint_sizes[b];
    const int skipped = (pattern.constraint_sizes[a] - count) * columns;
    if (count == 0) continue;
    moved_.push_back({lu_->handle(pattern.mu_node(a), pattern.mu_node(b)) + skipped,
                      lu_->handle(pattern.lambda_node(a), pattern.mu_node(b)) + skipped, count * columns});
    if (a != b) continue;
    for (int i = columns - count; i < columns; ++i) {
      unit_diagonals_.push_back(lu_->handle(pattern.mu_node(a), pattern.mu_node(a)) + i * (columns + 1));
    }
  }
}

bool NewtonMatrix::factorize(const Evaluation& e, const Evaluation& start, const StepScales& step,
                             const BodyTangents& tangents, Factorization& f) {
  return tangents.rotations_only ? factorize_of<3>(e, start, step, tangents, f)
                                 : factorize_of<6>(e, start, step, tangents, f);
}

template <int N>
bool NewtonMatrix::factorize_of(const Evaluation& e, const Evaluation& start, const StepScales& step,
                                const BodyTangents& tangents, Factorization& f) {
  const BlockPattern& pattern = system_.pattern();
  lu_->clear(f);
  write_pairs<N>(e, step, tangents, f);
  for (std::size_t k = 0; k < pattern.incidences.size(); ++k) {
    if (pose(pattern.incidences[k])) {
      write_incidence<N, kVelocitiesPerBody>(static_cast<int>(k), e, start, step, tangents, f);
    } else {
      write_incidence<N, Dynamic>(static_cast<int>(k), e, start, step, tangents, f);
    }
  }
  for (const auto& [incidence, p, column] : mixed_) {
    const auto& [constraint, unknown, offset] = pattern.incidences[incidence];
    add_product_transposed(pair_block(pattern, pattern.pairs[p], std::as_const(S_)),
                           pattern.constraint_sizes[constraint], start.B.data() + offset, f.values.data() + column);
  }
  for (const auto& [a, b, block] : shared_) {
    if (pose(pattern.incidences[a])) {
      add_shared<N, kVelocitiesPerBody>(a, b, e, start, tangents, f.values.data() + block);
    } else {
      add_shared<N, 0>(a, b, e, start, tangents, f.values.data() + block);
    }
  }
  if (!velocity_incidences_.empty()) write_velocity_equations<N>(e, step, tangents, f);
  if (soft()) add_compliance(step, f);
  return lu_->factorize(f);
}

// From the second and third rows of index 3 and of the stabilized form to what velocity equations have: B in that of
// lambda becomes Z/gamma' + B U.
template <int N>
void NewtonMatrix::write_velocity_equations(const Evaluation& e, const StepScales& step, const BodyTangents& tangents,
                                            Factorization& f) const {
  const BlockPattern& pattern = system_.pattern();
  const double inverse_gamma_prime = 1 / step.gamma_prime;
  for (int k : velocity_incidences_) {
    const auto& [constraint, unknown, offset] = pattern.incidences[k];
    const int count = pattern.velocity_equations[constraint], size = pattern.unknowns[unknown].size;
    const int skipped = (pattern.constraint_sizes[constraint] - count) * size;
    double* row = f.values.data() + incidences_[k].row + skipped;
    for (int i = 0; i < count * size; ++i) row[i] += inverse_gamma_prime * e.Z[offset + skipped + i];
    if (pattern.unknowns[unknown].pose) {
      add_product<N>(count, e.B.data() + offset + skipped, last<N>(tangents.U[unknown]) - Block<N>::Identity(), row);
    }
    if (stabilized()) std::fill_n(f.values.data() + incidences_[k].row_mu + skipped, count * size, 0.0);
  }
  for (const auto& [from, to, count] : moved_) {
    for (int i = 0; i < count; ++i) f.values[to + i] += std::exchange(f.values[from + i], 0.0);
  }
  for (int diagonal : unit_diagonals_) f.values[diagonal] = 1;
}

void NewtonMatrix::add_compliance(const StepScales& step, Factorization& f) const {
  const double factor = softening(step);
  for (const SoftEquation& soft : soft_) {
    const double e = factor * soft.force;
    f.values[soft.diagonal] -= e;
    if (!stabilized() || soft.of_velocities) continue;
    f.values[soft.below] += e;
    f.values[soft.diagonal_mu] += soft.motion;
  }
}

// (kappa M + scale gamma' C) U + kappa M E + scale K; then D P^-1 in place of kappa M + scale gamma' C.
template <int N>
void NewtonMatrix::write_pairs(const Evaluation& e, const StepScales& step, const BodyTangents& tangents,
                               Factorization& f) {
  const double kappa = step.scale * step.beta_prime, damping = step.scale * step.gamma_prime;
  const BlockPattern& pattern = system_.pattern();
  for_each_pair(pattern, static_cast<int>(pattern.pairs.size()), [&](int p, auto R, auto C) {
    constexpr int left = kVelocitiesPerBody - N;
    const auto& [i, j, offset] = pattern.pairs[p];
    const int rows = pattern.unknowns[i].size, columns = pattern.unknowns[j].size;
    const bool inertia = p < pattern.inertia_pairs;
    const auto of_pair = [&, offset = offset](const VectorXd& values) {
      return ConstPairBlock<R, C>(values.data() + offset, rows, columns);
    };
    PairBlock<R, C> S(S_.data() + offset, rows, columns);
    RowMajorBlock<R, C> block(f.values.data() + pairs_[p], rows, columns);
    const auto K = of_pair(e.K);
    S = damping * of_pair(e.C);
    if (inertia) S += kappa * of_pair(e.M);
    if constexpr (C == kVelocitiesPerBody) {
      block.template leftCols<left>() = S.template leftCols<left>() + step.scale * K.template leftCols<left>();
      block.template rightCols<N>() =
          S.template rightCols<N>().lazyProduct(last<N>(tangents.U[j])) + step.scale * K.template rightCols<N>();
      if (!inertia) return;
      const auto M = of_pair(e.M).template leftCols<3>();
      if constexpr (N == 6) block += kappa * M.lazyProduct(tangents.E[j]);
      if (!stabilized()) return;
      if (!tangents.identity_P) {
        for (Eigen::Index r = 0; r < S.rows(); ++r) {
          S.row(r).template tail<N>() = (S.row(r).template tail<N>() * last<N>(tangents.P_inverse[j])).eval();
        }
      }
      if constexpr (N == 6) S += kappa * M.lazyProduct(tangents.F[j]);
    } else {
      block = S + step.scale * K;
    }
  });
}

// B^T and D P^-1 B_n^T in the columns, B and Z/gamma' + B (U - I) in the rows. The damping between two bodies is left
// out of the columns: mu is as small as the truncation error.
template <int N, int Size>
void NewtonMatrix::write_incidence(int k, const Evaluation& e, const Evaluation& start, const StepScales& step,
                                   const BodyTangents& tangents, Factorization& f) {
  const auto& [constraint, unknown, offset] = system_.pattern().incidences[k];
  const int m = system_.pattern().constraint_sizes[constraint];
  const int size = Size == Dynamic ? system_.pattern().unknowns[unknown].size : Size, values = m * size;
  const double *B = e.B.data() + offset, *Z = e.Z.data() + offset;
  const Incident& at = incidences_[k];
  double* column = f.values.data() + at.column;
  for (int r = 0; r < m; ++r) {
    for (int c = 0; c < size; ++c) column[c * m + r] = B[r * size + c];
  }
  if (formulation_ != Formulation::index2) std::copy_n(B, values, f.values.data() + at.row);
  if (formulation_ == Formulation::index3) return;

  const double inverse_gamma_prime = 1 / step.gamma_prime;
  double* row = f.values.data() + (stabilized() ? at.row_mu : at.row);
  for (int i = 0; i < values; ++i) row[i] = inverse_gamma_prime * Z[i];
  if constexpr (Size == Dynamic) {
    if (!stabilized()) {
      for (int i = 0; i < values; ++i) row[i] += B[i];
    }
  } else if (!stabilized()) {
    for (int r = 0; r < m; ++r) {
      for (int c = 0; c < kVelocitiesPerBody - N; ++c) row[r * kVelocitiesPerBody + c] += B[r * kVelocitiesPerBody + c];
    }
    add_product<N>(m, B, last<N>(tangents.U[unknown]), row);
  } else {
    add_product<N>(m, B, last<N>(tangents.U[unknown]) - Block<N>::Identity(), row);
  }
  if (!stabilized()) return;
  double* column_mu = f.values.data() + at.column_mu;
  std::fill_n(column_mu, values, 0.0);
  const ConstPairBlock<Size, Size> D(S_.data() + at.inertia, size, size);
  add_product_transposed(D, m, start.B.data() + offset, column_mu);
}

// B P^-1 B_n^T of two incidences with the same unknown; Size: velocities of the unknown, 0: any.
template <int N, int Size>
void NewtonMatrix::add_shared(int a, int b, const Evaluation& e, const Evaluation& start, const BodyTangents& tangents,
                              double* block) {
  const BlockPattern& pattern = system_.pattern();
  const int unknown = pattern.incidences[a].unknown;
  const int rows = pattern.constraint_sizes[pattern.incidences[a].constraint];
  const int columns = pattern.constraint_sizes[pattern.incidences[b].constraint];
  const int size = Size == 0 ? pattern.unknowns[unknown].size : Size;
  const double *B = e.B.data() + pattern.incidences[a].offset, *Bn = start.B.data() + pattern.incidences[b].offset;
  Eigen::Matrix<double, Dynamic, kVelocitiesPerBody, Eigen::RowMajor, 6, kVelocitiesPerBody> BP;
  if constexpr (Size == kVelocitiesPerBody) {
    if (!tangents.identity_P) {
      BP = ConstRows(B, rows, 6);
      BP.template rightCols<N>() = (BP.template rightCols<N>() * last<N>(tangents.P_inverse[unknown])).eval();
      B = BP.data();
    }
  }
  for (int r = 0; r < rows; ++r, B += size) {
    const double* x = Bn;
    for (int c = 0; c < columns; ++c, x += size) *block++ += kernels::dot<Size>(size, B, x);
  }
}

void NewtonMatrix::right_side(const Evaluation& e, const VectorXd& r, const StepScales& step, VectorXd& x) const {
  for (int i = 0; i < system_.velocity_size(); ++i) x[i] = -step.scale * r[i];
  const bool velocities = formulation_ == Formulation::index2, both = stabilized();
  double *lambda = x.data() + first_lambda(), *mu = x.data() + first_mu();
  for (int k = 0; k < system_.constraint_size(); ++k) {
    const double rate = e.phidot[k] / step.gamma_prime;
    lambda[k] = velocities ? -rate : -e.phi[k];
    if (both) mu[k] = e.phi[k] - rate;
  }
  for (int k : system_.velocity_equations()) {
    lambda[k] = -e.phidot[k] / step.gamma_prime;
    if (both) mu[k] = 0;
  }
}

void NewtonMatrix::add_compliance(const VectorXd& lambda, const VectorXd& mu, const StepScales& step,
                                  VectorXd& x) const {
  const double factor = softening(step);
  for (const SoftEquation& soft : soft_) {
    const double yielding = factor * soft.force * step.scale * lambda[soft.index];
    x[first_lambda() + soft.index] += yielding;
    if (stabilized() && !soft.of_velocities) x[first_mu() + soft.index] -= yielding + soft.motion * mu[soft.index];
  }
}

void NewtonMatrix::add_multipliers(const VectorXd& x, const StepScales& step, VectorXd& lambda, VectorXd& mu) const {
  const Eigen::Index count = system_.constraint_size();
  lambda += x.segment(first_lambda(), count) / step.scale;
  if (stabilized()) mu += x.segment(first_mu(), count);
}

}  // namespace sigmafmu
