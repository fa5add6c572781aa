#include "multibody/forces/bearing.h"

namespace sigmafmu {

const std::vector<ForcePort>& Bearing::ports() const {
  static const std::vector<ForcePort> table = {
      {"displacement", 3, "Displacement", "Displacement of the second frame, in the axes of the first",
       [](const Force& f, const Kinematics& k, const Inputs&, double* x) {
         Vector3d::Map(x) = static_cast<const Bearing&>(f).relative(k).d;
       }},
      {"force", 3, "Force", "Force on the second body, in the axes of the first frame",
       [](const Force& f, const Kinematics& k, const Inputs&, double* x) {
         const auto& self = static_cast<const Bearing&>(f);
         Vector3d::Map(x) = self.force(self.relative(k));
       }},
      {"energy", 0, "Energy", "Elastic energy, of the symmetric part of the stiffness", energy_output},
      {"power", 0, "Power", "Power of the element on its bodies", power_output},
  };
  return table;
}

}  // namespace sigmafmu
