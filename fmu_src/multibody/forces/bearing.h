// A bearing or seal with cross-coupling, in the axes of frame 1: F = -K d - C d', T = 0.
//
// K = S + A: the symmetric part S stores d^T S d / 2, the other one drives or brakes an orbit, whichever way it turns.
#pragma once

#include "multibody/forces/frame_pair_force.h"

namespace sigmafmu {

class Bearing final : public FramePairForce {
 public:
  Bearing(const BearingDef& d, int index) : FramePairForce(d.frame1, d.frame2), index_(index) {}

  const std::vector<ForcePort>& ports() const override;
  void set_values(const MultibodyDef& d) override {
    stiffness_ = d.bearings[index_].stiffness_matrix();
    damping_ = d.bearings[index_].damping_matrix();
  }
  Stiffest stiffest() const override { return {stiffness_.diagonal().maxCoeff(), 0}; }

 private:
  Vector3d force(const RelativeMotion& x) const { return -stiffness_ * x.d - damping_ * x.velocity; }
  Vector6d wrench(const RelativeMotion& x, const double*) const override {
    Vector6d W;
    W << force(x), Vector3d::Zero();
    return W;
  }
  void derivatives(const RelativeMotion&, const double*, Matrix6d& by_motion, Matrix6d& by_velocity) const override {
    by_motion.setZero();
    by_velocity.setZero();
    by_motion.topLeftCorner<3, 3>() = -stiffness_;
    by_velocity.topLeftCorner<3, 3>() = -damping_;
  }
  double stored(const RelativeMotion& x) const override { return 0.5 * x.d.dot(stiffness_ * x.d); }

  int index_;  // in MultibodyDef::bearings
  Matrix3d stiffness_, damping_;
};

}  // namespace sigmafmu
