// A motor or actuator: its input is a torque [N m] or force [N] along a joint's coordinate.
#pragma once

#include "multibody/forces/force.h"
#include "multibody/joint_coordinate.h"

namespace sigmafmu {

class Motor final : public Force {
 public:
  explicit Motor(const JointCoordinate& coordinate) : coordinate_(coordinate) {}

  int frame_count() const override { return 2; }
  int input_count() const override { return 1; }
  void add(const Kinematics& k, const double* u, const FrameForces& r) const override {
    if (*u != 0.0) coordinate_.add_force(k, *u, r);
  }
  void linearize(const Kinematics& k, const double* u, const FramePairs& K, const FramePairs&) const override {
    coordinate_.stiffness(k, *u, K);
  }

 private:
  JointCoordinate coordinate_;
};

}  // namespace sigmafmu
