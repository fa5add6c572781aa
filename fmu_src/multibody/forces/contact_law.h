// The force between two surfaces that touch: Hertz's law with the dissipation of Hunt and Crossley (J. Appl. Mech. 42
// (1975) 440) and Coulomb friction, regularised. With the penetration delta > 0, the normal n towards body 2 and the
// velocity u of its point of contact from that of body 1, both in the same axes:
//
//   N = max(0, k delta^(3/2) (1 + 3/2 c delta')),   k = 4/3 E* sqrt(R),   delta' = -n^T u,
//   F = N (n - mu s),   s = u_t / sqrt(|u_t|^2 + v_s^2),   u_t = (I - n n^T) u,
//
// the force on body 2, where R is the radius of the sphere or R_1 R_2 / (R_1 + R_2). It never pulls. A small impact at
// v returns with (1 - c v) v. Friction has 0.7 of mu N at v_s and opposes any sliding: what sticks on a slope creeps.
//
// F is continuous, with continuous derivatives where contact begins (delta^(3/2)), but for the corner where max() sets
// in: there and at the beginning, where d2F/d(delta)2 is infinite, a step has the order 2 of the rest only if it does
// not span them. An impact of a mass m at v lasts about 2.9 (5/4 m v^2/k)^(2/5) / v.
#pragma once

#include <cmath>

#include "model/elements/contact_surface.h"
#include "multibody/kinematics.h"

namespace sigmafmu {

class ContactLaw {
 public:
  void set(const ContactSurface& surface, double radius) {
    stiffness_ = 4.0 / 3.0 * surface.modulus * std::sqrt(radius);
    dissipation_ = 1.5 * surface.dissipation;
    friction_ = surface.friction;
    slip_velocity_ = surface.slip_velocity;
  }

  // N [N].
  double normal(double delta, double rate) const {
    if (delta <= 0) return 0;
    const double factor = 1 + dissipation_ * rate;
    return factor <= 0 ? 0 : stiffness_ * delta * std::sqrt(delta) * factor;
  }
  // Elastic energy [J].
  double energy(double delta) const { return delta <= 0 ? 0 : 0.4 * stiffness_ * delta * delta * std::sqrt(delta); }
  // F [N].
  Vector3d force(double delta, const Vector3d& n, const Vector3d& u) const {
    const double N = normal(delta, -n.dot(u));
    return N > 0 ? Vector3d(N * direction(n, u)) : Vector3d::Zero();
  }
  struct Derivatives {
    Vector3d by_delta;
    Matrix3d by_n, by_u;
  };
  Derivatives derivatives(double delta, const Vector3d& n, const Vector3d& u) const {
    const double rate = -n.dot(u), N = normal(delta, rate);
    if (N == 0) return {Vector3d::Zero(), Matrix3d::Zero(), Matrix3d::Zero()};
    const double root = stiffness_ * std::sqrt(delta);
    const Vector3d e = direction(n, u), u_t = u + rate * n;
    const Vector3d by_rate = dissipation_ * root * delta * e;
    const double speed = std::sqrt(u_t.squaredNorm() + slip_velocity_ * slip_velocity_);
    // -mu N ds/du_t
    Matrix3d slide = Matrix3d::Zero();
    if (speed > 0) {
      const Vector3d s = u_t / speed;
      slide = -(friction_ * N / speed) * (Matrix3d::Identity() - s * s.transpose());
    }
    return {
        1.5 * root * (1 + dissipation_ * rate) * e,
        N * Matrix3d::Identity() - by_rate * u.transpose() + slide * (rate * Matrix3d::Identity() - n * u.transpose()),
        -by_rate * n.transpose() + slide * (Matrix3d::Identity() - n * n.transpose())};
  }

 private:
  // n - mu s
  Vector3d direction(const Vector3d& n, const Vector3d& u) const {
    const Vector3d u_t = u - n.dot(u) * n;
    const double speed = std::sqrt(u_t.squaredNorm() + slip_velocity_ * slip_velocity_);
    return speed > 0 ? Vector3d(n - (friction_ / speed) * u_t) : n;
  }

  double stiffness_ = 0, dissipation_ = 0, friction_ = 0, slip_velocity_ = 0;  // [N/m^(3/2), s/m, 1, m/s]
};

}  // namespace sigmafmu
