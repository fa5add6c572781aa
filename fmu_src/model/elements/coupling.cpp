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
  const auto is_minus_x = [](const Term& term) { return term.polynomial == std::vector<double>{0, -1}; };
  if (type == Type::mimic && (terms.size() != 2 || !is_minus_x(terms[0]))) {
    fail(name, " is of type mimic; it must have two terms, the first one with the polynomial 0, -1.");
  }
  if ((type == Type::gear || type == Type::rack_and_pinion) &&
      (terms.size() != 2 || terms[0].polynomial.size() != 2 || !is_minus_x(terms[1]))) {
    fail(name, " is of type ", coupling_type_names()[static_cast<std::size_t>(type)],
         "; it must have two terms of first degree, the second one with the polynomial 0, -1.");
  }
  if (std::isinf(offset)) fail("The offset of ", name, " is ", offset, "; it must be finite.");
}

const std::vector<std::string>& coupling_type_names() {
  static const std::vector<std::string> names = {"sum", "gear", "rack_and_pinion", "mimic"};
  return names;
}

CouplingDef gear(std::string name, int first, int second, double ratio) {
  return {
      std::move(name), {{first, 0, {0, ratio}}, {second, 0, {0, -1}}}, CouplingDef::kNotSet, CouplingDef::Type::gear};
}

CouplingDef rack_and_pinion(std::string name, int pinion, int rack, double radius) {
  CouplingDef result = gear(std::move(name), pinion, rack, radius);
  result.type = CouplingDef::Type::rack_and_pinion;
  return result;
}

CouplingDef differential(std::string name, int carrier, int left, int right) {
  return {std::move(name), {{carrier, 0, {0, 1}}, {left, 0, {0, -0.5}}, {right, 0, {0, -0.5}}}};
}

CouplingDef mimic(std::string name, int follower, int leader, std::vector<double> polynomial) {
  return {std::move(name), {{follower, 0, {0, -1}}, {leader, 0, std::move(polynomial)}}, 0.0, CouplingDef::Type::mimic};
}

}  // namespace sigmafmu
