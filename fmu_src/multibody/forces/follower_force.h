// A force f at the point s of a body and a torque t, both in the axes B of the body: on (v_WB, w_WB_B) act
// (R f, s x f + t), with d(R f)/dphi = -R hat(f). f and t are sums of constants and inputs.
#pragma once

#include "lie/isotropic_operator.h"
#include "multibody/forces/force.h"

namespace sigmafmu {

class FollowerForce final : public Force {
 public:
  FollowerForce(const FollowerForceDef& d, int index) : index_(index), point_(d.point) {}

  int frame_count() const override { return 1; }
  const std::vector<ForcePort>& ports() const override {
    static const std::vector<ForcePort> table = {
        {"position", 3, "Displacement", "Point of the force, in W",
         [](const Force& f, const Kinematics& k, const Inputs&, double* x) {
           Vector3d::Map(x) = k[0].p_WB + k[0].R_WB * static_cast<const FollowerForce&>(f).point_;
         }},
        {"power", 0, "Power", "Power of the element on its bodies", power_output, true},
        {"actuatorForce", 3, "Force", "Force at the point beside the constant one, in body axes", nullptr},
        {"actuatorTorque", 3, "Torque", "Torque beside the constant one, in body axes", nullptr},
    };
    return table;
  }
  void set_values(const MultibodyDef& d) override {
    force_ = d.follower_forces[index_].force;
    torque_ = d.follower_forces[index_].torque;
  }
  void add(const Kinematics& k, const Inputs& u, const FrameForces& r) const override {
    const Vector3d f = force(u);
    r[0].head<3>() -= k[0].R_WB * f;
    r[0].tail<3>() -= point_.cross(f) + torque_ + Vector3d::Map(own(u) + 3);
  }
  void linearize(const Kinematics& k, const Inputs& u, const FramePairs& K, const FramePairs&) const override {
    K(0, 0).topRightCorner<3, 3>() += k[0].R_WB * lie::hat(force(u));
  }

 private:
  Vector3d force(const Inputs& u) const { return force_ + Vector3d::Map(own(u)); }

  int index_;  // in MultibodyDef::follower_forces
  Vector3d point_, force_, torque_;
};

}  // namespace sigmafmu
