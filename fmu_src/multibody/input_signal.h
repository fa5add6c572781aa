// What acts on a mechanism from outside, as functions of the time s since the last communication point. Times from
// there, and not from the start, since differences of large times have few digits.
#pragma once

#include <Eigen/Core>

namespace sigmafmu {

// At one time: inputs u of the forces [N], [N m], and what is prescribed [rad] or [m]: by drives, by couplings (which
// have a constant), by motions of frames (six numbers each). Elements that count the turns of an angle take the one
// nearest to `turned`: coordinates of all joints, less than half a turn away.
struct Inputs {
  Eigen::VectorXd u, x, xdot, xddot, turned;
  double time = 0;  // since the start [s], for tables

  Inputs() = default;
  Inputs(int inputs, int prescribed, int coordinates) {
    u.setZero(inputs);
    turned.setZero(coordinates);
    for (Eigen::VectorXd* y : {&x, &xdot, &xddot}) y->setZero(prescribed);
  }
  bool prescribes_like(const Inputs& other) const {
    return x.size() == 0 || (x == other.x && xdot == other.xdot && xddot == other.xddot);
  }
  bool acts_like(const Inputs& other) const { return u == other.u && prescribes_like(other); }
};

// u(s) = u_0 + u_1 s + u_2 s^2 / 2: second order is as much as the integrator can make use of. x goes on to the fourth,
// which are the two derivatives of a prescribed acceleration.
struct InputSignal {
  static constexpr int kMaxDerivative = 2;
  static constexpr int kMaxDriveDerivative = 4;

  Eigen::VectorXd derivative[kMaxDerivative + 1];  // u_0, u_1, u_2
  Eigen::VectorXd drive[kMaxDriveDerivative + 1];  // x_0, x_1, ...
  double start = 0;                                // the time of s = 0 since the start [s]

  InputSignal() = default;
  InputSignal(int inputs, int prescribed) {
    for (auto& d : derivative) d.setZero(inputs);
    for (auto& d : drive) d.setZero(prescribed);
  }
  void value(double s, const Eigen::VectorXd& turned, Inputs& at) const {
    at.u = derivative[0] + s * derivative[1] + (0.5 * s * s) * derivative[2];
    drives(s, turned, at);
  }
  void drives(double s, const Eigen::VectorXd& turned, Inputs& at) const {
    if (turned.size() > 0) at.turned = turned;
    at.time = start + s;
    if (drive[0].size() == 0) return;
    const double s2 = 0.5 * s * s, s3 = s2 * s / 3, s4 = s3 * s / 4;
    at.x = drive[0] + s * drive[1] + s2 * drive[2] + s3 * drive[3] + s4 * drive[4];
    at.xdot = drive[1] + s * drive[2] + s2 * drive[3] + s3 * drive[4];
    at.xddot = drive[2] + s * drive[3] + s2 * drive[4];
  }
  // Counts from where `at` holds, a time s later, from now on: inputs stay as they are there, what is prescribed goes
  // on.
  void continue_from(const Inputs& at, double s) {
    derivative[0] = at.u;
    for (int k = 1; k <= kMaxDerivative; ++k) derivative[k].setZero();
    start = at.time;
    if (drive[0].size() == 0) return;
    drive[0] = at.x;
    drive[1] = at.xdot;
    drive[2] = at.xddot;
    drive[3] += s * drive[4];
  }
};

}  // namespace sigmafmu
