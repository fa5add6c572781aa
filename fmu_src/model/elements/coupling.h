// An equation between coordinates of any joints: sum_i p_i(x_i) = offset, with polynomials p_i of angles [rad], which
// count their turns, and displacements [m].
//
// Gears, racks and differentials are those of first degree; a mimic joint (URDF, MJCF) is x_1 - p(x_2) = 0. Where no
// offset is set, the sum keeps what it is at the start: wheels mesh as they are assembled.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "model/elements/references.h"

namespace sigmafmu {

struct CouplingDef {
  // What its parameters in the FMU are called, fixed while it runs: the sum keeps what it is at the start, and a ratio
  // that changed would move what is coupled.
  enum class Type {
    sum,              // none
    gear,             // ratio:      p_1 = ratio x_1,  p_2 = -x_2
    rack_and_pinion,  // radius:     the same
    mimic,            // polynomial: p_1 = -x_1,  p_2 = polynomial
  };
  static constexpr double kNotSet = std::numeric_limits<double>::quiet_NaN();

  struct Term {
    int joint = 0;
    int coordinate = 0;              // of the joint
    std::vector<double> polynomial;  // p(x) = c_0 + c_1 x + c_2 x^2 + ...
  };
  std::string name;
  std::vector<Term> terms;
  double offset = kNotSet;
  Type type = Type::sum;

  void check(const MultibodyDef& definition) const;
};

// In the order of the enumeration.
const std::vector<std::string>& coupling_type_names();

// Coordinate 0 of both joints: the rate of the second is `ratio` times that of the first, negative where they turn the
// other way.
CouplingDef gear(std::string name, int first, int second, double ratio);
// The rack moves by `radius` [m] for each rad of the pinion.
CouplingDef rack_and_pinion(std::string name, int pinion, int rack, double radius);
// The rate of the carrier is the mean of those of both sides.
CouplingDef differential(std::string name, int carrier, int left, int right);
// follower = polynomial(leader).
CouplingDef mimic(std::string name, int follower, int leader, std::vector<double> polynomial);

}  // namespace sigmafmu
