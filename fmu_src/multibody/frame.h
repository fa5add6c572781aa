// What elements attach to: a body's own frame, the ground, or a frame N that moves with a node of a flexible body B, so
// that elements written for rigid frames hold there as well. With the modes' shapes Phi and turns Psi at the node, s =
// X + Phi zeta and theta = Psi zeta:
//
//   p_WN = p_WB + R s,              R_WN = R A,   A = exp(hat(theta))
//   v_WN = v_WB + R (w x s + s'),   w_N = A^T w + T(theta) theta'
//
//   J = d(v_N)/d(v)      = [ I  -R hat(s)           R Phi        ]
//                          [ 0   A^T                T(theta) Psi ]
//   L = d(v_N)/d(motion) = [ 0  -R hat(w x s + s')  R hat(w) Phi ]
//                          [ 0   0                  Lambda Psi   ]
//
// Lambda = hat(A^T w) T(theta) + d(T(theta) theta')/dtheta. Motions transform like velocities, forces f_N = (f in W,
// tau in N) the other way: f = J^T f_N. For an element with residual f_N, its derivatives K_N and C_N, its gradient B_N
// and its rate Z_N between such frames, the pull-back onto the pose and the modes of the body is
//
//   B = B_N J,   Z = Z_N J + B_N L,   C_ij = J_i^T C_N,ij J_j,   K_ij = J_i^T (K_N,ij J_j + C_N,ij L_j) + Q_ij,
//
// where Q = d(J^T f_N)/d(motion) at constant f_N couples the body with itself alone.
#pragma once

#include "multibody/bodies/flexible_body.h"

namespace sigmafmu {

struct NodeFrame {
  int body, flexible, node;  // `flexible` counts the flexible bodies
};

struct NodeFrameEvaluation {
  Matrix6Xd J, L;     // columns: frame, modes
  Vector3d s, theta;  // in B [m], [rad]
  Matrix3d R, A;
};

// Of a frame that is the body's own: J = I, L = 0.
NodeFrameEvaluation make_node_frame_evaluation(int modes);

// k_N is the kinematic state of N, k that of the body.
void evaluate_node_frame(const FlexibleBody& body, const FlexibleEvaluation& flexible, int node,
                         const FrameKinematics& k, FrameKinematics& k_N, NodeFrameEvaluation& e);

// K += Q.
void add_node_stiffness(const FlexibleBody& body, int node, const NodeFrameEvaluation& e, const Vector6d& f_N,
                        FlexibleBody::Blocks K);

// d(v_N')/d(motion) and d(v_N')/dv, v_N' = J v' + L v, columns as in J. With w', s'' and theta'' from `vdot` of the
// frame and `zetaddot`, T = T(theta), D(c) = d(T c)/dtheta, E = dT/dt and b = w' x s + w x (w x s) + 2 w x s' + s'':
//
//   d/d(motion) = [ 0  -R hat(b)                                    R (hat(w') + hat(w)^2) Phi ]
//                 [ 0   0                                           Q Psi                      ]
//   d/dv        = [ 0  -R (hat(w x s) + hat(w) hat(s) + 2 hat(s'))  2 R hat(w) Phi             ]
//                 [ 0  -hat(T theta') A^T                           (hat(A^T w) T + D(theta') + E) Psi ]
//   Q = (hat(A^T w') - hat(T theta') hat(A^T w)) T + D(theta'') + hat(A^T w) D(theta') + d(E theta')/dtheta.
void node_acceleration_derivatives(const FlexibleBody& body, const FlexibleEvaluation& flexible, int node,
                                   const FrameKinematics& k, const NodeFrameEvaluation& e, const Vector6d& vdot,
                                   const Eigen::Ref<const VectorXd>& zetaddot, Eigen::Ref<Matrix6Xd> by_motion,
                                   Eigen::Ref<Matrix6Xd> by_velocity);

}  // namespace sigmafmu
