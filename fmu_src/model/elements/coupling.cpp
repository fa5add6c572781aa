#include "model/elements/coupling.h"

#include <cmath>

#include "model/definition.h"
#include "model/validation.h"

namespace sigmafmu {

using validation::fail;

void CouplingDef::check(const MultibodyDef& d) const {
  const References of(d);
  if (terms.empty()) fail(name, " couples no coordinates; there must be at least one.");
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const Term& term = terms[i];
    of.coordinate(name.c_str(), term.joint, term.coordinate);
    const std::string& joint = d.joints[term.joint].name;
    bool moves = false;
    for (std::size_t k = 0; k < term.polynomial.size(); ++k) {
      if (!std::isfinite(term.polynomial[k])) {
        fail("Coefficient ", k, " of ", joint, " in ", name, " is ", term.polynomial[k], "; it must be finite.");
      }
      moves = moves || (k > 0 && term.polynomial[k] != 0);
    }
    if (!moves) fail(name, " does not depend on ", joint, "; a coefficient from the second on must not be zero.");
    for (std::size_t k = 0; k < i; ++k) {
      if (terms[k].joint != term.joint || terms[k].coordinate != term.coordinate) continue;
      fail(name, " has two terms of the same coordinate of ", joint, "; one is allowed.");
    }
  }
  if (std::isinf(offset)) fail("The offset of ", name, " is ", offset, "; it must be finite.");
}

CouplingDef gear(std::string name, int first, int second, double ratio) {
  return {std::move(name), {{second, 0, {0, 1}}, {first, 0, {0, -ratio}}}, CouplingDef::kNotSet};
}

CouplingDef rack_and_pinion(std::string name, int pinion, int rack, double radius) {
  return gear(std::move(name), pinion, rack, radius);
}

CouplingDef differential(std::string name, int carrier, int left, int right) {
  return {std::move(name), {{carrier, 0, {0, 1}}, {left, 0, {0, -0.5}}, {right, 0, {0, -0.5}}}, CouplingDef::kNotSet};
}

CouplingDef mimic(std::string name, int follower, int leader, std::vector<double> polynomial) {
  for (double& c : polynomial) c = -c;
  return {std::move(name), {{follower, 0, {0, 1}}, {leader, 0, std::move(polynomial)}}, 0.0};
}

}  // namespace sigmafmu
