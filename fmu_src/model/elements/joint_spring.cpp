#include "model/elements/joint_spring.h"

#include "model/definition.h"

namespace sigmafmu {

bool JointSpringDef::turns(const MultibodyDef& d) const { return d.joints[joint].turns(coordinate); }

std::string JointSpringDef::variable(const MultibodyDef& d, const std::string& word) const {
  return d.joints[joint].name + "." + d.joints[joint].word_on(coordinate, word);
}

}  // namespace sigmafmu
