#include "fmi/variables.h"

namespace sigmafmu {

const std::vector<Unit>& units() {
  constexpr double kDegree = 57.29577951308232, kRpm = 9.549296585513721;
  static const std::vector<Unit> table = {
      // name, kg, m, s, rad
      {"1", 0, 0, 0, 0, {}},
      {"s", 0, 0, 1, 0, {{"ms", 1e3}, {"us", 1e6}}},
      {"kg", 1, 0, 0, 0, {}},
      {"kg.m2", 1, 2, 0, 0, {}},
      {"m", 0, 1, 0, 0, {{"mm", 1e3}, {"um", 1e6}}},
      {"m/s", 0, 1, -1, 0, {{"mm/s", 1e3}}},
      {"m/s2", 0, 1, -2, 0, {}},
      {"rad", 0, 0, 0, 1, {{"deg", kDegree}}},
      {"rad/s", 0, 0, -1, 1, {{"rpm", kRpm}, {"deg/s", kDegree}}},
      {"rad/s2", 0, 0, -2, 1, {{"deg/s2", kDegree}}},
      {"N", 1, 1, -2, 0, {{"kN", 1e-3}}},
      {"N.m", 1, 2, -2, 0, {{"N.mm", 1e3}}},
      {"N/m", 1, 0, -2, 0, {{"N/mm", 1e-3}}},
      {"N.s/m", 1, 0, -1, 0, {}},
      {"J", 1, 2, -2, 0, {{"mJ", 1e3}}},
  };
  return table;
}

const std::vector<Enumeration>& enumerations() {
  static const std::vector<Enumeration> table = {
      {"Formulation",
       "Constraints that a step satisfies",
       {{"index3", "positions"},
        {"index2", "velocities; positions drift slowly"},
        {"stabilizedIndex2", "positions and velocities"}}},
      {"Corrector",
       "Form of the corrector",
       {{"residual", "the discrete equations solved exactly for every sigma; independent of the predictor"},
        {"incremental", "the increments of Algorithms 1 to 3 as printed, for reproducing the paper"}}},
      {"Jacobian",
       "Rotational part of the iteration matrix",
       {{"full", "exact derivative of the velocity with respect to the motion"},
        {"tangentFree", "no tangent operator"}}},
      {"Newton",
       "When the iteration matrix is made anew",
       {{"full", "in every step, and in every iteration that changes it"},
        {"modified", "when convergence becomes slow"}}},
  };
  return table;
}

}  // namespace sigmafmu
