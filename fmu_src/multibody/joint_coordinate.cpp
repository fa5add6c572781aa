#include "multibody/joint_coordinate.h"

#include <cmath>

#include "multibody/constraints/primitives_inline.h"

namespace sigmafmu {
namespace {

constexpr double kTwoPi = 6.28318530717958647692;

}  // namespace

double JointCoordinate::value(const Kinematics& k) const {
  if (kind_ == Kind::displacement) return along_.gap(k[0], k[1]);
  const Vector3d x2 = k[0].R_WB.transpose() * (k[1].R_WB * frame2_.axes.col(0));
  return std::atan2(frame1_.axes.col(1).dot(x2), frame1_.axes.col(0).dot(x2));
}

double JointCoordinate::value_near(const Kinematics& k, double near) const {
  const double c = value(k);
  return is_angle() ? c + kTwoPi * std::round((near - c) / kTwoPi) : c;
}

double JointCoordinate::rate(const Kinematics& k) const {
  const FrameKinematics &k1 = k[0], &k2 = k[1];
  const Vector3d n1 = frame1_.axes.col(2);
  if (kind_ == Kind::displacement) {
    const Vector3d n = k1.R_WB * n1;
    return n.dot(k2.v_WB - k1.v_WB) + k1.w_WB_B.dot(n1.cross(along_.seen_from_1(k1, k2))) +
           k2.w_WB_B.dot(frame2_.origin.cross(k2.R_WB.transpose() * n));
  }
  return frame2_.axes.col(2).dot(k2.w_WB_B) - n1.dot(k1.w_WB_B);
}

void JointCoordinate::add_force(const Kinematics& k, double f, const FrameForces& r) const {
  const Vector3d n1 = frame1_.axes.col(2);
  if (kind_ == Kind::angle) {
    if (r.has(0)) r[0].tail<3>() += f * n1;
    if (r.has(1)) r[1].tail<3>() -= f * frame2_.axes.col(2);
    return;
  }
  const Vector3d n = k[0].R_WB * n1;
  if (r.has(0)) {
    r[0].head<3>() += f * n;
    r[0].tail<3>() -= f * n1.cross(along_.seen_from_1(k[0], k[1]));
  }
  if (r.has(1)) {
    r[1].head<3>() -= f * n;
    r[1].tail<3>() -= f * frame2_.origin.cross(k[1].R_WB.transpose() * n);
  }
}

void JointCoordinate::stiffness(const Kinematics& k, double f, const FramePairs& K) const {
  if (kind_ == Kind::displacement && f != 0.0) along_.stiffness(k[0], k[1], -f, K);
}

void JointCoordinate::gradient(const Kinematics& k, const FrameRows& B) const {
  if (kind_ == Kind::displacement) return along_.gradient(k[0], k[1], 0, B[0], B[1]);
  B[0] << Eigen::RowVector3d::Zero(), -frame1_.axes.col(2).transpose();
  B[1] << Eigen::RowVector3d::Zero(), frame2_.axes.col(2).transpose();
}

void JointCoordinate::rates(const Kinematics& k, const FrameRows& Z) const {
  if (kind_ == Kind::displacement) return along_.rate(k[0], k[1], 0, Z[0], Z[1]);
  Z[0].setZero();
  Z[1].setZero();
}

}  // namespace sigmafmu
