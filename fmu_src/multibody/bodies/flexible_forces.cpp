#include "multibody/bodies/flexible_inline.h"

namespace sigmafmu {

using Eigen::Map;
using lie::hat;

void FlexibleBody::add_residual(const FrameKinematics& k, const FlexibleEvaluation& e, const double* vdot,
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
void FlexibleBody::linearize(const FrameKinematics& k, FlexibleEvaluation& e, const double* vdot,
                             const double* zetaddot, const Vector3d& g, Blocks C, Blocks K) const {
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
double FlexibleBody::kinetic_energy(const FrameKinematics& k, const FlexibleEvaluation& e) const {
  const Vector3d momentum = k.R_WB * (k.w_WB_B.cross(e.S_z) + e.S_y);
  return 0.5 * (mass_ * k.v_WB.squaredNorm() + k.w_WB_B.dot(e.M.bottomRightCorner<3, 3>() * k.w_WB_B) +
                e.zetadot.dot(modal_mass_.lazyProduct(e.zetadot))) +
         k.v_WB.dot(momentum) + k.w_WB_B.dot(ax(e.G_zy));
}

double FlexibleBody::potential_energy(const FrameKinematics& k, const FlexibleEvaluation& e, const Vector3d& g) const {
  return 0.5 * e.zeta.dot(stiffness_.lazyProduct(e.zeta)) - g.dot(mass_ * k.p_WB + k.R_WB * e.S_z);
}

}  // namespace sigmafmu
