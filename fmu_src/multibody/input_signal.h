// Inputs as functions of the time s since the last communication point: u(s) = u_0 + u_1 s + u_2 s^2 / 2. Times from
// there, and not from the start, since differences of large times have few digits.
//
// Second order is as much as the integrator can make use of.
#pragma once

#include <Eigen/Core>

namespace sigmafmu {

struct InputSignal {
  static constexpr int kMaxDerivative = 2;

  Eigen::VectorXd derivative[kMaxDerivative + 1];  // u_0, u_1, u_2: force [N], torque [N m] and per s, s2

  InputSignal() = default;
  explicit InputSignal(int size) {
    for (auto& d : derivative) d.setZero(size);
  }
  void value(double s, Eigen::VectorXd& u) const {
    u = derivative[0] + s * derivative[1] + (0.5 * s * s) * derivative[2];
  }
};

}  // namespace sigmafmu
