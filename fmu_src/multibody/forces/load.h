// A constant force f at the origin of a body's frame and a constant torque t, both in W: on (v_WB, w_WB_B) act
// (f, R^T t).
#pragma once

#include "lie/isotropic_operator.h"
#include "multibody/forces/force.h"

namespace sigmafmu {

class Load final : public Force {
 public:
  explicit Load(int index) : index_(index) {}

  int frame_count() const override { return 1; }
  const std::vector<ForcePort>& ports() const override {
    static const std::vector<ForcePort> none;
    return none;
  }
  void set_values(const MultibodyDef& d) override {
    force_ = d.loads[index_].force;
    torque_ = d.loads[index_].torque;
  }
  void add(const Kinematics& k, const Inputs&, const FrameForces& r) const override {
    r[0].head<3>() -= force_;
    r[0].tail<3>() -= k[0].R_WB.transpose() * torque_;
  }
  // d(R^T t)/dphi = hat(R^T t).
  void linearize(const Kinematics& k, const Inputs&, const FramePairs& K, const FramePairs&) const override {
    K(0, 0).bottomRightCorner<3, 3>() -= lie::hat(k[0].R_WB.transpose() * torque_);
  }

 private:
  int index_;  // in MultibodyDef::loads
  Vector3d force_, torque_;
};

}  // namespace sigmafmu
