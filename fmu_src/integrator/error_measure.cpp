#include "integrator/error_measure.h"

#include <algorithm>
#include <cmath>

namespace sigmafmu {

ErrorMeasure::ErrorMeasure(const System& system) : system_(system), per_size_(1 / system.size()) {
  modal_deflection_.setZero(system.modal_count());
  for (int f = 0; f < system.flexible_count(); ++f) {
    const FlexibleBody& body = system.flexible(f);
    auto largest = modal_deflection_.segment(system.modal_index(system.flexible_body(f)), body.modes());
    for (int node = 0; node < body.nodes(); ++node) {
      largest = largest.cwiseMax(body.shape(node).colwise().norm().transpose());
    }
  }
}

double ErrorMeasure::operator()(const VectorXd& motion, int& body) const {
  double largest = 0;  // squared; a NaN stays
  const auto add = [&](int i, double square) {
    if (square <= largest || std::isnan(largest)) return;
    largest = square;
    body = i;
  };
  const double* x = motion.data();
  for (int i = 0; i < system_.body_count(); ++i, x += kVelocitiesPerBody) {
    add(i, (x[0] * x[0] + x[1] * x[1] + x[2] * x[2]) * (per_size_ * per_size_));
    add(i, x[3] * x[3] + x[4] * x[4] + x[5] * x[5]);
  }
  for (int f = 0; f < system_.flexible_count(); ++f) {
    const int i = system_.flexible_body(f);
    for (int k = 0; k < system_.flexible(f).modes(); ++k) {
      const double deflection = *x++ * modal_deflection_[system_.modal_index(i) + k] * per_size_;
      add(i, deflection * deflection);
    }
  }
  return std::sqrt(largest);
}

}  // namespace sigmafmu
