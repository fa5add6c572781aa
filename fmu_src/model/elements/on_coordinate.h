// What acts along a joint's coordinate: an angle or a displacement. Its variables belong to the joint.
#pragma once

#include <string>

#include "model/elements/references.h"
#include "model/parameter.h"

namespace sigmafmu {

struct OnCoordinate {
  int joint = 0;
  int coordinate = 0;  // of the joint

  bool turns(const MultibodyDef& d) const;
  // `joint.stiffness`, or `joint.displacementStiffness`, or with a number (JointDef::word_on).
  std::string variable(const MultibodyDef& d, const std::string& word) const;

  void check_values() const {}
  template <typename Use>
  void points(Use) const {}  // but for the joint's
  template <typename Archive, typename Any>
  static void visit(Archive& archive, Any& d) {
    archive.joint("joint", d.joint);
    archive.optional("coordinate", d.coordinate);
    archive.parameters(d);
  }
};

}  // namespace sigmafmu
