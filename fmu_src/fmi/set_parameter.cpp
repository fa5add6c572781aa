#include "fmi/set_parameter.h"

#include <stdexcept>

#include "fmi/variables.h"
#include "model/validation.h"

namespace sigmafmu {

void set_parameter(Mechanism& mechanism, const std::string& name, double value) {
  validation::validate_structure(mechanism.multibody);
  for (const Port& v : make_all_variables(mechanism, System(mechanism.multibody)).list) {
    if (v.name != name) continue;
    if (v.causality != Causality::parameter) throw std::invalid_argument(name + " is no parameter");
    const std::string complaint = v.complaint(value);
    if (!complaint.empty()) throw std::invalid_argument(complaint);
    v.set_value(mechanism, value);
    return;
  }
  throw std::invalid_argument(mechanism.name + " has no variable " + name);
}

}  // namespace sigmafmu
