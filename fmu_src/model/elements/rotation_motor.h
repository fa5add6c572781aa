// A motor in a joint that lets its bodies turn any way: a torque [N m] on the second body and its opposite on the first
// one, in the axes of the joint's first frame. Its variables belong to the joint.
#pragma once

#include <string>
#include <vector>

#include "model/elements/references.h"
#include "model/parameter.h"

namespace sigmafmu {

struct RotationMotorDef {
  static constexpr const char *kKind = "rotation motor", *kType = nullptr;

  int joint = 0;

  static const std::vector<Parameter<RotationMotorDef>>& parameters() {
    static const std::vector<Parameter<RotationMotorDef>> none;
    return none;
  }
  std::string variable(const MultibodyDef& d, const std::string& word) const;
  void check(const References& of) const;
  void check_values() const {}
  template <typename Use>
  void points(Use) const {}  // but for the joint's
  template <typename Archive, typename Any>
  static void visit(Archive& archive, Any& d) {
    archive.joint("joint", d.joint);
  }
};

}  // namespace sigmafmu
