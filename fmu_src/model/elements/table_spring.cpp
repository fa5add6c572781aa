#include "model/elements/table_spring.h"

#include <cmath>

#include "model/validation.h"

namespace sigmafmu {
namespace {

void check_table(const std::string& x_name, const std::vector<double>& x, const std::string& y_name,
                 const std::vector<double>& y) {
  using validation::fail;
  if (x.size() != y.size()) {
    fail(x_name, " has ", x.size(), " values and ", y_name, " has ", y.size(), "; they must have the same number.");
  }
  if (x.size() == 1) fail(x_name, " has 1 value; a table must have at least 2, or none.");
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (const auto& [name, values] : {std::pair(x_name, &x), std::pair(y_name, &y)}) {
      if (!std::isfinite((*values)[i])) fail(name, "[", i + 1, "] is ", (*values)[i], "; it must be finite.");
    }
    if (i > 0 && x[i] <= x[i - 1]) {
      fail(x_name, "[", i + 1, "] is ", x[i], " after ", x[i - 1], "; the values must increase.");
    }
  }
}

}  // namespace

void TableSpringDef::check_values() const {
  check_points();
  check_table(name + ".length", length, name + ".force", force);
  check_table(name + ".rate", rate, name + ".rateForce", rate_force);
  if (length.empty() && rate.empty()) validation::fail(name, " has no table; it must have one of length or of rate.");
}

}  // namespace sigmafmu
