#include "model/elements/joint_armature.h"

#include "model/definition.h"
#include "model/validation.h"

namespace sigmafmu {

void JointArmatureDef::check(const References& of) const {
  of.coordinate("An armature", joint, coordinate);
  const JointDef& j = of.definition().joints[joint];
  if (j.frame1.node == kFloatingFrame && j.frame2.node == kFloatingFrame) return;
  validation::fail(j.name, " has an armature and is at a node of a flexible body; it must be at the body's frame.");
}

}  // namespace sigmafmu
