// sigma of a body that spins about a principal axis which itself turns slowly (docs/sigma.md has the derivation).
//
// The Lie term of (40), its term C_q v'' and the error of the velocity update are then multiples of one vector, and
//
//   sigma* = (4 gamma/beta) (1/12 - C_q + eta q),     C_q = (1 - 6 beta - 3 (alpha_m - alpha_f))/6,        (41)
//   eta    = [gamma (1-gamma) + alpha_f (1-alpha_f) - alpha_m (1-alpha_m)]/2 - 1/24,
//   q      = [m - 2 d^2/(2 m - J_s)]/J_s,             m, d = (J_1 +- J_2)/2
//
// lets them cancel; J_s is the moment of inertia about the spin axis e, J_1 and J_2 are the others. With a weight in
// [0, 1] sigma lies between integrator.sigma and sigma*. The weight is a product of three, continuous in the state:
//
//   spin      the angular velocity w_t across e is small against the spin W,
//   driven    w_t is near w_P = e x tau/(J_s W), with which the moment tau = J w' + w x J w of all loads turns the axis
//             of a gyroscope; what differs is nutation or the answer to a moment that turns with the body,
//   resolved  h W sqrt(sigma*) is small: sigma* comes from an expansion in h W.
//
// Flexible bodies and bodies with joints keep integrator.sigma: in index 3 a sigma that changes makes the multipliers
// oscillate, and in the other forms the best one depends on the motion. So does every body in the incremental form, and
// on other groups or coordinate maps than R^3 x SO(3) with exp, for which it is derived.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "integrator/methods/alpha_parameters.h"
#include "model/dense.h"
#include "model/settings.h"
#include "multibody/system.h"

namespace sigmafmu {

class SpinSigma {
 public:
  SpinSigma(const System& system, const IntegratorSettings& settings) : given_(settings.sigma) {
    const bool derived =
        settings.is(Corrector::residual) && settings.is(LieGroup::r3xso3) && settings.is(CoordinateMap::exponential);
    const AlphaParameters alpha(settings.spectral_radius);
    const std::vector<bool> in_joints = system.bodies_in_joints();
    for (int i = 0; i < system.body_count(); ++i) {
      const RigidBody* body = system.rigid(i);
      bodies_.push_back(principal(body ? body->J : Matrix3d::Identity(), alpha, derived && body && !in_joints[i]));
    }
  }

  // For a step of h [s] that starts with w [rad/s] and its derivative wdot [rad/s2], both in body axes.
  double operator()(int body, const Vector3d& w_B, const Vector3d& wdot_B, double h) const {
    const Principal& b = bodies_[body];
    const Vector3d w = b.axes.transpose() * w_B, wdot = b.axes.transpose() * wdot_B;
    int s;
    const double spin = w.cwiseAbs().maxCoeff(&s);
    if (!b.qualified[s] || spin == 0.0) return given_;
    const int i = (s + 1) % 3, j = (s + 2) % 3;
    const Vector3d tau = b.J.cwiseProduct(wdot) + w.cross(b.J.cwiseProduct(w));
    const Eigen::Vector2d w_t(w[i], w[j]), w_P = Eigen::Vector2d(-tau[j], tau[i]) / (b.J[s] * w[s]);
    const double precession = w_P.norm();
    if (precession == 0.0) return given_;
    const double weight = falling(w_t.norm() / spin, kSpin) * falling((w_t - w_P).norm() / precession, kDriven) *
                          falling(h * spin * std::sqrt(b.sigma[s]), kResolved);
    return given_ + weight * (b.sigma[s] - given_);
  }

 private:
  struct Range {
    double full, none;  // weight 1 up to `full`, 0 from `none` on, linear between
  };
  static constexpr Range kSpin{0.02, 0.05};
  static constexpr Range kDriven{0.15, 0.4};  // at most as far from the optimum as sigma = 1, for every tau(t)
  static constexpr Range kResolved{0.5, 1.0};

  struct Principal {
    Matrix3d axes;  // columns in body axes, right-handed
    Vector3d J;     // moments [kg m2]
    // For spin about each of the axes:
    std::array<double, 3> sigma;
    std::array<bool, 3> qualified;
  };

  static double falling(double x, Range r) { return std::clamp((r.none - x) / (r.none - r.full), 0.0, 1.0); }

  static Principal principal(const Matrix3d& J, const AlphaParameters& alpha, bool qualified) {
    const PrincipalAxes principal = principal_axes(J);
    Principal b{principal.axes, principal.values, {}, {}};
    if (b.axes.determinant() < 0) b.axes.col(0) *= -1;
    for (int s = 0; s < 3; ++s) {
      const double J1 = b.J[(s + 1) % 3], J2 = b.J[(s + 2) % 3];
      const double m = 0.5 * (J1 + J2), d = 0.5 * (J1 - J2), excess = 2 * m - b.J[s];
      // Unequal moments make the axis wobble twice per turn, with 2 |d|/excess of the velocity of its precession.
      // Spin about the middle axis is unstable; keep away from it.
      b.qualified[s] = qualified && 2 * std::abs(d) <= std::min(kDriven.none * excess, std::abs(b.J[s] - m));
      if (b.qualified[s]) b.sigma[s] = optimum((m - (d == 0 ? 0 : 2 * d * d / excess)) / b.J[s], alpha);
    }
    return b;
  }

  static double optimum(double q, const AlphaParameters& p) {
    const auto half = [](double x) { return 0.5 * x * (1 - x); };
    const double C_q = p.position_error();
    const double eta = half(p.gamma) + half(p.alpha_f) - half(p.alpha_m) - 1.0 / 24;
    return 4 * p.gamma / p.beta * (1.0 / 12 - C_q + eta * q);
  }

  double given_;
  std::vector<Principal> bodies_;
};

}  // namespace sigmafmu
