// How large a motion is in comparison with the mechanism: the measure of every estimate of a step's error.
#pragma once

#include "multibody/system.h"

namespace sigmafmu {

class ErrorMeasure {
 public:
  explicit ErrorMeasure(const System& system);

  // Of a small motion (per body translation [m] and rotation [rad], then modal coordinates, laid out as v): the largest
  // of all translations and deflections over the size of the mechanism, and of all rotations.
  double operator()(const VectorXd& motion) const;
  // Where that is.
  int worst_body(const VectorXd& motion) const;
  // The modal coordinates of a flexible body that would deflect it by the size of the mechanism.
  double modal_size(int flexible) const { return modal_size_[flexible]; }

 private:
  template <typename Use>
  void for_each_part(const VectorXd& motion, Use use) const;

  const System& system_;
  double per_size_;            // 1 over the size of the mechanism [1/m]
  VectorXd modal_deflection_;  // largest deflection of a node by a modal coordinate of 1 [m]
  std::vector<double> modal_size_;
};

}  // namespace sigmafmu
