#include "multibody/frame.h"

#include "lie/so3.h"

namespace sigmafmu {

NodeFrameEvaluation make_node_frame_evaluation(int modes) {
  NodeFrameEvaluation e;
  e.J = Matrix6Xd::Identity(6, 6 + modes);
  e.L = Matrix6Xd::Zero(6, 6 + modes);
  return e;
}

void evaluate_node_frame(const FlexibleBody& body, const FlexibleEvaluation& flexible, int node,
                         const FrameKinematics& k, FrameKinematics& k_N, NodeFrameEvaluation& e) {
  const int f = body.modes();
  const auto Phi = body.shape(node), Psi = body.rotation(node);
  e.R = k.R_WB;
  e.s = body.position(node, flexible);
  e.theta = Psi.lazyProduct(flexible.zeta);
  const Vector3d s_rate = Phi.lazyProduct(flexible.zetadot);
  const Vector3d theta_rate = Psi.lazyProduct(flexible.zetadot);
  const Vector3d relative = k.w_WB_B.cross(e.s) + s_rate;
  const Matrix3d T = lie::tangent(e.theta);
  e.A = lie::exp(e.theta).toRotationMatrix();
  const Vector3d w_in_N = e.A.transpose() * k.w_WB_B;

  k_N.p_WB = k.p_WB + k.R_WB * e.s;
  k_N.R_WB = k.R_WB * e.A;
  k_N.v_WB = k.v_WB + k.R_WB * relative;
  k_N.w_WB_B = w_in_N + T * theta_rate;

  e.J.block<3, 3>(0, 3) = -k.R_WB * lie::hat(e.s);
  e.J.block<3, 3>(3, 3) = e.A.transpose();
  e.J.block(0, 6, 3, f) = k.R_WB.lazyProduct(Phi);
  e.J.block(3, 6, 3, f) = T.lazyProduct(Psi);

  const Matrix3d Lambda = lie::hat(w_in_N) * T + lie::tangent_derivative(e.theta, theta_rate);
  const Matrix3d Rw = k.R_WB * lie::hat(k.w_WB_B);
  e.L.block<3, 3>(0, 3) = -k.R_WB * lie::hat(relative);
  e.L.block(0, 6, 3, f) = Rw.lazyProduct(Phi);
  e.L.block(3, 6, 3, f) = Lambda.lazyProduct(Psi);
}

// With f_B = R^T f: J^T f_N = (f, s x f_B + A tau, Phi^T f_B + Psi^T T(theta)^T tau), T(theta)^T = T(-theta).
void add_node_stiffness(const FlexibleBody& body, int node, const NodeFrameEvaluation& e, const Vector6d& f_N,
                        FlexibleBody::Blocks K) {
  const int f = body.modes();
  const auto Phi = body.shape(node), Psi = body.rotation(node);
  const Vector3d tau = f_N.tail<3>();
  const Matrix3d F = lie::hat(e.R.transpose() * f_N.head<3>());
  const Matrix3d A_tau = e.A * lie::hat(tau);
  const Matrix3d turn = lie::tangent_derivative(-e.theta, tau);
  const auto T_Psi = e.J.block(3, 6, 3, f);
  K.frame.bottomRightCorner<3, 3>() += lie::hat(e.s) * F;
  K.frame_modal.bottomRows<3>() -= F.lazyProduct(Phi);
  K.frame_modal.bottomRows<3>() -= A_tau.lazyProduct(T_Psi);
  for (int a = 0; a < f; ++a) {
    const Vector3d Phi_a = Phi.col(a), turn_a = turn.transpose() * Psi.col(a);
    K.modal_frame.block<1, 3>(a, 3) += Phi_a.transpose() * F;
    K.modal.row(a) -= turn_a.transpose().lazyProduct(Psi);
  }
}

}  // namespace sigmafmu
