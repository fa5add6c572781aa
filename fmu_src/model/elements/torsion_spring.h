// About the z axes of two frames: the torque -k (angle - rest) - d angle' + T_actuator on frame2. The angle is the
// twist from frame1 to frame2, in (-pi, pi]; the axes may be inclined (multibody/forces/torsion_spring.h).
#pragma once

#include "model/elements/two_frames.h"
#include "model/parameter.h"

namespace sigmafmu {

struct TorsionSpringDef : TwoFrames {
  static constexpr const char *kKind = "torsion spring", *kType = "torsion_spring";

  double stiffness = 0;  // k [N m/rad]
  double damping = 0;    // d [N m s/rad]
  double rest = 0;       // [rad]

  static const std::vector<Parameter<TorsionSpringDef>>& parameters() {
    using Def = TorsionSpringDef;
    static const std::vector<Parameter<Def>> table = {
        {"stiffness", "TorsionalStiffness", "Stiffness about the axis", 0, [](Def& d) { return &d.stiffness; }},
        {"damping", "TorsionalDamping", "Damping about the axis", 0, [](Def& d) { return &d.damping; }},
        {"rest", "Angle", "Angle at which the spring has no torque", 0, [](Def& d) { return &d.rest; }},
    };
    return table;
  }
  void check_values() const { check_frames(); }
  template <typename Archive, typename Any>
  static void visit(Archive& archive, Any& d) {
    visit_frames(archive, d);
    archive.parameters(d);
  }
};

}  // namespace sigmafmu
