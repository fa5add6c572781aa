#include "model/modal_constants.h"

#include "lie/isotropic_operator.h"
#include "model/dense.h"

namespace sigmafmu {

using Eigen::Map;

ModalConstants modal_constants(const ModalDef& d) {
  const int n = d.node_count(), f = d.mode_count();
  MatrixXd U(n, 3 * (f + 1));  // U_0, U_1, ... side by side
  U.leftCols<3>() = d.nodes;
  for (int a = 0; a < f; ++a) {
    for (int i = 0; i < n; ++i) U.block<1, 3>(i, 3 * a + 3) = d.shapes.block<3, 1>(3 * i, a).transpose();
  }
  const bool lumped = d.mass_matrix.size() == 0;
  const MatrixXd MU = lumped ? MatrixXd(d.masses.asDiagonal() * U) : product(d.mass_matrix, U);

  ModalConstants c;
  c.mass = lumped ? d.masses.sum() : d.mass_matrix.sum();
  c.S = Map<const Matrix3Xd>(VectorXd(MU.colwise().sum()).data(), 3, f + 1);
  c.G.resize(9 * (f + 1), f + 1);
  for (int b = 0; b <= f; ++b) {
    Map<Matrix3Xd>(c.G.col(b).data(), 3, 3 * (f + 1)) = transposed_product(U.middleCols<3>(3 * b), MU);
  }
  c.modal_mass.resize(f, f);
  for (int a = 0; a < f; ++a) {
    for (int b = 0; b < f; ++b) {
      c.modal_mass(a, b) = 0.5 * (c.G_ba(a + 1, b + 1).trace() + c.G_ba(b + 1, a + 1).trace());
    }
  }
  return c;
}

// That of flexible_body.h at zeta = 0: S_z = S_0, G_za = G_0a.
MatrixXd undeformed_mass_matrix(const ModalConstants& c) {
  const int f = static_cast<int>(c.modal_mass.rows());
  const Matrix3d S = lie::hat(c.S.col(0)), G = c.G_ba(0, 0);
  MatrixXd M = MatrixXd::Zero(6 + f, 6 + f);
  M.topLeftCorner<3, 3>() = c.mass * Matrix3d::Identity();
  M.block<3, 3>(0, 3) = -S;
  M.block<3, 3>(3, 0) = -S.transpose();
  M.block<3, 3>(3, 3) = G.trace() * Matrix3d::Identity() - G;
  for (int a = 0; a < f; ++a) {
    M.block<3, 1>(0, 6 + a) = c.S.col(a + 1);
    M.block<3, 1>(3, 6 + a) = ax(c.G_ba(0, a + 1));
  }
  M.bottomLeftCorner(f, 6) = M.topRightCorner(6, f).transpose();
  M.bottomRightCorner(f, f) = c.modal_mass;
  return M;
}

}  // namespace sigmafmu
