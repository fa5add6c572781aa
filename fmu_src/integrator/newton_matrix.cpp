#include "integrator/newton_matrix.h"

#include <algorithm>

#include "integrator/kkt_layout.h"

namespace sigmafmu {
namespace {

// Row-major blocks: out (6 x columns, from column `at`) := A^T, for the m x 6 rows A of a joint.
void write_transposed(const JointRows& A, double* out, int columns, int at) {
  const int m = static_cast<int>(A.rows());
  for (int r = 0; r < m; ++r) {
    for (int c = 0; c < kVelocitiesPerBody; ++c) out[c * columns + at + r] = A(r, c);
  }
}

// row (m x 6) += A_N X in the last N columns, A_N those columns of A.
template <int N>
void add_product(const JointRows& A, const Eigen::Matrix<double, N, N>& X, double* row) {
  constexpr int first = kVelocitiesPerBody - N;
  for (int r = 0; r < A.rows(); ++r, row += kVelocitiesPerBody) {
    const double* a = A.data() + r * kVelocitiesPerBody + first;
    for (int c = 0; c < N; ++c) {
      double sum = a[0] * X(0, c);
      for (int k = 1; k < N; ++k) sum += a[k] * X(k, c);
      row[first + c] += sum;
    }
  }
}

}  // namespace

NewtonMatrix::NewtonMatrix(const System& system, Formulation formulation)
    : system_(system),
      D_(system.body_count(), Matrix6d::Zero()),
      formulation_(formulation),
      lu_(make_kkt_solver(system.pattern(), formulation == Formulation::stabilized_index2 ? 2 : 1)) {
  for (const auto& a : system.pattern().incidences) {
    for (const auto& b : system.pattern().incidences) {
      if (a.body == b.body) shared_.push_back({a.joint, a.side, b.joint, b.side, a.body});
    }
  }
}

template <int N>
bool NewtonMatrix::factorize(const Evaluation& e, const std::vector<JointEvaluation>& B_n, const StepScales& step,
                             const BodyTangents<N>& tangents, Factorization& f) {
  const bool stabilized = formulation_ == Formulation::stabilized_index2;
  const double kappa = step.scale * step.beta_prime;
  const double damping = step.scale * step.gamma_prime;
  const double inverse_gamma_prime = 1 / step.gamma_prime;
  const int bodies = system_.body_count();

  lu_.clear(f);
  const auto& pairs = system_.pattern().body_pairs;
  for (std::size_t p = 0; p < pairs.size(); ++p) {  // (kappa M + scale gamma' C) U + kappa M E + scale K
    const auto [i, j] = pairs[p];
    Matrix6d S = damping * e.C[p];
    if (i == j) {
      S.diagonal().head<3>().array() += kappa * system_.body(i).mass;
      S.bottomRightCorner<3, 3>() += kappa * system_.body(i).J;
    }
    if (stabilized && i == j) {  // D P^-1
      D_[i] = S;
      if (!tangents.identity_P) D_[i].template rightCols<N>() = S.template rightCols<N>() * tangents.P_inverse[i];
    }
    using RowMajor6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
    Eigen::Map<RowMajor6> block(lu_.block(f, i, j).data());
    constexpr int left = kVelocitiesPerBody - N;
    block.template leftCols<left>() = S.template leftCols<left>() + step.scale * e.K[p].template leftCols<left>();
    block.template rightCols<N>() =
        S.template rightCols<N>() * tangents.U[j] + step.scale * e.K[p].template rightCols<N>();
    if (N == 6 && i == j) block.template topRightCorner<3, N>() += kappa * system_.body(i).mass * tangents.E[i];
  }

  for (const auto& [joint, body, side] : system_.pattern().incidences) {
    const JointRows& B = e.joints[joint].B[side];
    const JointRows& Z = e.joints[joint].Z[side];
    const int m = static_cast<int>(B.rows()), values = m * kVelocitiesPerBody;
    const int columns = stabilized ? 2 * m : m;
    double* column = lu_.block(f, body, bodies + joint).data();
    double* row = lu_.block(f, bodies + joint, body).data();
    write_transposed(B, column, columns, 0);
    if (formulation_ != Formulation::index2) row = std::copy_n(B.data(), values, row);
    if (formulation_ == Formulation::index3) continue;

    for (int i = 0; i < values; ++i) row[i] = inverse_gamma_prime * Z.data()[i];
    if (!stabilized) {
      for (int r = 0; r < m; ++r) {
        for (int c = 0; c < kVelocitiesPerBody - N; ++c) row[r * kVelocitiesPerBody + c] += B(r, c);
      }
      add_product<N>(B, tangents.U[body], row);
      continue;
    }
    add_product<N>(B, tangents.U[body] - BodyTangents<N>::Block::Identity(), row);

    // D P^-1 B_n^T. The damping between two bodies is left out: mu is as small as the truncation error.
    const JointRows& Bn = B_n[joint].B[side];
    const Matrix6d& D = D_[body];
    for (int r = 0; r < m; ++r) {
      Vector6d product = D.col(0) * Bn(r, 0);
      for (int c = 1; c < kVelocitiesPerBody; ++c) product += D.col(c) * Bn(r, c);
      for (int c = 0; c < kVelocitiesPerBody; ++c) column[c * columns + m + r] = product[c];
    }
  }

  if (stabilized) {
    for (const auto& [joint1, side1, joint2, side2, body] : shared_) {  // += B P^-1 B_n^T, lower right corner
      JointRows BP = e.joints[joint1].B[side1];
      if (!tangents.identity_P) {
        BP.template rightCols<N>() = (BP.template rightCols<N>() * tangents.P_inverse[body]).eval();
      }
      const JointRows& Bn = B_n[joint2].B[side2];
      const int rows = static_cast<int>(BP.rows()), columns = static_cast<int>(Bn.rows());
      double* out = lu_.block(f, bodies + joint1, bodies + joint2).data() + rows * 2 * columns + columns;
      for (int r = 0; r < rows; ++r, out += 2 * columns) {
        const double* a = BP.data() + r * kVelocitiesPerBody;
        for (int c = 0; c < columns; ++c) {
          const double* b = Bn.data() + c * kVelocitiesPerBody;
          out[c] += a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5];
        }
      }
    }
  }
  return lu_.factorize(f);
}

template bool NewtonMatrix::factorize(const Evaluation&, const std::vector<JointEvaluation>&, const StepScales&,
                                      const BodyTangents<3>&, Factorization&);
template bool NewtonMatrix::factorize(const Evaluation&, const std::vector<JointEvaluation>&, const StepScales&,
                                      const BodyTangents<6>&, Factorization&);

}  // namespace sigmafmu
