// The few constants of the nodes that all inertia of a flexible body is made of (multibody/bodies/flexible_body.h):
//
//   m = sum_ij M_ij,   S_a = sum_ij M_ij U_a,j  (3),   G_ab = sum_ij M_ij U_a,i U_b,j^T  (3x3),   a, b = 0..f
//
// with U_0 = X and U_a = Phi_a.
#pragma once

#include "model/definition.h"

namespace sigmafmu {

using Eigen::Matrix3Xd;

struct ModalConstants {
  double mass = 0;
  Matrix3Xd S;          // S_0, S_1, ... S_f
  MatrixXd G;           // column b: G_b0, G_b1, ... G_bf, each by columns
  MatrixXd modal_mass;  // M_ff = tr(G_ab), f x f

  Matrix3d G_ba(int b, int a) const { return Eigen::Map<const Matrix3d>(G.col(b).data() + 9 * a); }
};

// Of nodes, mass and shapes whose sizes fit.
ModalConstants modal_constants(const ModalDef& definition);

// The mass matrix of the undeformed body with R = I, (6 + f) x (6 + f).
MatrixXd undeformed_mass_matrix(const ModalConstants& constants);

// ax(s t^T) = s x t.
inline Vector3d ax(const Matrix3d& A) { return {A(1, 2) - A(2, 1), A(2, 0) - A(0, 2), A(0, 1) - A(1, 0)}; }

}  // namespace sigmafmu
