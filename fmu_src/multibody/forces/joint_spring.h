// Spring and damper on a joint's coordinate: f = -k (c - c_rest) - d c'.
#pragma once

#include "multibody/forces/coordinate_force.h"

namespace sigmafmu {

class JointSpring final : public CoordinateForce {
 public:
  JointSpring(const JointCoordinate& coordinate, int c, int index) : CoordinateForce(coordinate, c, index) {}

  const std::vector<ForcePort>& ports() const override;
  void set_values(const MultibodyDef& d) override { d_ = d.joint_springs[index()]; }
  Stiffest stiffest() const override { return stiffest_of(d_.stiffness); }

 private:
  Law law(double value, double rate) const override {
    return {-d_.stiffness * (value - d_.rest) - d_.damping * rate, -d_.stiffness, -d_.damping};
  }
  double energy_at(double value) const override { return 0.5 * d_.stiffness * (value - d_.rest) * (value - d_.rest); }

  JointSpringDef d_;
};

}  // namespace sigmafmu
