// A spring and damper along a line by tables: N = S(L) + D(L'), monotone cubics. Forces have continuous slopes; the
// stiffness has kinks at the points.
#pragma once

#include "multibody/forces/line_force.h"
#include "multibody/forces/monotone_cubic.h"

namespace sigmafmu {

class TableSpring final : public LineForce {
 public:
  explicit TableSpring(const TableSpringDef& d)
      : LineForce(d.point1, d.point2), spring_(table(d.length, d.force)), damper_(table(d.rate, d.rate_force)) {}

  Stiffest stiffest() const override { return {spring_.steepest(), 0}; }

 private:
  static MonotoneCubic table(const std::vector<double>& x, const std::vector<double>& y) {
    return x.empty() ? MonotoneCubic() : MonotoneCubic(x, y);
  }
  Tension tension(double length, double rate) const override {
    const auto s = spring_(length), d = damper_(rate);
    return {s.y + d.y, s.slope, d.slope};
  }
  double stored(double length) const override { return spring_(length).integral; }

  MonotoneCubic spring_, damper_;
};

}  // namespace sigmafmu
