#include "model/elements/tendon.h"

#include <cmath>

#include "model/definition.h"
#include "model/validation.h"

namespace sigmafmu {

void TendonDef::check(const References& of) const {
  if (terms.empty()) validation::fail(name, " runs over no coordinates; there must be at least one.");
  for (const Term& term : terms) of.coordinate(name.c_str(), term.joint, term.coordinate);
  for (std::size_t i = 0; i < terms.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (terms[k].joint != terms[i].joint || terms[k].coordinate != terms[i].coordinate) continue;
      validation::fail(name, " has two terms of the same coordinate of ", of.definition().joints[terms[i].joint].name,
                       "; one is allowed.");
    }
  }
}

void TendonDef::check_values() const {
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const double c = terms[i].coefficient;
    if (std::isfinite(c) && c != 0) continue;
    validation::fail("Coefficient ", i + 1, " of ", name, " is ", c, "; it must be finite, and not 0.");
  }
}

}  // namespace sigmafmu
