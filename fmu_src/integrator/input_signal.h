// Inputs as functions of time: u(t) = u_0 + u_1 (t - t_0) + u_2 (t - t_0)^2 / 2.
//
// Second order is as much as the integrator can make use of.
#pragma once

#include <Eigen/Core>

namespace sigmafmu {

struct InputSignal {
  static constexpr int kMaxDerivative = 2;

  double t0 = 0;                                   // [s]
  Eigen::VectorXd derivative[kMaxDerivative + 1];  // u_0, u_1, u_2: force [N], torque [N m] and per s, s2

  InputSignal() = default;
  explicit InputSignal(int size) {
    for (auto& d : derivative) d.setZero(size);
  }
  void value(double t, Eigen::VectorXd& u) const {
    const double s = t - t0;
    u = derivative[0] + s * derivative[1] + (0.5 * s * s) * derivative[2];
  }
};

}  // namespace sigmafmu
