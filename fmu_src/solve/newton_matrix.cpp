#include "solve/newton_matrix.h"

#include <algorithm>
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

// out (Size x m, rows `columns` apart) (+)= D (Size x Columns) A^T, A m x Columns.
template <bool Add, typename Matrix>
void write_product(const Matrix& D, int m, const double* A, int columns, double* out) {
  const Eigen::Index size = D.rows(), inner = D.cols();
  for (int r = 0; r < m; ++r, A += inner) {
    for (Eigen::Index c = 0; c < size; ++c) {
      double sum = D(c, 0) * A[0];
      for (Eigen::Index k = 1; k < inner; ++k) sum += D(c, k) * A[k];
      double& x = out[c * columns + r];
      x = Add ? x + sum : sum;
    }
  }
}

}  // namespace

NewtonMatrix::NewtonMatrix(const System& system, Formulation formulation, KktPlans plans)
    : system_(system),
      formulation_(system.constraint_size() > 0 ? formulation : Formulation::index3),
      lu_(plans.get(system.pattern(), stabilized() ? Kkt::stabilized : Kkt::newton)) {
  const BlockPattern& pattern = system.pattern();
  for (int c = 0; c < pattern.constraint_count(); ++c) {
    equations_.push_back(
        {system.lambda_index(c), pattern.constraint_sizes[c], lu_->offset(pattern.constraint_node(c))});
  }
  for (const auto& [constraint, row, force, motion] : system.compliance().equations) {
    const auto& [first, count, unknown] = equations_[constraint];
    const int node = pattern.constraint_node(constraint), columns = stabilized() ? 2 * count : count;
    const int block = lu_->handle(node, node), below = block + (stabilized() ? count * columns : 0);
    const int diagonal = row * columns + row;
    soft_.push_back({first + row, force, motion, unknown + row, unknown + row + (stabilized() ? count : 0),
                     block + diagonal, below + diagonal + (stabilized() ? count : 0), below + diagonal});
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
    const int node = pattern.constraint_node(constraint);
    incidences_.push_back({lu_->handle(unknown, node), lu_->handle(node, unknown), own[unknown]});
    met[unknown].push_back(static_cast<int>(k));
  }
  if (stabilized()) {
    for (const std::vector<int>& incidences : met) {
      for (int a : incidences) {
        for (int b : incidences) {
          const int row = pattern.incidences[a].constraint, column = pattern.incidences[b].constraint;
          shared_.push_back({a, b, lu_->handle(pattern.constraint_node(row), pattern.constraint_node(column))});
        }
        const auto& [constraint, unknown, offset] = pattern.incidences[a];
        for (int p : mixed[unknown]) {
          mixed_.push_back({a, p, lu_->handle(pattern.pairs[p].row, pattern.constraint_node(constraint))});
        }
      }
    }
  }
  S_ = system.make_evaluation().C;
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
    const int m = pattern.constraint_sizes[constraint];
    write_product<true>(pair_block(pattern, pattern.pairs[p], std::as_const(S_)), m, start.B.data() + offset, 2 * m,
                        f.values.data() + column + m);
  }
  for (const auto& [a, b, block] : shared_) {
    if (pose(pattern.incidences[a])) {
      add_shared<N, kVelocitiesPerBody>(a, b, e, start, tangents, f.values.data() + block);
    } else {
      add_shared<N, Dynamic>(a, b, e, start, tangents, f.values.data() + block);
    }
  }
  if (soft()) add_compliance(f);
  return lu_->factorize(f);
}

void NewtonMatrix::add_compliance(Factorization& f) const {
  for (const SoftEquation& soft : soft_) {
    f.values[soft.diagonal] -= soft.force;
    if (!stabilized()) continue;
    f.values[soft.below] += soft.force;
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
  const int m = system_.pattern().constraint_sizes[constraint], columns = stabilized() ? 2 * m : m;
  const int size = Size == Dynamic ? system_.pattern().unknowns[unknown].size : Size, values = m * size;
  const double *B = e.B.data() + offset, *Z = e.Z.data() + offset;
  double* column = f.values.data() + incidences_[k].column;
  double* row = f.values.data() + incidences_[k].row;
  for (int r = 0; r < m; ++r) {
    for (int c = 0; c < size; ++c) column[c * columns + r] = B[r * size + c];
  }
  if (formulation_ != Formulation::index2) row = std::copy_n(B, values, row);
  if (formulation_ == Formulation::index3) return;

  const double inverse_gamma_prime = 1 / step.gamma_prime;
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
  const ConstPairBlock<Size, Size> D(S_.data() + incidences_[k].inertia, size, size);
  write_product<false>(D, m, start.B.data() + offset, columns, column + m);
}

// B P^-1 B_n^T of two incidences with the same unknown, lower right corner.
template <int N, int Size>
void NewtonMatrix::add_shared(int a, int b, const Evaluation& e, const Evaluation& start, const BodyTangents& tangents,
                              double* block) {
  const BlockPattern& pattern = system_.pattern();
  const int unknown = pattern.incidences[a].unknown;
  const int rows = pattern.constraint_sizes[pattern.incidences[a].constraint];
  const int columns = pattern.constraint_sizes[pattern.incidences[b].constraint];
  const int size = Size == Dynamic ? pattern.unknowns[unknown].size : Size;
  const double *B = e.B.data() + pattern.incidences[a].offset, *Bn = start.B.data() + pattern.incidences[b].offset;
  Eigen::Matrix<double, Dynamic, kVelocitiesPerBody, Eigen::RowMajor, 6, kVelocitiesPerBody> BP;
  if constexpr (Size == kVelocitiesPerBody) {
    if (!tangents.identity_P) {
      BP = ConstRows(B, rows, 6);
      BP.template rightCols<N>() = (BP.template rightCols<N>() * last<N>(tangents.P_inverse[unknown])).eval();
      B = BP.data();
    }
  }
  double* out = block + rows * 2 * columns + columns;
  for (int r = 0; r < rows; ++r, out += 2 * columns, B += size) {
    const double* x = Bn;
    for (int c = 0; c < columns; ++c, x += size) {
      double sum = B[0] * x[0];
      for (int i = 1; i < size; ++i) sum += B[i] * x[i];
      out[c] += sum;
    }
  }
}

void NewtonMatrix::right_side(const Evaluation& e, const VectorXd& r, const StepScales& step, VectorXd& x) const {
  for (int i = 0; i < system_.velocity_size(); ++i) x[i] = -step.scale * r[i];
  const bool velocities = formulation_ == Formulation::index2, both = stabilized();
  for (const auto& [first, count, unknown] : equations_) {
    const double *phi = e.phi.data() + first, *phidot = e.phidot.data() + first;
    double *upper = x.data() + unknown, *lower = upper + count;
    for (int k = 0; k < count; ++k) {
      const double rate = phidot[k] / step.gamma_prime;
      upper[k] = velocities ? -rate : -phi[k];
      if (both) lower[k] = phi[k] - rate;
    }
  }
}

void NewtonMatrix::add_compliance(const VectorXd& lambda, const VectorXd& mu, const StepScales& step,
                                  VectorXd& x) const {
  for (const SoftEquation& soft : soft_) {
    const double yielding = soft.force * step.scale * lambda[soft.index];
    x[soft.unknown] += yielding;
    if (stabilized()) x[soft.unknown_mu] -= yielding + soft.motion * mu[soft.index];
  }
}

void NewtonMatrix::add_multipliers(const VectorXd& x, const StepScales& step, VectorXd& lambda, VectorXd& mu) const {
  for (const auto& [first, count, unknown] : equations_) {
    for (int k = 0; k < count; ++k) {
      lambda[first + k] += x[unknown + k] / step.scale;
      if (stabilized()) mu[first + k] += x[unknown + count + k];
    }
  }
}

}  // namespace sigmafmu
