#include "model/elements/joint_stop.h"

#include "model/definition.h"
#include "model/validation.h"

namespace sigmafmu {

void JointStopDef::check(const References& of) const {
  of.coordinate("A joint stop", joint, coordinate);
  if (!(lower > upper)) return;
  const MultibodyDef& d = of.definition();
  const char* unit = turns(d) ? " rad" : " m";
  validation::fail(variable(d, "lowerStop"), " is ", lower, unit, " and ", variable(d, "upperStop"), " ", upper, unit,
                   "; the lower one must not be above the upper one.");
}

}  // namespace sigmafmu
