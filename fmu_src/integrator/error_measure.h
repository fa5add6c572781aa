// How large a motion is in comparison with the mechanism: the measure of every estimate of a step's error.
#pragma once

#include "multibody/system.h"

namespace sigmafmu {

class ErrorMeasure {
 public:
  explicit ErrorMeasure(const System& system);

  // Of a small motion (per body translation [m] and rotation [rad], then modal coordinates, laid out as v): the largest
  // of all translations and deflections over the size of the mechanism, and of all rotations. `body` is where.
  double operator()(const VectorXd& motion, int& body) const;

 private:
  const System& system_;
  double per_size_;            // 1 over the size of the mechanism [1/m]
  VectorXd modal_deflection_;  // largest deflection of a node by a modal coordinate of 1 [m]
};

}  // namespace sigmafmu
