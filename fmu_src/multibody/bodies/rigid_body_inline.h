// Definitions of rigid_body.h, for the few files that use them: compiling them takes longer than all of Eigen's
// headers.
#pragma once

#include "lie/isotropic_operator.h"
#include "multibody/bodies/rigid_body.h"

namespace sigmafmu {

inline Vector6d RigidBody::inertial_force(const FrameKinematics& k, const Vector6d& vdot) const {
  Vector6d r;
  r.head<3>() = mass * vdot.head<3>();
  r.tail<3>() = J * vdot.tail<3>() + k.w_WB_B.cross(J * k.w_WB_B);
  return r;
}

inline Matrix3d RigidBody::gyroscopic_damping(const FrameKinematics& k) const {
  return lie::hat(k.w_WB_B) * J - lie::hat(J * k.w_WB_B);
}

inline double RigidBody::kinetic_energy(const FrameKinematics& k) const {
  return 0.5 * (mass * k.v_WB.squaredNorm() + k.w_WB_B.dot(J * k.w_WB_B));
}

}  // namespace sigmafmu
