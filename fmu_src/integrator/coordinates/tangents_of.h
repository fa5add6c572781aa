// What implicit methods share of a group: the parts of vectors it acts on, P^-1, and tangents as the Newton matrix
// takes them.
#pragma once

#include "integrator/implicit/step_equations.h"
#include "lie/pose.h"
#include "lie/so3.h"
#include "model/dense.h"

namespace sigmafmu {
namespace {

using lie::Pose;

inline Pose pose(const VectorXd& q, int body) {
  const double* p = q.data() + kPositionsPerBody * body;
  return {{p[0], p[1], p[2]}, {p[3], p[4], p[5], p[6]}};
}

inline Vector6d of_body(const VectorXd& x, int body) { return x.segment<6>(kVelocitiesPerBody * body); }

// The last N velocities of a body.
template <int N>
auto part_of(VectorXd& x, int body) {
  return x.segment<N>(kVelocitiesPerBody * (body + 1) - N);
}
template <int N>
Eigen::Matrix<double, N, 1> part_of(const VectorXd& x, int body) {
  return x.segment<N>(kVelocitiesPerBody * (body + 1) - N);
}

template <class Part>
using PartMatrixOf = Eigen::Matrix<double, Part::kSize, Part::kSize>;

template <class Part>
SIGMAFMU_NOINLINE PartMatrixOf<Part> P_inverse(double sigma, const Eigen::Matrix<double, Part::kSize, 1>& theta) {
  const PartMatrixOf<Part> P = sigma * PartMatrixOf<Part>::Identity() + (1 - sigma) * Part::tangent(theta);
  return inverse(P);
}

template <class Part>
void begin_tangents(const StepEquations& e, BodyTangents& out) {
  out.rotations_only = Part::kSize == 3;
  out.identity_P = out.rotations_only;
  for (double sigma : e.sigma) out.identity_P = out.identity_P && sigma == 1.0;
}

// From the body twist V = (R^T v_WB, w) to mixed velocities, A = diag(R, I): dv = A dV + R (dphi x V_t), and with
// d(v_WB)/dt = R s, s = Vdot_t + w x V_t:  d(vdot_WB) = R (dVdot_t + dw x V_t + w x dV_t) + R (dphi x s).
inline void turn_tangents(const StepScales& step, const VectorXd& q_n, const Iterate& at, int i, const Matrix6d& G,
                          const Matrix6d& P_inv, BodyTangents& out) {
  const Matrix3d R = pose(at.q, i).quat.toRotationMatrix(), R_n = pose(q_n, i).quat.toRotationMatrix();
  const Vector6d V = of_body(at.V, i);
  const Vector3d V_t = V.head<3>(), w = V.tail<3>();
  const Vector3d s = Vector3d(at.Vdot.segment<3>(kVelocitiesPerBody * i)) + w.cross(V_t);
  Matrix6d &U = out.U[i], &P_inverse = out.P_inverse[i];
  auto &E = out.E[i], &F = out.F[i];
  U = G;
  U.leftCols<3>() *= R.transpose();
  E = step.gamma_prime / step.beta_prime * R * (lie::hat(w) * U.topRows<3>() - lie::hat(V_t) * U.bottomRows<3>());
  U.topRows<3>() = (R * U.topRows<3>()).eval();
  const Matrix3d turned = R * lie::hat(V_t) / step.gamma_prime;
  U.topRightCorner<3, 3>() -= turned;
  E.rightCols<3>() += turned - R * lie::hat(s) / step.beta_prime;
  P_inverse = P_inv;
  P_inverse.leftCols<3>() *= R_n.transpose();
  F = step.gamma_prime / step.beta_prime * R *
      (lie::hat(w) * P_inverse.topRows<3>() - lie::hat(V_t) * P_inverse.bottomRows<3>());
  P_inverse.topRows<3>() = (R * P_inverse.topRows<3>()).eval();
}

// Of body i: G = dV/d(motion)/gamma', P_inv = dV/d(B_n^T mu)/gamma', both of the group's velocities.
template <class Part>
void store_tangents(const StepScales& step, const VectorXd& q_n, const Iterate& at, int i, const PartMatrixOf<Part>& G,
                    const PartMatrixOf<Part>& P_inv, BodyTangents& out) {
  if constexpr (Part::kSize == 3) {
    out.U[i].bottomRightCorner<3, 3>() = G;
    out.P_inverse[i].bottomRightCorner<3, 3>() = P_inv;
  } else {
    turn_tangents(step, q_n, at, i, G, P_inv, out);
  }
}

}  // namespace
}  // namespace sigmafmu
