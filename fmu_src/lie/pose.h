// Position and orientation of a body, and the coordinates that a mechanism may store them in.
#pragma once

#include "lie/so3.h"

namespace sigmafmu::lie {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Vector7d = Eigen::Matrix<double, 7, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

struct Pose {
  Vector3d p;        // p_WB [m], in W
  Quaterniond quat;  // quat_WB, unit
};

// q = (p_WB [m], quat_WB (w, x, y, z)), 7 numbers. Free of singularities; q and (p, -quat) are the same pose.
struct QuaternionPosition {
  using Vector = Vector7d;

  static Pose pose(const Vector& q) { return {q.head<3>(), {q[3], q[4], q[5], q[6]}}; }
  static Vector coordinates(const Pose& c) {
    Vector q;
    q << c.p, c.quat.w(), c.quat.vec();
    return q;
  }
};

// q = (p_WB [m], rotation vector [rad]), 6 numbers. The rotation vector is at most pi long: past pi it goes over to the
// complementary one, which stands for the same rotation. It jumps there, the pose does not.
struct RotationVectorPosition {
  using Vector = Vector6d;

  static Pose pose(const Vector& q) { return {q.head<3>(), exp(q.tail<3>())}; }
  static Vector coordinates(const Pose& c) {
    Vector q;
    q << c.p, log(c.quat);
    return q;
  }
};

// quat or -quat, the same rotation: the one nearer to `previous`. A quaternion made of a rotation vector has w >= 0 and
// jumps to its negative where the rotation vector jumps; this makes an output of it continuous.
inline Quaterniond nearest(const Quaterniond& quat, const Quaterniond& previous) {
  return quat.dot(previous) < 0.0 ? Quaterniond(-quat.coeffs()) : quat;
}

}  // namespace sigmafmu::lie
