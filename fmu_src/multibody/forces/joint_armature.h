// An inertia a that moves with a joint's coordinate c: with B = d(c')/dv,
//
//   T = a c'^2 / 2,   M += a B^T B,   r += B^T a c'',   c'' = B vdot + Z v,
//   K += B^T a d(c'')/d(motion) + d(B^T s)/d(motion) at s = a c'',   C += B^T a d(c'')/dv.
//
// It takes part in M, so the System asks for all this beside the forces; as a force it has none.
#pragma once

#include "multibody/forces/force.h"
#include "multibody/joint_coordinate.h"

namespace sigmafmu {

class JointArmature final : public Force {
 public:
  JointArmature(const JointCoordinate& coordinate, int index) : coordinate_(coordinate), index_(index) {}

  int frame_count() const override { return 2; }
  const std::vector<ForcePort>& ports() const override {
    static const std::vector<ForcePort> none;
    return none;
  }
  void set_values(const MultibodyDef& d) override { inertia_ = d.joint_armatures[index_].armature; }
  void add(const Kinematics&, const Inputs&, const FrameForces&) const override {}
  void linearize(const Kinematics&, const Inputs&, const FramePairs&, const FramePairs&) const override {}

  // Accelerations of the two frames, as their velocities are.
  struct Accelerations {
    Vector6d vdot1, vdot2;
  };
  void add_mass(const Kinematics& k, const FramePairs& M) const;
  void add_inertial_force(const Kinematics& k, const Accelerations& a, const FrameForces& r) const;
  void linearize(const Kinematics& k, const Accelerations& a, const FramePairs& K, const FramePairs& C) const;
  double kinetic_energy(const Kinematics& k) const;

 private:
  JointCoordinate coordinate_;
  int index_;  // in MultibodyDef::joint_armatures
  double inertia_ = 0;
};

}  // namespace sigmafmu
