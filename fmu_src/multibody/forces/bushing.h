// Spring and damper between two frames in all six directions. x = (d, psi) with the displacement d of origin 2 and the
// rotation vector psi of Q = exp(hat(psi)), whose rate is psi' = P w, P = T(-psi)^-1 (lie/so3.h; P^T = T(psi)^-1):
//
//   x' = L (d', w),   L = diag(I, P),   W = -L^T y,   y = K x + D x'.
//
// So the elastic part is the gradient of the energy x^T K x / 2, however large the rotation is, and damping takes the
// power x'^T D x'. Rotations are below half a turn: psi jumps there. With dpsi = P dphi,
//
//   dW/d(d, Q)  = -L^T (K L + D [0; dP w/dphi]) - [0; d(P^T y_psi)/dphi],   dW/d(d', w) = -L^T D L.
#pragma once

#include "multibody/forces/frame_pair_force.h"

namespace sigmafmu {

class Bushing final : public FramePairForce {
 public:
  Bushing(const BushingDef& d, int index) : FramePairForce(d.frame1, d.frame2), index_(index) {}

  const std::vector<ForcePort>& ports() const override;
  void set_values(const MultibodyDef& definition) override;
  Stiffest stiffest() const override;

 private:
  struct Deformation {
    Vector6d x, xdot;
    Matrix3d P;
  };
  static Deformation deformation(const RelativeMotion& m);
  Vector6d load(const Deformation& s) const { return stiffness_ * s.x + damping_ * s.xdot; }  // y
  Vector6d wrench(const RelativeMotion& m, const double* u) const override;
  void derivatives(const RelativeMotion& m, const double* u, Matrix6d& by_motion, Matrix6d& by_velocity) const override;
  double stored(const RelativeMotion& m) const override;

  int index_;  // in MultibodyDef::bushings
  Matrix6d stiffness_, damping_;
};

}  // namespace sigmafmu
