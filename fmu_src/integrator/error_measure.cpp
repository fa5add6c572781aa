#include "integrator/error_measure.h"

#include <algorithm>
#include <cmath>

namespace sigmafmu {

// Calls use(body, square of the measure) for every translation, rotation and deflection.
template <typename Use>
void ErrorMeasure::for_each_part(const VectorXd& motion, Use use) const {
  const double* x = motion.data();
  for (int i = 0; i < system_.body_count(); ++i, x += kVelocitiesPerBody) {
    use(i, (x[0] * x[0] + x[1] * x[1] + x[2] * x[2]) * (per_size_ * per_size_));
    use(i, x[3] * x[3] + x[4] * x[4] + x[5] * x[5]);
  }
  for (int f = 0; f < system_.flexible_count(); ++f) {
    const int i = system_.flexible_body(f), first = system_.modal_index(i);
    for (int k = 0; k < system_.flexible(f).modes(); ++k) {
      const double deflection = *x++ * modal_deflection_[first + k] * per_size_;
      use(i, deflection * deflection);
    }
  }
}

ErrorMeasure::ErrorMeasure(const System& system) : system_(system), per_size_(1 / system.size()) {
  modal_deflection_.setZero(system.modal_count());
  for (int f = 0; f < system.flexible_count(); ++f) {
    const FlexibleBody& body = system.flexible(f);
    auto largest = modal_deflection_.segment(system.modal_index(system.flexible_body(f)), body.modes());
    for (int node = 0; node < body.nodes(); ++node) {
      largest = largest.cwiseMax(body.shape(node).colwise().norm().transpose());
    }
    modal_size_.push_back(system.size() / largest.maxCoeff());
  }
}

double ErrorMeasure::operator()(const VectorXd& motion) const {
  double largest = 0;
  for_each_part(motion,
                [&](int, double square) { largest = std::isnan(largest) || largest > square ? largest : square; });
  return std::sqrt(largest);
}

int ErrorMeasure::worst_body(const VectorXd& motion) const {
  int body = -1;
  double largest = 0;
  for_each_part(motion, [&](int i, double square) {
    if (square <= largest || std::isnan(largest)) return;
    largest = square;
    body = i;
  });
  return body;
}

}  // namespace sigmafmu
