#include "multibody/forces/frame_pair_force.h"

#include "lie/isotropic_operator.h"

namespace sigmafmu {

RelativeMotion FramePairForce::relative(const Kinematics& k) const {
  const FrameKinematics &k1 = k[0], &k2 = k[1];
  const Matrix3d R12 = k1.R_WB.transpose() * k2.R_WB;
  const Vector3d a = k1.R_WB.transpose() * (k2.p_WB - k1.p_WB) + R12 * frame2_.origin;
  const Vector3d m = k1.R_WB.transpose() * (k2.v_WB - k1.v_WB) + R12 * k2.w_WB_B.cross(frame2_.origin);
  const auto A1t = frame1_.axes.transpose();
  return {A1t * (a - frame1_.origin), A1t * R12 * frame2_.axes, A1t * (m + a.cross(k1.w_WB_B)),
          A1t * (R12 * k2.w_WB_B - k1.w_WB_B)};
}

void FramePairForce::add(const Kinematics& k, const Inputs& u, const FrameForces& r) const {
  const FrameKinematics &k1 = k[0], &k2 = k[1];
  const Vector6d W = wrench(relative(k), own(u));
  const Vector3d f = frame1_.axes * W.head<3>(), t = frame1_.axes * W.tail<3>();
  const Vector3d f_W = k1.R_WB * f;
  if (r.has(0)) {
    const Vector3d a = k1.R_WB.transpose() * (k2.p_WB + k2.R_WB * frame2_.origin - k1.p_WB);
    r[0].head<3>() += f_W;
    r[0].tail<3>() += a.cross(f) + t;
  }
  if (r.has(1)) {
    r[1].head<3>() -= f_W;
    r[1].tail<3>() -= frame2_.origin.cross(k2.R_WB.transpose() * f_W) + k2.R_WB.transpose() * (k1.R_WB * t);
  }
}

void FramePairForce::linearize(const Kinematics& k, const Inputs& u, const FramePairs& K, const FramePairs& C) const {
  using lie::hat;
  const FrameKinematics &k1 = k[0], &k2 = k[1];
  const Matrix3d R1t = k1.R_WB.transpose(), R12 = R1t * k2.R_WB, s2 = hat(frame2_.origin), w1 = hat(k1.w_WB_B);
  const Vector3d a = R1t * (k2.p_WB - k1.p_WB) + R12 * frame2_.origin;
  const Vector3d y = k2.w_WB_B.cross(frame2_.origin), m = R1t * (k2.v_WB - k1.v_WB) + R12 * y;
  const Matrix3d hat_a = hat(a), R12_s2 = R12 * s2;
  const Matrix3d A1t = frame1_.axes.transpose();
  const auto blocks = [&](const Matrix3d& move, const Matrix3d& turn, const Matrix3d& rotation) {
    Matrix6d G;
    G << A1t * move, A1t * turn, Matrix3d::Zero(), A1t * rotation;
    return G;
  };
  const Matrix6d G[2] = {blocks(-R1t, hat_a, -Matrix3d::Identity()), blocks(R1t, -R12_s2, R12)};
  const Matrix6d Z[2] = {blocks(w1 * R1t, hat(m) - w1 * hat_a, hat(R12 * k2.w_WB_B)),
                         blocks(-w1 * R1t, w1 * R12_s2 - R12 * hat(y), -R12 * hat(k2.w_WB_B))};

  const RelativeMotion x = relative(k);
  const Vector6d W = wrench(x, own(u));
  Matrix6d by_motion, by_velocity;
  derivatives(x, own(u), by_motion, by_velocity);
  for (int j = 0; j < 2; ++j) {
    if (!K.has(j, j)) continue;  // the ground
    const Matrix6d C_j = by_velocity * G[j], K_j = by_motion * G[j] + by_velocity * Z[j];
    for (int i = 0; i < 2; ++i) {
      if (!K.has(i, j)) continue;
      K(i, j).noalias() -= G[i].transpose() * K_j;
      C(i, j).noalias() -= G[i].transpose() * C_j;
    }
  }

  // d(G^T W)/d(motion): G_1^T W = (-R_1 f, f x a - t), G_2^T W = (R_1 f, s_2 x R21 f + R21 t).
  const Vector3d f = frame1_.axes * W.head<3>(), t = frame1_.axes * W.tail<3>();
  const Matrix3d hat_f = hat(f), R21 = R12.transpose(), R1_f = k1.R_WB * hat_f;
  if (K.has(0, 0)) {
    K(0, 0).topRightCorner<3, 3>() -= R1_f;
    K(0, 0).bottomLeftCorner<3, 3>() += hat_f * R1t;
    K(0, 0).bottomRightCorner<3, 3>() -= hat_f * hat_a;
  }
  if (K.has(1, 1)) K(1, 1).bottomRightCorner<3, 3>() -= s2 * hat(R21 * f) + hat(R21 * t);
  if (K.has(0, 1)) {
    K(0, 1).bottomLeftCorner<3, 3>() -= hat_f * R1t;
    K(0, 1).bottomRightCorner<3, 3>() += hat_f * R12_s2;
    K(1, 0).topRightCorner<3, 3>() += R1_f;
    K(1, 0).bottomRightCorner<3, 3>() += s2 * R21 * hat_f + R21 * hat(t);
  }
}

}  // namespace sigmafmu
