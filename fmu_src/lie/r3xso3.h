// The group R^3 x SO(3) of one rigid body: mixed velocities v = (v_WB in W, w_WB_B in body axes).
//
// Absolute coordinates of a body: q = (p_WB [m], quat_WB (w, x, y, z)), 7 numbers; local coordinates
// theta = (theta_t [m], theta_r [rad]), 6 numbers. The hat operator and T act on the rotation alone
// (Holzinger, Arnold, Gerstmayr 2025, Eqs. A.6, A.7, B.2).
#pragma once

#include "lie/so3.h"

namespace sigmafmu::lie {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Vector7d = Eigen::Matrix<double, 7, 1>;

template <typename Coordinates>
inline Quaterniond quaternion(const Coordinates& q) {
  return {q[3], q[4], q[5], q[6]};
}

// q o exp(theta), the local-global transition map (44). The quaternion is brought back to unit length to rounding.
template <typename Coordinates, typename Local>
inline Vector7d compose(const Coordinates& q, const Local& theta) {
  Quaterniond r = quaternion(q) * exp(Vector3d(theta[3], theta[4], theta[5]));
  r.coeffs() *= 0.5 * (3.0 - r.squaredNorm());  // one Newton step for 1/|r|: r is unit up to rounding
  Vector7d result;
  for (int i = 0; i < 3; ++i) result[i] = q[i] + theta[i];
  result[3] = r.w(), result[4] = r.x(), result[5] = r.y(), result[6] = r.z();
  return result;
}

}  // namespace sigmafmu::lie
