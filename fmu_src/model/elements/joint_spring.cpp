#include "model/elements/joint_spring.h"

#include <cctype>

#include "model/definition.h"

namespace sigmafmu {

bool JointSpringDef::turns(const MultibodyDef& d) const { return d.joints[joint].turns(coordinate); }

std::string JointSpringDef::variable(const MultibodyDef& d, const std::string& word) const {
  if (coordinate == 0) return d.joints[joint].name + "." + word;
  std::string second = "displacement" + word;
  second[second.size() - word.size()] = static_cast<char>(std::toupper(static_cast<unsigned char>(word[0])));
  return d.joints[joint].name + "." + second;
}

}  // namespace sigmafmu
