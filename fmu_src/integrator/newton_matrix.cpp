#include "integrator/newton_matrix.h"

#include "integrator/kkt_layout.h"

namespace sigmafmu {
namespace {

// Columns 3..5 := columns 3..5 times U.
inline void scale_rotation(Matrix6d& m, const Matrix3d& U) {
  const Eigen::Matrix<double, 6, 3> columns = m.rightCols<3>();
  m.rightCols<3>().noalias() = columns * U;
}

}  // namespace

NewtonMatrix::NewtonMatrix(const System& system, Formulation formulation)
    : U_rot(system.body_count(), Matrix3d::Identity()),
      P_inverse(system.body_count(), Matrix3d::Identity()),
      system_(system),
      formulation_(formulation),
      lu_(make_kkt_solver(system.pattern(), formulation == Formulation::stabilized_index2 ? 2 : 1)) {
  for (const auto& a : system.pattern().incidences) {
    for (const auto& b : system.pattern().incidences) {
      if (a.body == b.body) shared_.push_back({a.joint, a.side, b.joint, b.side, a.body});
    }
  }
}

bool NewtonMatrix::factorize(const Evaluation& e, const std::vector<JointEvaluation>& B_n, double h,
                             const AlphaParameters& alpha, Factorization& f) const {
  const bool stabilized = formulation_ == Formulation::stabilized_index2;
  const double kappa = (1 - alpha.alpha_m) / (1 - alpha.alpha_f);
  const double gamma_h = alpha.gamma * h;
  const double beta_h2 = alpha.beta * h * h;
  const double inverse_gamma_prime = h * alpha.beta / alpha.gamma;
  const int bodies = system_.body_count();

  lu_.set_zero(f);
  const auto& pairs = system_.pattern().body_pairs;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const auto [i, j] = pairs[p];
    Matrix6d S = gamma_h * e.C[p];
    if (i == j) {
      S.diagonal().head<3>().array() += kappa * system_.body(i).mass;
      S.bottomRightCorner<3, 3>() += kappa * system_.body(i).J;
    }
    scale_rotation(S, U_rot[j]);
    lu_.block(f, i, j).topLeftCorner<6, 6>() = S + beta_h2 * e.K[p];
  }

  for (const auto& [joint, body, side] : system_.pattern().incidences) {
    const JointRows& B = e.joints[joint].B[side];
    const JointRows& Z = e.joints[joint].Z[side];
    const int m = static_cast<int>(B.rows());
    auto column = lu_.block(f, body, bodies + joint);
    auto row = lu_.block(f, bodies + joint, body);
    column.leftCols(m) = B.transpose();
    if (formulation_ != Formulation::index2) row.topRows(m) = B;
    if (formulation_ == Formulation::index3) continue;

    auto velocity_row = row.bottomRows(m);
    velocity_row = inverse_gamma_prime * Z;
    const Matrix3d U = stabilized ? Matrix3d(U_rot[body] - Matrix3d::Identity()) : U_rot[body];
    velocity_row.rightCols<3>() += B.rightCols<3>().lazyProduct(U);
    if (!stabilized) velocity_row.leftCols<3>() += B.leftCols<3>();
    if (!stabilized) continue;

    // D P^-1 B_n^T. The damping between two bodies is left out: mu is as small as the truncation error.
    Matrix6d D = gamma_h * e.C[body];
    D.diagonal().head<3>().array() += kappa * system_.body(body).mass;
    D.bottomRightCorner<3, 3>() += kappa * system_.body(body).J;
    if (!identity_P) scale_rotation(D, P_inverse[body]);
    column.rightCols(m) = D.lazyProduct(B_n[joint].B[side].transpose());
  }

  if (stabilized) {
    for (const auto& [joint1, side1, joint2, side2, body] : shared_) {
      JointRows BP = e.joints[joint1].B[side1];
      if (!identity_P) BP.rightCols<3>() = (BP.rightCols<3>() * P_inverse[body]).eval();
      const JointRows& Bn = B_n[joint2].B[side2];
      lu_.block(f, bodies + joint1, bodies + joint2).bottomRightCorner(BP.rows(), Bn.rows()) +=
          BP.lazyProduct(Bn.transpose());
    }
  }
  return lu_.factorize(f);
}

}  // namespace sigmafmu
