// Spring and damper on a joint's coordinate c: f = -k (c - c_rest) - d c' acts along it. With B = d(c')/dv and Z =
// d(c')/d(motion), its share of the residual is -B^T f, and
//
//   K += B^T (k B + d Z) - d(B^T f)/d(motion) at constant f,   C += d B^T B.
#pragma once

#include "multibody/forces/force.h"
#include "multibody/joint_coordinate.h"

namespace sigmafmu {

class JointSpring final : public Force {
 public:
  // `index`: in MultibodyDef::joint_springs; `c`: which of the coordinates of all joints.
  JointSpring(const JointCoordinate& coordinate, int c, int index) : coordinate_(coordinate), c_(c), index_(index) {}

  int frame_count() const override { return 2; }
  const std::vector<ForcePort>& ports() const override;
  void set_values(const MultibodyDef& definition) override;
  void add(const Kinematics& k, const Inputs& u, const FrameForces& r) const override;
  void linearize(const Kinematics& k, const Inputs& u, const FramePairs& K, const FramePairs& C) const override;
  double energy(const Kinematics& k, const Inputs& u) const override;
  Stiffest stiffest() const override {
    return coordinate_.is_angle() ? Stiffest{0, stiffness_} : Stiffest{stiffness_, 0};
  }

  // On the second body [N m] or [N].
  double force(const Kinematics& k, const Inputs& u) const;

 private:
  double extension(const Kinematics& k, const Inputs& u) const;

  JointCoordinate coordinate_;
  int c_, index_;
  double stiffness_ = 0, damping_ = 0, rest_ = 0;
};

}  // namespace sigmafmu
