// A torque t [N m] on the second body and its opposite on the first one, in the axes A_1 of the joint's first frame:
// with n = A_1 t, -n on body 1 and m = R_2^T R_1 n on body 2, each in its body's axes. Its power is t . w, w = A_1^T
// (R_1^T R_2 w_2 - w_1), the relative angular velocity in these axes.
#pragma once

#include "multibody/forces/force.h"

namespace sigmafmu {

class RotationMotor final : public Force {
 public:
  RotationMotor(const Frame& frame1, const Frame& frame2) : axes1_(frame1.axes), axes2_(frame2.axes) {}

  int frame_count() const override { return 2; }
  const std::vector<ForcePort>& ports() const override;
  void add(const Kinematics& k, const Inputs& u, const FrameForces& r) const override;
  void linearize(const Kinematics& k, const Inputs& u, const FramePairs& K, const FramePairs& C) const override;

 private:
  Vector3d torque_in_1(const Inputs& u) const { return axes1_ * Vector3d::Map(own(u)); }
  // Psi of A_1^T R_1^T R_2 A_2 = exp(hat(psi)), |psi| <= pi.
  Vector3d rotation_vector(const Kinematics& k) const;
  Vector3d angular_velocity(const Kinematics& k) const;

  Matrix3d axes1_, axes2_;
};

}  // namespace sigmafmu
