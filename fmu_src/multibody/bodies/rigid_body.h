// Rigid body about its centre of mass: m vdot = f, J wdot + w x J w = tau with f in W, J, w, tau in body axes.
#pragma once

#include "lie/isotropic_operator.h"
#include "multibody/definition.h"
#include "multibody/kinematics.h"

namespace sigmafmu {

// The inertia matrix J [kg m^2] of a definition.
inline Matrix3d inertia_matrix(const RigidBodyDef& d) {
  Matrix3d J = d.inertia.asDiagonal();
  J(0, 1) = J(1, 0) = d.inertia_products[0];
  J(0, 2) = J(2, 0) = d.inertia_products[1];
  J(1, 2) = J(2, 1) = d.inertia_products[2];
  return J;
}

struct RigidBody {
  double mass;
  Matrix3d J;

  // M vdot + (0, w x J w).
  Vector6d inertial_force(const BodyKinematics& k, const Vector6d& vdot) const {
    Vector6d r;
    r.head<3>() = mass * vdot.head<3>();
    r.tail<3>() = J * vdot.tail<3>() + k.w_WB_B.cross(J * k.w_WB_B);
    return r;
  }
  // d(w x J w)/dw = hat(w) J - hat(J w).
  Matrix3d gyroscopic_damping(const BodyKinematics& k) const { return lie::hat(k.w_WB_B) * J - lie::hat(J * k.w_WB_B); }
  double kinetic_energy(const BodyKinematics& k) const {
    return 0.5 * (mass * k.v_WB.squaredNorm() + k.w_WB_B.dot(J * k.w_WB_B));
  }
};

}  // namespace sigmafmu
