#include "multibody/joint_coordinate.h"

#include <cmath>

#include "multibody/constraints/primitives_inline.h"

namespace sigmafmu {
namespace {

constexpr double kTwoPi = 6.28318530717958647692;

}  // namespace

JointCoordinate::JointCoordinate(const CoordinateType& type, const Frame& frame1, const Frame& frame2)
    : type_(type),
      along_{frame1.axes.col(type.axis), frame1.origin, frame2.origin},
      n1_(frame1.axes.col(type.axis)),
      n2_(frame2.axes.col(type.axis)) {
  const int from = type.axis == 0 ? 1 : 0, third = 3 - type.axis - from;
  const bool of_2 = type.of == Of::frame2;
  const Matrix3d &own = of_2 ? frame2.axes : frame1.axes, &other = of_2 ? frame1.axes : frame2.axes;
  b_ = other.col(from);
  f_ = own.col(from);
  s_ = ((type.axis == 1) != of_2 ? -1.0 : 1.0) * own.col(third);  // n x f, seen the other way round from frame 2
}

double JointCoordinate::value(const Kinematics& k) const {
  if (!is_angle()) return along_.gap(k[0], k[1]);
  const int own = type_.of == Of::frame2 ? 1 : 0;
  const Vector3d b = k[own].R_WB.transpose() * (k[1 - own].R_WB * b_);
  return std::atan2(s_.dot(b), f_.dot(b));
}

double JointCoordinate::value_near(const Kinematics& k, double near) const {
  const double c = value(k);
  return is_angle() ? c + kTwoPi * std::round((near - c) / kTwoPi) : c;
}

Vector3d JointCoordinate::axis_in_1(const Kinematics& k) const {
  return type_.of == Of::frame2 ? k[0].R_WB.transpose() * (k[1].R_WB * n2_) : n1_;
}

Vector3d JointCoordinate::axis_in_2(const Kinematics& k) const {
  return type_.of == Of::frame1 ? k[1].R_WB.transpose() * (k[0].R_WB * n1_) : n2_;
}

double JointCoordinate::rate(const Kinematics& k) const {
  const FrameKinematics &k1 = k[0], &k2 = k[1];
  if (is_angle()) return axis_in_2(k).dot(k2.w_WB_B) - axis_in_1(k).dot(k1.w_WB_B);
  const Vector3d n = k1.R_WB * n1_;
  return n.dot(k2.v_WB - k1.v_WB) + k1.w_WB_B.dot(n1_.cross(along_.seen_from_1(k1, k2))) +
         k2.w_WB_B.dot(along_.s2.cross(k2.R_WB.transpose() * n));
}

double JointCoordinate::acceleration(const Kinematics& k, const Vector6d& vdot1, const Vector6d& vdot2) const {
  double b[12], z[12];
  const FrameRows B(b, 1), Z(z, 1);
  gradient(k, B);
  rates(k, Z);
  const auto part = [&](int i, const Vector6d& vdot) {
    return B[i].row(0).dot(vdot) + Z[i].row(0).head<3>().dot(k[i].v_WB) + Z[i].row(0).tail<3>().dot(k[i].w_WB_B);
  };
  return part(0, vdot1) + part(1, vdot2);
}

// Angles: rate = m . w_2 - n . w_1 of an axis n of frame 1, m = R_2^T R_1 n, so with q = w_1 x n
//
//   c'' = m . w_2' - n . w_1' + (R_2^T R_1 q) . w_2,
//
// and the same with bodies and sign exchanged for an axis of frame 2; nothing moves an axis of both frames. In body 1 a
// displacement has, of point 2 against the origin of body 1, u, its velocity e and its acceleration f (both of W), and
//
//   c'' = n . f + 2 (w_1 x n) . e + (w_1' x n + w_1 x (w_1 x n)) . u = A_0 . f + A_1 . e + A_2 . u.
void JointCoordinate::acceleration_derivatives(const Kinematics& k, const Vector6d& vdot1, const Vector6d& vdot2,
                                               const FrameRows& by_motion, const FrameRows& by_velocity) const {
  for (int i = 0; i < 2; ++i) {
    by_motion[i].setZero();
    by_velocity[i].setZero();
  }
  if (is_angle()) {
    if (type_.of == Of::both_frames) return;
    const bool of_2 = type_.of == Of::frame2;
    const int own = of_2 ? 1 : 0, other = 1 - own;
    const FrameKinematics &k1 = k[own], &k2 = k[other];
    const double sign = of_2 ? -1.0 : 1.0;
    const Vector3d n = of_2 ? n2_ : n1_, q = k1.w_WB_B.cross(n), wdot_2 = (of_2 ? vdot1 : vdot2).tail<3>();
    const Matrix3d R12 = k1.R_WB.transpose() * k2.R_WB;
    const Vector3d m = R12.transpose() * n, q_in_2 = R12.transpose() * q;
    by_motion[own].rightCols<3>() = sign * (n.cross(R12 * wdot_2) + q.cross(R12 * k2.w_WB_B)).transpose();
    by_motion[other].rightCols<3>() = sign * (wdot_2.cross(m) + k2.w_WB_B.cross(q_in_2)).transpose();
    by_velocity[own].rightCols<3>() = sign * n.cross(R12 * k2.w_WB_B).transpose();
    by_velocity[other].rightCols<3>() = sign * q_in_2.transpose();
    return;
  }
  const FrameKinematics &k1 = k[0], &k2 = k[1];
  const Vector3d w1 = k1.w_WB_B, w2 = k2.w_WB_B, wdot1 = vdot1.tail<3>(), wdot2 = vdot2.tail<3>(), &s2 = along_.s2;
  const Matrix3d R12 = k1.R_WB.transpose() * k2.R_WB;
  const Vector3d turn = w1.cross(n1_), sdot = w2.cross(s2), sddot = wdot2.cross(s2) + w2.cross(sdot);
  const Vector3d u = along_.seen_from_1(k1, k2);
  const Vector3d e = k1.R_WB.transpose() * (k2.v_WB - k1.v_WB) + R12 * sdot;
  const Vector3d f = k1.R_WB.transpose() * (vdot2.head<3>() - vdot1.head<3>()) + R12 * sddot;
  const Vector3d A1 = 2 * turn, A2 = wdot1.cross(n1_) + w1.cross(turn);
  const Vector3d m0 = R12.transpose() * n1_, m1 = R12.transpose() * A1, m2 = R12.transpose() * A2;
  const Vector3d A1_W = k1.R_WB * A1, A2_W = k1.R_WB * A2;
  by_motion[0] << -A2_W.transpose(), (n1_.cross(f) + A1.cross(e) + A2.cross(u)).transpose();
  by_motion[1] << A2_W.transpose(), (sddot.cross(m0) + sdot.cross(m1) + s2.cross(m2)).transpose();
  by_velocity[0] << -A1_W.transpose(), (2 * n1_.cross(e) + turn.cross(u) + n1_.cross(u.cross(w1))).transpose();
  by_velocity[1] << A1_W.transpose(), (s2.cross(m1) + sdot.cross(m0) + s2.cross(m0.cross(w2))).transpose();
}

void JointCoordinate::add_force(const Kinematics& k, double f, const FrameForces& r) const {
  if (is_angle()) {
    if (r.has(0)) r[0].tail<3>() += f * axis_in_1(k);
    if (r.has(1)) r[1].tail<3>() -= f * axis_in_2(k);
    return;
  }
  const Vector3d n = k[0].R_WB * n1_;
  if (r.has(0)) {
    r[0].head<3>() += f * n;
    r[0].tail<3>() -= f * n1_.cross(along_.seen_from_1(k[0], k[1]));
  }
  if (r.has(1)) {
    r[1].head<3>() -= f * n;
    r[1].tail<3>() -= f * along_.s2.cross(k[1].R_WB.transpose() * n);
  }
}

// Of an axis n of frame 1 the force on body 2 is f m, m = R_2^T R_1 n: dm = hat(m) phi_2 - R_2^T R_1 hat(n) phi_1.
// Where frame 2 has the axis, bodies and sign are exchanged.
void JointCoordinate::stiffness(const Kinematics& k, double f, const FramePairs& K) const {
  if (f == 0.0 || !couples_frames()) return;
  if (!is_angle()) return along_.stiffness(k[0], k[1], -f, K);
  const bool of_2 = type_.of == Of::frame2;
  const int own = of_2 ? 1 : 0, other = 1 - own;
  if (of_2) f = -f;
  if (K.has(other, other)) {
    K(other, other).bottomRightCorner<3, 3>() -= f * lie::hat(of_2 ? axis_in_1(k) : axis_in_2(k));
  }
  if (K.has(other, own)) {
    K(other, own).bottomRightCorner<3, 3>() +=
        f * (k[other].R_WB.transpose() * (k[own].R_WB * lie::hat(of_2 ? n2_ : n1_)));
  }
}

void JointCoordinate::gradient(const Kinematics& k, const FrameRows& B) const {
  if (!is_angle()) return along_.gradient(k[0], k[1], 0, B[0], B[1]);
  B[0] << Eigen::RowVector3d::Zero(), -axis_in_1(k).transpose();
  B[1] << Eigen::RowVector3d::Zero(), axis_in_2(k).transpose();
}

// Of an axis n of frame 1: rate = m . w_2 - n . w_1, with Z_1 = n x R_1^T R_2 w_2 and Z_2 = w_2 x m.
void JointCoordinate::rates(const Kinematics& k, const FrameRows& Z) const {
  if (!is_angle()) return along_.rate(k[0], k[1], 0, Z[0], Z[1]);
  Z[0].setZero();
  Z[1].setZero();
  if (type_.of == Of::both_frames) return;
  const bool of_2 = type_.of == Of::frame2;
  const int own = of_2 ? 1 : 0, other = 1 - own;
  const Vector3d& w = k[other].w_WB_B;
  const Vector3d w_in_own = k[own].R_WB.transpose() * (k[other].R_WB * w);
  const double sign = of_2 ? -1.0 : 1.0;
  Z[own].rightCols<3>() = sign * (of_2 ? n2_ : n1_).cross(w_in_own).transpose();
  Z[other].rightCols<3>() = sign * w.cross(of_2 ? axis_in_1(k) : axis_in_2(k)).transpose();
}

}  // namespace sigmafmu
