// What acts on a mechanism from outside, as functions of the time s since the last communication point. Times from
// there, and not from the start, since differences of large times have few digits.
#pragma once

#include <Eigen/Core>

namespace sigmafmu {

// At one time: inputs u of the forces [N], [N m], and what drives prescribe of their coordinates [rad] or [m]. Elements
// that count the turns of an angle take the one nearest to `turned`: coordinates of all joints, less than half a turn
// away.
struct Inputs {
  Eigen::VectorXd u, x, xdot, xddot, turned;

  Inputs() = default;
  Inputs(int inputs, int drives, int coordinates) {
    u.setZero(inputs);
    turned.setZero(coordinates);
    for (Eigen::VectorXd* y : {&x, &xdot, &xddot}) y->setZero(drives);
  }
  bool acts_like(const Inputs& other) const {
    return u == other.u && (x.size() == 0 || (x == other.x && xdot == other.xdot && xddot == other.xddot));
  }
};

// u(s) = u_0 + u_1 s + u_2 s^2 / 2, and the same of x. Second order is as much as the integrator can make use of.
struct InputSignal {
  static constexpr int kMaxDerivative = 2;

  Eigen::VectorXd derivative[kMaxDerivative + 1];  // u_0, u_1, u_2
  Eigen::VectorXd drive[kMaxDerivative + 1];       // x_0, x_1, x_2

  InputSignal() = default;
  InputSignal(int inputs, int drives) {
    for (auto& d : derivative) d.setZero(inputs);
    for (auto& d : drive) d.setZero(drives);
  }
  void value(double s, const Eigen::VectorXd& turned, Inputs& at) const {
    if (turned.size() > 0) at.turned = turned;
    at.u = derivative[0] + s * derivative[1] + (0.5 * s * s) * derivative[2];
    drives(s, at);
  }
  void drives(double s, Inputs& at) const {
    if (drive[0].size() == 0) return;
    at.x = drive[0] + s * drive[1] + (0.5 * s * s) * drive[2];
    at.xdot = drive[1] + s * drive[2];
    at.xddot = drive[2];
  }
  // Counts from where `at` holds, from now on: inputs stay as they are there, drives go on.
  void continue_from(const Inputs& at) {
    derivative[0] = at.u;
    for (int k = 1; k <= kMaxDerivative; ++k) derivative[k].setZero();
    if (drive[0].size() == 0) return;
    drive[0] = at.x;
    drive[1] = at.xdot;
  }
};

}  // namespace sigmafmu
