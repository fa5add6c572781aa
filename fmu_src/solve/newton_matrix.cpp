#include "solve/newton_matrix.h"

#include <algorithm>

namespace sigmafmu {
namespace {

template <int N>
using Block = Eigen::Matrix<double, N, N>;

// The lower right N x N.
template <int N>
decltype(auto) last(const Matrix6d& X) {
  if constexpr (N == 6) {
    return (X);
  } else {
    return Block<N>(X.bottomRightCorner<N, N>());
  }
}

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

NewtonMatrix::NewtonMatrix(const System& system, Formulation formulation, KktPlans plans)
    : system_(system),
      D_(system.body_count(), Matrix6d::Zero()),
      formulation_(formulation),
      lu_(plans.get(system.pattern(), formulation == Formulation::stabilized_index2 ? Kkt::stabilized : Kkt::newton)) {
  for (const auto& a : system.pattern().incidences) {
    for (const auto& b : system.pattern().incidences) {
      if (a.body == b.body) shared_.push_back({a.joint, a.side, b.joint, b.side, a.body});
    }
  }
  const auto& modal = system.pattern().modal_incidences;
  for (const auto& [joint, body, side] : system.pattern().incidences) {
    const int flexible = system.flexible_index(body);
    if (flexible < 0) continue;
    int incidence = -1;
    for (std::size_t k = 0; k < modal.size(); ++k) {
      if (modal[k].joint == joint && modal[k].side == side) incidence = static_cast<int>(k);
    }
    flexible_joints_.push_back({joint, side, flexible, incidence});
  }
  S_ = system.make_evaluation().modal_C;
}

// A += kappa M (X, 0)^T, M that of the frame of body i and X its translational rows.
template <typename Rows, typename Matrix>
void NewtonMatrix::add_inertia(const Evaluation& e, int i, double kappa, const Rows& X, Matrix& A) const {
  A.template topRows<3>() += kappa * system_.body(i).mass * X;
  const int flexible = system_.flexible_index(i);
  if (flexible >= 0) A += kappa * e.flexible[flexible].M.template leftCols<3>() * X;
}

bool NewtonMatrix::factorize(const Evaluation& e, const Evaluation& start, const StepScales& step,
                             const BodyTangents& tangents, Factorization& f) {
  return tangents.rotations_only ? factorize_of<3>(e, start, step, tangents, f)
                                 : factorize_of<6>(e, start, step, tangents, f);
}

template <int N>
bool NewtonMatrix::factorize_of(const Evaluation& e, const Evaluation& start, const StepScales& step,
                                const BodyTangents& tangents, Factorization& f) {
  const bool stabilized = formulation_ == Formulation::stabilized_index2;
  const double kappa = step.scale * step.beta_prime;
  const double damping = step.scale * step.gamma_prime;
  const double inverse_gamma_prime = 1 / step.gamma_prime;
  const BlockPattern& pattern = system_.pattern();

  lu_->clear(f);
  const auto& pairs = pattern.body_pairs;
  for (std::size_t p = 0; p < pairs.size(); ++p) {  // (kappa M + scale gamma' C) U + kappa M E + scale K
    const auto [i, j] = pairs[p];
    Matrix6d S = damping * e.C[p];
    if (i == j) {
      S.diagonal().head<3>().array() += kappa * system_.body(i).mass;
      S.bottomRightCorner<3, 3>() += kappa * system_.body(i).J;
      if (system_.flexible_index(i) >= 0) S += kappa * e.flexible[system_.flexible_index(i)].M;
    }
    if (stabilized && i == j) {  // D P^-1
      D_[i] = S;
      if (!tangents.identity_P)
        D_[i].template rightCols<N>() = S.template rightCols<N>() * last<N>(tangents.P_inverse[i]);
      if constexpr (N == 6) add_inertia(e, i, kappa, tangents.F[i], D_[i]);
    }
    using RowMajor6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
    Eigen::Map<RowMajor6> block(lu_->block(f, i, j).data());
    constexpr int left = kVelocitiesPerBody - N;
    block.template leftCols<left>() = S.template leftCols<left>() + step.scale * e.K[p].template leftCols<left>();
    block.template rightCols<N>() =
        S.template rightCols<N>() * last<N>(tangents.U[j]) + step.scale * e.K[p].template rightCols<N>();
    if constexpr (N == 6) {
      if (i == j) add_inertia(e, i, kappa, tangents.E[i], block);
    }
  }

  for (const auto& [joint, body, side] : system_.pattern().incidences) {
    const JointRows& B = e.joints[joint].B[side];
    const JointRows& Z = e.joints[joint].Z[side];
    const int m = static_cast<int>(B.rows()), values = m * kVelocitiesPerBody;
    const int columns = stabilized ? 2 * m : m;
    double* column = lu_->block(f, body, pattern.joint_node(joint)).data();
    double* row = lu_->block(f, pattern.joint_node(joint), body).data();
    write_transposed(B, column, columns, 0);
    if (formulation_ != Formulation::index2) row = std::copy_n(B.data(), values, row);
    if (formulation_ == Formulation::index3) continue;

    for (int i = 0; i < values; ++i) row[i] = inverse_gamma_prime * Z.data()[i];
    if (!stabilized) {
      for (int r = 0; r < m; ++r) {
        for (int c = 0; c < kVelocitiesPerBody - N; ++c) row[r * kVelocitiesPerBody + c] += B(r, c);
      }
      add_product<N>(B, last<N>(tangents.U[body]), row);
      continue;
    }
    add_product<N>(B, last<N>(tangents.U[body]) - Block<N>::Identity(), row);

    // D P^-1 B_n^T. The damping between two bodies is left out: mu is as small as the truncation error.
    const JointRows& Bn = start.joints[joint].B[side];
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
        BP.template rightCols<N>() = (BP.template rightCols<N>() * last<N>(tangents.P_inverse[body])).eval();
      }
      const JointRows& Bn = start.joints[joint2].B[side2];
      const int rows = static_cast<int>(BP.rows()), columns = static_cast<int>(Bn.rows());
      double* out =
          lu_->block(f, pattern.joint_node(joint1), pattern.joint_node(joint2)).data() + rows * 2 * columns + columns;
      for (int r = 0; r < rows; ++r, out += 2 * columns) {
        const double* a = BP.data() + r * kVelocitiesPerBody;
        for (int c = 0; c < columns; ++c) {
          const double* b = Bn.data() + c * kVelocitiesPerBody;
          out[c] += a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5];
        }
      }
    }
  }
  if (system_.flexible_count() > 0) write_modes<N>(e, start, step, tangents, f);
  return lu_->factorize(f);
}

// All blocks with modes, and what modes add to those of frames and joints.
template <int N>
void NewtonMatrix::write_modes(const Evaluation& e, const Evaluation& start, const StepScales& step,
                               const BodyTangents& tangents, Factorization& f) {
  const bool stabilized = formulation_ == Formulation::stabilized_index2;
  const double kappa = step.scale * step.beta_prime;
  const BlockPattern& pattern = system_.pattern();
  const int bodies = system_.body_count();
  for (std::size_t p = 0; p < pattern.modal_pairs.size(); ++p) {
    const auto [i, j] = pattern.modal_pairs[p];
    MatrixXd& S = S_[p];
    S = step.scale * step.gamma_prime * e.modal_C[p];
    const bool inertia = p < e.modal_M.size();
    if (inertia) S += kappa * e.modal_M[p];
    auto block = lu_->block(f, i, j);
    block = S + step.scale * e.modal_K[p];
    if (j >= bodies) continue;
    block.template rightCols<N>() +=
        S.template rightCols<N>().lazyProduct(last<N>(tangents.U[j]) - Block<N>::Identity());
    if constexpr (N == 6) {
      if (inertia)
        block.template rightCols<N>() += kappa * e.modal_M[p].template leftCols<3>().lazyProduct(tangents.E[j]);
    }
  }
  for (const auto& [joint, side, flexible, incidence] : flexible_joints_) {
    if (incidence < 0 && !stabilized) continue;
    const int node = pattern.modal_node(flexible), m = system_.joint(joint).equations();
    auto column = lu_->block(f, node, pattern.joint_node(joint));
    auto row = lu_->block(f, pattern.joint_node(joint), node);
    column.setZero();
    row.setZero();
    if (incidence >= 0) {
      const ModalRows& rows = e.modal_joints[incidence];
      column.leftCols(m) = rows.B.transpose();
      if (formulation_ == Formulation::index2) {
        row = rows.B + rows.Z / step.gamma_prime;
      } else {
        row.topRows(m) = rows.B;
      }
      if (stabilized) row.bottomRows(m) = rows.Z / step.gamma_prime;
    }
    if (!stabilized) continue;
    // D P^-1 B_n^T: S_ holds (frame, modes), (modes, frame) and (modes, modes) of each flexible body, in this order.
    const int body = system_.flexible_body(flexible);
    const MatrixXd *from_modes = &S_[3 * flexible], *to_modes = from_modes + 1, *among_modes = from_modes + 2;
    const JointRows& Bn = start.joints[joint].B[side];
    for (int r = 0; r < m; ++r) {
      Vector6d PB = Bn.row(r).transpose();
      if constexpr (N == 6) {
        const Vector3d FB = tangents.F[body] * PB;
        column.col(m + r) += kappa * e.modal_M[3 * flexible + 1].template leftCols<3>().lazyProduct(FB);
      }
      if (!tangents.identity_P)
        PB.template tail<N>() = (last<N>(tangents.P_inverse[body]) * PB.template tail<N>()).eval();
      column.col(m + r) += to_modes->lazyProduct(PB);
    }
    if (incidence < 0) continue;
    const MatrixXd& Bn_modal = start.modal_joints[incidence].B;
    column.rightCols(m) += among_modes->lazyProduct(Bn_modal.transpose());
    lu_->block(f, body, pattern.joint_node(joint)).rightCols(m) += from_modes->lazyProduct(Bn_modal.transpose());
  }
  if (!stabilized) return;
  const auto& incidences = pattern.modal_incidences;
  for (std::size_t k = 0; k < incidences.size(); ++k) {  // += B B_n^T
    for (std::size_t l = 0; l < incidences.size(); ++l) {
      if (incidences[k].body != incidences[l].body) continue;
      auto block = lu_->block(f, pattern.joint_node(incidences[k].joint), pattern.joint_node(incidences[l].joint));
      const MatrixXd &B = e.modal_joints[k].B, &Bn = start.modal_joints[l].B;
      block.bottomRightCorner(B.rows(), Bn.rows()) += B.lazyProduct(Bn.transpose());
    }
  }
}

void NewtonMatrix::right_side(const Evaluation& e, const VectorXd& r, const StepScales& step, VectorXd& x) const {
  const bool stabilized = formulation_ == Formulation::stabilized_index2;
  const double scale = -step.scale;
  const int n = system_.velocity_size();
  for (int i = 0; i < n; ++i) x[i] = scale * r[i];
  for (int j = 0; j < system_.joint_count(); ++j) {  // plain loops: joints have few equations
    const JointEvaluation& joint = e.joints[j];
    double* first = x.data() + lambda_offset(j);
    double* second = stabilized ? x.data() + mu_offset(j) : nullptr;
    for (int k = 0; k < joint.phi.size(); ++k) {
      const double rate = joint.phidot[k] / step.gamma_prime;
      first[k] = formulation_ == Formulation::index2 ? -rate : -joint.phi[k];
      if (second) second[k] = joint.phi[k] - rate;
    }
  }
}

void NewtonMatrix::add_multipliers(const VectorXd& x, const StepScales& step, VectorXd& lambda, VectorXd& mu) const {
  const bool stabilized = formulation_ == Formulation::stabilized_index2;
  for (int j = 0; j < system_.joint_count(); ++j) {
    const int first = system_.lambda_index(j);
    for (int k = 0; k < system_.joint(j).equations(); ++k) {
      lambda[first + k] += x[lambda_offset(j) + k] / step.scale;
      if (stabilized) mu[first + k] += x[mu_offset(j) + k];
    }
  }
}

}  // namespace sigmafmu
