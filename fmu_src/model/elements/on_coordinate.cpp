#include "model/elements/on_coordinate.h"

#include "model/definition.h"

namespace sigmafmu {

bool OnCoordinate::turns(const MultibodyDef& d) const { return d.joints[joint].turns(coordinate); }

std::string OnCoordinate::variable(const MultibodyDef& d, const std::string& word) const {
  return d.joints[joint].name + "." + d.joints[joint].word_on(coordinate, word);
}

}  // namespace sigmafmu
