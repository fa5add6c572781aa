// A motor or actuator: its input is a torque [N m] or force [N] along a joint's coordinate.
#pragma once

#include "multibody/forces/force.h"
#include "multibody/joint_coordinate.h"

namespace sigmafmu {

class Motor final : public Force {
 public:
  explicit Motor(const JointCoordinate& coordinate) : coordinate_(coordinate) {}

  int frame_count() const override { return 2; }
  const std::vector<ForcePort>& ports() const override {
    static const std::vector<ForcePort> torque = {
        {"motorTorque", 0, "Torque", "Torque about the joint axis on the second body", nullptr}};
    static const std::vector<ForcePort> force = {
        {"actuatorForce", 0, "Force", "Force along the joint axis on the second body", nullptr}};
    return coordinate_.is_angle() ? torque : force;
  }
  void add(const Kinematics& k, const Inputs& u, const FrameForces& r) const override {
    if (const double f = *own(u); f != 0.0) coordinate_.add_force(k, f, r);
  }
  void linearize(const Kinematics& k, const Inputs& u, const FramePairs& K, const FramePairs&) const override {
    coordinate_.stiffness(k, *own(u), K);
  }

 private:
  JointCoordinate coordinate_;
};

}  // namespace sigmafmu
