// A tendon over coordinates x_i of joints: L = sum_i c_i x_i, N = k (L - L_0) + d L' + N_actuator. With b_i =
// d(x_i')/dv and z_i = d(x_i')/d(motion) of JointCoordinate, B = sum_i c_i b_i and Z = sum_i c_i z_i, its share of the
// residual is B^T N, and
//
//   K += B^T (k B + d Z) + d(B^T N)/d(motion) at constant N,   C += d B^T B.
//
// It stores k (L - L_0)^2 / 2; its power is -N L'. Angles are counted near Inputs::turned.
#pragma once

#include <vector>

#include "multibody/forces/force.h"
#include "multibody/joint_coordinate.h"

namespace sigmafmu {

class Tendon final : public Force {
 public:
  struct Term {
    JointCoordinate coordinate;
    int index = 0;  // of the coordinates of all joints
    double coefficient = 0;
  };
  // Frames 2 i and 2 i + 1 are those of term i.
  Tendon(std::vector<Term> terms, int index) : terms_(std::move(terms)), index_(index) {}

  int frame_count() const override { return 2 * static_cast<int>(terms_.size()); }
  const std::vector<ForcePort>& ports() const override;
  void set_values(const MultibodyDef& d) override;
  void add(const Kinematics& k, const Inputs& u, const FrameForces& r) const override;
  void linearize(const Kinematics& k, const Inputs& u, const FramePairs& K, const FramePairs& C) const override;
  double energy(const Kinematics& k, const Inputs& u) const override;
  double power(const Kinematics& k, const Inputs& u) const override { return -tension(k, u) * rate(k); }
  Stiffest stiffest() const override;

 private:
  double length(const Kinematics& k, const Inputs& u) const;
  double rate(const Kinematics& k) const;
  double tension(const Kinematics& k, const Inputs& u) const;

  std::vector<Term> terms_;
  int index_;  // in MultibodyDef::tendons
  double stiffness_ = 0, damping_ = 0, free_length_ = 0;
};

}  // namespace sigmafmu
