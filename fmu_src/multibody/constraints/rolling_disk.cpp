#include "multibody/constraints/rolling_disk.h"

#include <Eigen/Geometry>

#include "multibody/constraints/primitives_inline.h"

namespace sigmafmu {

RollingDisk::Contact RollingDisk::contact(const FrameKinematics& b1, const FrameKinematics& b2) const {
  const Vector3d n = b2.R_WB.transpose() * (b1.R_WB * axes1.col(2));
  const Vector3d across = n - a2.dot(n) * a2;
  const double sine = across.norm();
  const Vector3d d = -across / sine;
  return {s2 + radius * d, a2.cross(d), n, sine};
}

Vector3d RollingDisk::touching_point(const FrameKinematics& b1, const FrameKinematics& b2) const {
  return b2.p_WB + b2.R_WB * contact(b1, b2).c;
}

double RollingDisk::gap(const FrameKinematics& b1, const FrameKinematics& b2) const {
  return distance(0, contact(b1, b2)).gap(b1, b2);
}

void RollingDisk::gradient(const FrameKinematics& b1, const FrameKinematics& b2, int row, const Rows& B1,
                           const Rows& B2) const {
  const Contact at = contact(b1, b2);
  for (int k = 0; k < 3; ++k) distance(k, at).gradient(b1, b2, row + k, B1, B2);
}

void RollingDisk::rate(const FrameKinematics& b1, const FrameKinematics& b2, int row, Rows Z1, Rows Z2) const {
  const Contact at = contact(b1, b2);
  const Matrix3d R12 = b1.R_WB.transpose() * b2.R_WB;
  const Vector3d q2 = at.t.cross(at.n), q1 = -(R12 * q2), t1 = R12 * at.t;
  const Vector3d w1 = R12 * b2.w_WB_B - b1.w_WB_B;  // of the disk against the plane, in body 1
  for (int k = 0; k < 3; ++k) {
    const AxialDistance distance = this->distance(k, at);
    distance.rate(b1, b2, row + k, Z1, Z2);
    const double turn = -radius / at.sine * distance.n1.cross(w1).dot(t1);
    Z1.block<1, 3>(row + k, 3) += turn * q1.transpose();
    Z2.block<1, 3>(row + k, 3) += turn * q2.transpose();
  }
}

void RollingDisk::stiffness(const FrameKinematics& b1, const FrameKinematics& b2, const double* lambda,
                            const FramePairs& K) const {
  const Contact at = contact(b1, b2);
  const Matrix3d R12 = b1.R_WB.transpose() * b2.R_WB;
  const Vector3d f1 = lambda[0] * axes1.col(2) + lambda[1] * axes1.col(0) + lambda[2] * axes1.col(1);
  AxialDistance{f1, s1, at.c}.stiffness(b1, b2, 1.0, K);
  const Vector3d q2 = at.t.cross(at.n), tf2 = at.t.cross(R12.transpose() * f1);
  const Vector3d q[2] = {-(R12 * q2), q2}, tf[2] = {R12 * -tf2, tf2};
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      if (K.has(i, j)) K(i, j).bottomRightCorner<3, 3>() -= radius / at.sine * tf[i] * q[j].transpose();
    }
  }
}

}  // namespace sigmafmu
