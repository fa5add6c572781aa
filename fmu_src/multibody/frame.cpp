#include "multibody/frame.h"

#include "lie/rotation_maps.h"
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

void node_acceleration_derivatives(const FlexibleBody& body, const FlexibleEvaluation& flexible, int node,
                                   const FrameKinematics& k, const NodeFrameEvaluation& e, const Vector6d& vdot,
                                   const Eigen::Ref<const VectorXd>& zetaddot, Eigen::Ref<Matrix6Xd> by_motion,
                                   Eigen::Ref<Matrix6Xd> by_velocity) {
  const int f = body.modes();
  const auto Phi = body.shape(node), Psi = body.rotation(node);
  const Vector3d s_rate = Phi.lazyProduct(flexible.zetadot), s_second = Phi.lazyProduct(zetaddot);
  const Vector3d theta_rate = Psi.lazyProduct(flexible.zetadot), theta_second = Psi.lazyProduct(zetaddot);
  const Vector3d w = k.w_WB_B, wdot = vdot.tail<3>(), turning = w.cross(e.s);
  const Matrix3d w_hat = lie::hat(w);
  by_motion.setZero();
  by_velocity.setZero();

  const Vector3d b = wdot.cross(e.s) + w.cross(turning) + 2 * w.cross(s_rate) + s_second;
  const Matrix3d along = e.R * (lie::hat(wdot) + w_hat * w_hat), across = 2 * e.R * w_hat;
  by_motion.block<3, 3>(0, 3) = -e.R * lie::hat(b);
  by_motion.block(0, 6, 3, f) = along.lazyProduct(Phi);
  by_velocity.block<3, 3>(0, 3) = -e.R * (lie::hat(turning) + w_hat * lie::hat(e.s) + 2 * lie::hat(s_rate));
  by_velocity.block(0, 6, 3, f) = across.lazyProduct(Phi);

  const lie::SmoothOperator tangent = lie::Exponential::tangent(e.theta.squaredNorm());
  const Matrix3d T = tangent.k.matrix(e.theta), D = tangent.derivative(e.theta, theta_rate);
  const Matrix3d E = tangent.derivative_along(e.theta, theta_rate);
  const Matrix3d turn = lie::hat(e.A.transpose() * w), own = lie::hat(T * theta_rate);
  const Matrix3d Q = (lie::hat(e.A.transpose() * wdot) - own * turn) * T + tangent.derivative(e.theta, theta_second) +
                     turn * D + tangent.second_derivative(e.theta, theta_rate, theta_rate);
  const Matrix3d of_rates = turn * T + D + E;
  by_motion.block(3, 6, 3, f) = Q.lazyProduct(Psi);
  by_velocity.block<3, 3>(3, 3) = -own * e.A.transpose();
  by_velocity.block(3, 6, 3, f) = of_rates.lazyProduct(Psi);
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
