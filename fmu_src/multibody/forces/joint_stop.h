// Stops of a joint's coordinate. At a depth p > 0 the force away from the stop is
//
//   f = k s(p) g(z),   g = 1 + z/sqrt(1 + z^2),   z = d p',   s = p^2/(2 w) for p < w, else p - w/2,
//   f_p = k s' g,   f_p' = k s d (1 + z^2)^(-3/2),
//
// of which k s has the energy k p^3/(6 w), else k ((p - w/2)^2/2 + w^2/24), and the rest takes away k s (g - 1) p'.
#pragma once

#include "multibody/forces/coordinate_force.h"

namespace sigmafmu {

class JointStop final : public CoordinateForce {
 public:
  JointStop(const JointCoordinate& coordinate, int c, int index) : CoordinateForce(coordinate, c, index) {}

  const std::vector<ForcePort>& ports() const override;
  void set_values(const MultibodyDef& d) override { d_ = d.joint_stops[index()]; }
  Stiffest stiffest() const override { return stiffest_of(d_.stiffness); }

 private:
  Law law(double value, double rate) const override;
  double energy_at(double value) const override;
  Law push(double depth, double rate) const;

  JointStopDef d_;
};

}  // namespace sigmafmu
