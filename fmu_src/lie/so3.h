// The rotation group SO(3): exponential, logarithm, tangent operator and its derivative.
//
// Every function takes and returns plain values and is accurate to rounding for every rotation angle, zero included.
// A rotation vector theta [rad] stands for R = exp(hat(theta)); unit quaternions represent R_WB, which maps body axes
// to W. Body-fixed ("right") convention throughout: R(t) = R_n exp(hat(theta(t))), w_WB_B = T(theta) dtheta/dt.
//
// Sources: Holzinger, Arnold, Gerstmayr 2025, Eqs. (9), (16), (25); Mueller 2022, section 3.
#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "lie/isotropic_operator.h"

namespace sigmafmu::lie {

using Eigen::Quaterniond;

// Unit quaternion of exp(hat(theta)): (cos(t/2), sin(t/2)/t theta).
SIGMAFMU_INLINE Quaterniond exp(const Vector3d& theta) {
  const double x = theta.squaredNorm();
  if (x < 1.0) {
    // cos s = 1 - s^2 a(s), sin s / s = 1 - s^2 b(s) with s = t/2
    constexpr auto cosine = detail::factorial_series(2), sine = detail::factorial_series(3);
    const double s2 = 0.25 * x;
    const double k = 0.5 * (1.0 - s2 * detail::horner(sine.value, s2));
    return {1.0 - s2 * detail::horner(cosine.value, s2), k * theta.x(), k * theta.y(), k * theta.z()};
  }
  const double t = std::sqrt(x);
  const double k = std::sin(0.5 * t) / t;
  return {std::cos(0.5 * t), k * theta.x(), k * theta.y(), k * theta.z()};
}

// Rotation vector [rad] of a unit quaternion, |theta| <= pi.
inline Vector3d log(const Quaterniond& quat) {
  const double s = quat.vec().norm();
  const double sign = quat.w() < 0.0 ? -1.0 : 1.0;
  if (s < 1e-150) return 2.0 * sign * quat.vec();
  return (2.0 * sign * std::atan2(s, sign * quat.w()) / s) * quat.vec();
}

// p q for unit quaternions. A Newton step for 1/|r| keeps the product r unit up to rounding over any number of
// products: it removes what rounding adds and nothing else.
SIGMAFMU_INLINE Quaterniond unit_product(const Quaterniond& p, const Quaterniond& q) {
  Quaterniond r = p * q;
  r.coeffs() *= 0.5 * (3.0 - r.squaredNorm());
  return r;
}

// T(theta)^-1 = I + hat(theta)/2 - da/(2a) hat(theta)^2; singular at |theta| = 2 pi k, k = 1, 2, ... x = |theta|^2.
SIGMAFMU_INLINE IsotropicOperator so3_tangent_inverse(double x) {
  const auto [a, b, da, db] = so3_coefficients(x);
  return {1.0, -0.5, -(0.5 * da / a)};
}

// Tangent operator T(theta) = I - a hat(theta) + b hat(theta)^2, Eq. (25).
inline Matrix3d tangent(const Vector3d& theta) {
  const auto [a, b, da, db] = so3_coefficients(theta.squaredNorm());
  return IsotropicOperator{1.0, a, b}.matrix(theta);
}

// T(theta) c without forming T.
inline Vector3d tangent_times(const Vector3d& theta, const Vector3d& c) {
  const auto [a, b, da, db] = so3_coefficients(theta.squaredNorm());
  return IsotropicOperator{1.0, a, b}.times(theta, c);
}

inline Matrix3d tangent_inverse(const Vector3d& theta) {
  return so3_tangent_inverse(theta.squaredNorm()).matrix(theta);
}

// T(theta)^-1 c without forming T^-1.
inline Vector3d tangent_inverse_times(const Vector3d& theta, const Vector3d& c) {
  return so3_tangent_inverse(theta.squaredNorm()).times(theta, c);
}

// d(T(theta)^-1 c)/dtheta for a fixed c, 3x3.
inline Matrix3d tangent_inverse_derivative(const Vector3d& theta, const Vector3d& c) {
  const double x = theta.squaredNorm();
  const Radial a = so3_functions(x).a;
  return so3_tangent_inverse(x).derivative({0.0, 0.0, 0.5 * (a.d * a.d - a.f * a.dd) / (a.f * a.f)}, theta, c);
}

// d(T(theta) c)/dtheta for a fixed c, 3x3.
inline Matrix3d tangent_derivative(const Vector3d& theta, const Vector3d& c) {
  const auto [a, b, da, db] = so3_coefficients(theta.squaredNorm());
  return IsotropicOperator{1.0, a, b}.derivative({0.0, da, db}, theta, c);
}

}  // namespace sigmafmu::lie
