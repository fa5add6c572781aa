#include "multibody/bodies/flexible_body.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "lie/isotropic_operator.h"

namespace sigmafmu {
namespace {

using Eigen::Map;
using lie::hat;

// ax(s t^T) = s x t.
Vector3d ax(const Matrix3d& A) { return {A(1, 2) - A(2, 1), A(2, 0) - A(0, 2), A(0, 1) - A(1, 0)}; }

auto block(const Matrix3Xd& G, int a) { return G.middleCols<3>(3 * a); }
Map<VectorXd> flat(Matrix3Xd& G) { return {G.data(), G.size()}; }

}  // namespace

FlexibleBody::FlexibleBody(const ModalDef& d)
    : nodes_(d.nodes.transpose()), shapes_(d.shapes), rotations_(d.rotations) {
  const int n = d.node_count(), f = d.mode_count();
  if (rotations_.size() == 0) rotations_.setZero(3 * n, f);
  MatrixXd U(n, 3 * (f + 1));  // U_0, U_1, ... side by side
  U.leftCols<3>() = d.nodes;
  for (int a = 0; a < f; ++a) {
    for (int i = 0; i < n; ++i) U.block<1, 3>(i, 3 * a + 3) = shapes_.block<3, 1>(3 * i, a).transpose();
  }
  const bool lumped = d.mass_matrix.size() == 0;
  const MatrixXd MU = lumped ? MatrixXd(d.masses.asDiagonal() * U) : MatrixXd(d.mass_matrix * U);
  mass_ = lumped ? d.masses.sum() : d.mass_matrix.sum();
  S_ = Map<const Matrix3Xd>(VectorXd(MU.colwise().sum()).data(), 3, f + 1);
  G_.resize(9 * (f + 1), f + 1);
  for (int b = 0; b <= f; ++b) {
    Map<Matrix3Xd>(G_.col(b).data(), 3, 3 * (f + 1)) = U.middleCols<3>(3 * b).transpose() * MU;
  }
  modal_mass_.resize(f, f);
  for (int a = 0; a < f; ++a) {
    for (int b = 0; b < f; ++b) modal_mass_(a, b) = 0.5 * (G(a + 1, b + 1).trace() + G(b + 1, a + 1).trace());
  }
}

void FlexibleBody::set_values(const ModalDef& d) {
  stiffness_ = d.stiffness;
  damping_ = d.mass_damping * modal_mass_ + d.stiffness_damping * stiffness_;
  if (d.damping.size() > 0) damping_ += d.damping;
  if (modes() == 0) return;
  const MatrixXd M = undeformed_mass_matrix();  // what is left of M_ff when the frame moves freely
  const MatrixXd M_fr = M.bottomLeftCorner(modes(), 6);
  const MatrixXd free = modal_mass_ - M_fr * M.topLeftCorner<6, 6>().llt().solve(M_fr.transpose());
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> solver(stiffness_, free, Eigen::EigenvaluesOnly);
  highest_frequency_ = std::sqrt(std::max(0.0, solver.eigenvalues().maxCoeff()));
}

FlexibleEvaluation FlexibleBody::make_evaluation() const {
  const int f = modes();
  FlexibleEvaluation e;
  for (VectorXd* x : {&e.zeta, &e.zetadot}) x->setZero(f);
  for (Matrix3Xd* x : {&e.G_z, &e.G_y, &e.G_x}) x->setZero(3, 3 * (f + 1));
  e.M_modal.setZero(6, f);
  return e;
}

MatrixXd FlexibleBody::undeformed_mass_matrix() const {
  FlexibleEvaluation e = make_evaluation();
  const VectorXd zero = VectorXd::Zero(modes());
  evaluate(BodyKinematics{}, zero.data(), zero.data(), e);
  MatrixXd M(6 + modes(), 6 + modes());
  M << e.M, e.M_modal, e.M_modal.transpose(), modal_mass_;
  return M;
}

void FlexibleBody::evaluate(const BodyKinematics& k, const double* zeta, const double* zetadot,
                            FlexibleEvaluation& e) const {
  const int f = modes();
  e.zeta = Map<const VectorXd>(zeta, f);
  e.zetadot = Map<const VectorXd>(zetadot, f);
  const auto S_f = S_.rightCols(f);
  const auto G_f = G_.rightCols(f);
  e.S_z = S_.col(0) + S_f.lazyProduct(e.zeta);
  e.S_y = S_f.lazyProduct(e.zetadot);
  flat(e.G_z) = G_.col(0);
  flat(e.G_z).noalias() += G_f.lazyProduct(e.zeta);
  flat(e.G_y).noalias() = G_f.lazyProduct(e.zetadot);
  e.G_zz = block(e.G_z, 0);
  e.G_zy.setZero();
  for (int a = 1; a <= f; ++a) {
    e.G_zz += zeta[a - 1] * block(e.G_z, a);
    e.G_zy += zetadot[a - 1] * block(e.G_z, a);
  }

  const Matrix3d RS = k.R_WB * hat(e.S_z);
  e.M.topLeftCorner<3, 3>() = mass_ * Matrix3d::Identity();
  e.M.topRightCorner<3, 3>() = -RS;
  e.M.bottomLeftCorner<3, 3>() = -RS.transpose();
  e.M.bottomRightCorner<3, 3>() = e.G_zz.trace() * Matrix3d::Identity() - e.G_zz;
  for (int a = 0; a < f; ++a) {
    e.M_modal.block<3, 1>(0, a) = k.R_WB * S_f.col(a);
    e.M_modal.block<3, 1>(3, a) = ax(block(e.G_z, a + 1));
  }
}

void FlexibleBody::add_residual(const BodyKinematics& k, const FlexibleEvaluation& e, const double* vdot,
                                const double* zetaddot, const Vector3d& g, double* r_frame, double* r_modal) const {
  const int f = modes();
  const Map<const Vector3d> xddot(vdot), wdot(vdot + 3);
  const Matrix3d w = hat(k.w_WB_B);
  const Matrix3d P = hat(wdot) + w * w;
  const Vector3d b = k.R_WB.transpose() * (xddot - g);
  Vector3d S_x = Vector3d::Zero();
  Matrix3d G_zx = Matrix3d::Zero();
  for (int a = 1; a <= f; ++a) {
    S_x += zetaddot[a - 1] * S_.col(a);
    G_zx += zetaddot[a - 1] * block(e.G_z, a);
  }
  Map<Vector3d>(r_frame) += mass_ * (xddot - g) + k.R_WB * (P * e.S_z + 2 * (w * e.S_y) + S_x);
  Map<Vector3d>(r_frame + 3) += e.S_z.cross(b) + ax(e.G_zz * P.transpose() + 2 * e.G_zy * w.transpose() + G_zx);
  Map<VectorXd> r(r_modal, f);
  for (int a = 1; a <= f; ++a) {  // tr(A B) = sum of A^T * B, entry by entry
    r[a - 1] += S_.col(a).dot(b) + P.transpose().cwiseProduct(block(e.G_z, a)).sum() -
                2 * w.cwiseProduct(block(e.G_y, a)).sum();
  }
  r.noalias() += modal_mass_.lazyProduct(Map<const VectorXd>(zetaddot, f));
  r.noalias() += stiffness_.lazyProduct(e.zeta);
  r.noalias() += damping_.lazyProduct(e.zetadot);
}

// Motions: delta x in W, delta R = R hat(phi), delta zeta; delta b = hat(b) phi and with t the bracket of the first
// row, delta(R t) = -R hat(t) phi. delta P = hat(delta w) hat(w) + hat(w) hat(delta w).
void FlexibleBody::linearize(const BodyKinematics& k, FlexibleEvaluation& e, const double* vdot, const double* zetaddot,
                             const Vector3d& g, const Blocks& C, const Blocks& K) const {
  const int f = modes();
  const Matrix3d& R = k.R_WB;
  const Map<const Vector3d> xddot(vdot), wdot(vdot + 3);
  const Vector3d& w_B = k.w_WB_B;
  const Matrix3d w = hat(w_B);
  const Matrix3d P = hat(wdot) + w * w;
  const Vector3d b = R.transpose() * (xddot - g);
  flat(e.G_x).noalias() = G_.rightCols(f).lazyProduct(Map<const VectorXd>(zetaddot, f));
  Vector3d S_x = Vector3d::Zero();
  for (int a = 1; a <= f; ++a) S_x += zetaddot[a - 1] * S_.col(a);
  const Vector3d t = P * e.S_z + 2 * (w * e.S_y) + S_x;
  const auto J = e.M.bottomRightCorner<3, 3>();

  C.frame.topRightCorner<3, 3>() -= R * (hat(w * e.S_z) + w * hat(e.S_z) + 2 * hat(e.S_y));
  C.frame.bottomRightCorner<3, 3>() +=
      w * J - hat(J * w_B) + 2 * (e.G_zy.trace() * Matrix3d::Identity() - e.G_zy.transpose());
  K.frame.topRightCorner<3, 3>() -= R * hat(t);
  K.frame.bottomRightCorner<3, 3>() += hat(e.S_z) * hat(b);
  for (int a = 1; a <= f; ++a) {
    const Vector3d S_a = S_.col(a);
    const Matrix3d G_za = block(e.G_z, a), G_ya = block(e.G_y, a), G_xa = block(e.G_x, a);
    const Matrix3d symmetric = G_za + G_za.transpose();
    C.frame_modal.block<3, 1>(0, a - 1) += 2 * (R * (w * S_a));
    C.frame_modal.block<3, 1>(3, a - 1) += 2 * ax(G_za * w.transpose());
    K.frame_modal.block<3, 1>(0, a - 1) += R * (P * S_a);
    K.frame_modal.block<3, 1>(3, a - 1) +=
        S_a.cross(b) + ax(symmetric * P.transpose() + 2 * G_ya.transpose() * w.transpose() + G_xa.transpose());
    C.modal_frame.block<1, 3>(a - 1, 3) += (symmetric * w_B - symmetric.trace() * w_B + 2 * ax(G_ya)).transpose();
    K.modal_frame.block<1, 3>(a - 1, 3) += (S_a.cross(b)).transpose();
    for (int c = 1; c <= f; ++c) {
      const Map<const Matrix3d> G_ca(G_.col(c).data() + 9 * a);
      C.modal(a - 1, c - 1) -= 2 * w.cwiseProduct(G_ca).sum();
      K.modal(a - 1, c - 1) += P.transpose().cwiseProduct(G_ca).sum();
    }
  }
  C.modal += damping_;
  K.modal += stiffness_;
}

// 1/2 sum_ij M_ij r_i'^T r_j'.
double FlexibleBody::kinetic_energy(const BodyKinematics& k, const FlexibleEvaluation& e) const {
  const Vector3d momentum = k.R_WB * (k.w_WB_B.cross(e.S_z) + e.S_y);
  return 0.5 * (mass_ * k.v_WB.squaredNorm() + k.w_WB_B.dot(e.M.bottomRightCorner<3, 3>() * k.w_WB_B) +
                e.zetadot.dot(modal_mass_.lazyProduct(e.zetadot))) +
         k.v_WB.dot(momentum) + k.w_WB_B.dot(ax(e.G_zy));
}

double FlexibleBody::potential_energy(const BodyKinematics& k, const FlexibleEvaluation& e, const Vector3d& g) const {
  return 0.5 * e.zeta.dot(stiffness_.lazyProduct(e.zeta)) - g.dot(mass_ * k.p_WB + k.R_WB * e.S_z);
}

}  // namespace sigmafmu
