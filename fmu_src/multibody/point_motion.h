// How a frame moves that nothing need be attached to: place, velocity and acceleration, all in W.
//
// At s and with the axes A of a rigid body B, with a node of a flexible one in between (frame.h: s(zeta), theta(zeta)):
//
//   p = p_WB + R s,   v = v_WB + R (w x s + s'),   a = v' + R (w' x s + w x (w x s) + 2 w x s' + s''),
//   w_N = A^T w + n,   w_N' = A^T w' - n x A^T w + n',
//   n = T(theta) theta',   n' = T theta'' + d(T theta')/dtheta theta'.
#pragma once

#include "multibody/system.h"

namespace sigmafmu {

struct PointMotion {
  Vector3d p = Vector3d::Zero();  // [m]
  Matrix3d R = Matrix3d::Identity();
  Vector3d v = Vector3d::Zero(), w = Vector3d::Zero();        // [m/s, rad/s]
  Vector3d vdot = Vector3d::Zero(), wdot = Vector3d::Zero();  // [m/s2, rad/s2]
};

// `vdot`: all accelerations; where they are not known, those of the result mean nothing.
PointMotion point_motion(const System& system, const Evaluation& e, const VectorXd& vdot, int body, const Frame& frame);

// The motion of `point` as an observer on `reference` sees it, who turns with that; still in W's axes.
PointMotion seen_from(const PointMotion& reference, const PointMotion& point);

}  // namespace sigmafmu
