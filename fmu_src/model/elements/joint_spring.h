// Spring and damper on a joint's coordinate c: f = -k (c - c_rest) - d c' on the second body, a torque [N m] about the
// joint's axis or a force [N] along it. Angles count turns. Its variables belong to the joint.
#pragma once

#include <string>

#include "model/elements/references.h"
#include "model/parameter.h"

namespace sigmafmu {

struct JointSpringDef {
  static constexpr const char *kKind = "joint spring", *kType = nullptr;

  int joint = 0;
  int coordinate = 0;  // of the joint
  double stiffness = 0;
  double damping = 0;
  double rest = 0;  // where the spring has no force [rad] or [m]

  static const std::vector<Parameter<JointSpringDef>>& parameters() {
    using Def = JointSpringDef;
    static const std::vector<Parameter<Def>> table = {
        {"stiffness", "Stiffness", "Stiffness of the joint's spring", 0, [](Def& d) { return &d.stiffness; },
         "TorsionalStiffness"},
        {"damping", "Damping", "Damping in the joint", 0, [](Def& d) { return &d.damping; }, "TorsionalDamping"},
        {"rest", "Displacement", "Where the joint's spring has no force", 0, [](Def& d) { return &d.rest; }, "Angle"},
    };
    return table;
  }
  bool turns(const MultibodyDef& d) const;
  // `joint.stiffness`, or `joint.displacementStiffness`, or with a number (JointDef::word_on).
  std::string variable(const MultibodyDef& d, const std::string& word) const;
  void check(const References& of) const { of.coordinate("A joint spring", joint, coordinate); }
  template <typename Archive, typename Any>
  static void visit(Archive& archive, Any& d) {
    archive.joint("joint", d.joint);
    archive.optional("coordinate", d.coordinate);
    archive.parameters(d);
  }
};

}  // namespace sigmafmu
