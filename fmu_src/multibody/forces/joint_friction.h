// Smooth friction on a joint's coordinate, f = -F(c') tanh(c'/v_0) - d c', F = F_C + S exp(-(c'/v_S)^2):
//
//   f_c' = -F' tanh(c'/v_0) - F (1 - tanh^2)/v_0 - d,   F' = -2 c'/v_S^2 S exp(-(c'/v_S)^2).
//
// Its power f c' is never positive.
#pragma once

#include "multibody/forces/coordinate_force.h"

namespace sigmafmu {

class JointFriction final : public CoordinateForce {
 public:
  JointFriction(const JointCoordinate& coordinate, int c, int index) : CoordinateForce(coordinate, c, index) {}

  const std::vector<ForcePort>& ports() const override;
  void set_values(const MultibodyDef& d) override { d_ = d.joint_frictions[index()]; }

 private:
  Law law(double value, double rate) const override;

  JointFrictionDef d_;
};

}  // namespace sigmafmu
