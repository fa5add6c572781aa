// Rigid body about its centre of mass: m vdot = f, J wdot + w x J w = tau with f in W, J, w, tau in body axes.
#pragma once

#include "model/definition.h"
#include "multibody/kinematics.h"

namespace sigmafmu {

struct RigidBody {
  double mass = 0.0;
  Matrix3d J = Matrix3d::Zero();

  // M vdot + (0, w x J w).
  Vector6d inertial_force(const FrameKinematics& k, const Vector6d& vdot) const;
  // d(w x J w)/dw = hat(w) J - hat(J w).
  Matrix3d gyroscopic_damping(const FrameKinematics& k) const;
  double kinetic_energy(const FrameKinematics& k) const;
};

}  // namespace sigmafmu
