// The rotation group SO(3): exponential, logarithm, tangent operator and its derivative.
//
// Every function takes and returns plain values and is accurate to rounding for every rotation angle, zero included.
// A rotation vector theta [rad] stands for R = exp(hat(theta)); unit quaternions represent R_WB, which maps body axes
// to W. Body-fixed ("right") convention throughout: R(t) = R_n exp(hat(theta(t))), w_WB_B = T(theta) dtheta/dt.
//
// Sources: Holzinger, Arnold, Gerstmayr 2025, Eqs. (9), (16), (25); Mueller 2022, section 3.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace sigmafmu::lie {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

// hat(w) x = w cross x.
inline Matrix3d hat(const Vector3d& w) {
  Matrix3d m;
  m(0, 0) = 0, m(0, 1) = -w.z(), m(0, 2) = w.y();
  m(1, 0) = w.z(), m(1, 1) = 0, m(1, 2) = -w.x();
  m(2, 0) = -w.y(), m(2, 1) = w.x(), m(2, 2) = 0;
  return m;
}

// Coefficients of the closed forms below, functions of t = |theta|. The one place where small angles are guarded.
struct So3Coefficients {
  double a;   // (1 - cos t) / t^2
  double b;   // (t - sin t) / t^3
  double da;  // a'(t) / t
  double db;  // b'(t) / t
};

namespace detail {

inline constexpr int kTerms = 9;  // 1/19! < eps/6: as many as |theta| <= 1 needs

// sum_k (-x)^k weight(k) / (2k + p)! with weight 1, or 2k after one division by x (for 2 d/dx of the first sum).
struct Series {
  double value[kTerms];
  double derivative[kTerms];
};

constexpr Series factorial_series(int p) {
  Series s{};
  double factorial = 1;
  for (int i = 2; i <= p; ++i) factorial *= i;
  double sign = 1;
  for (int k = 0; k <= kTerms; ++k) {
    if (k < kTerms) s.value[k] = sign / factorial;
    if (k > 0) s.derivative[k - 1] = 2 * k * sign / factorial;
    sign = -sign;
    factorial *= (2 * k + p + 1) * (2 * k + p + 2);
  }
  return s;
}

inline double horner(const double (&c)[kTerms], double x) {
  double sum = c[kTerms - 1];
  for (int k = kTerms - 2; k >= 0; --k) sum = sum * x + c[k];
  return sum;
}

}  // namespace detail

// x = |theta|^2 [rad^2]. Below 1 by power series, which needs no trigonometric function and has no cancellation.
inline So3Coefficients so3_coefficients(double x) {
  using detail::horner;
  constexpr auto cosine = detail::factorial_series(2), sine = detail::factorial_series(3);
  if (x < 1.0) {
    return {horner(cosine.value, x), horner(sine.value, x), horner(cosine.derivative, x), horner(sine.derivative, x)};
  }
  const double t = std::sqrt(x);
  const double sinc = std::sin(t) / t;
  const double half = std::sin(0.5 * t);
  const double a = 2.0 * half * half / x;
  const double b = (1.0 - sinc) / x;
  return {a, b, (sinc - 2.0 * a) / x, (a - 3.0 * b) / x};
}

// Unit quaternion of exp(hat(theta)): (cos(t/2), sin(t/2)/t theta).
inline Quaterniond exp(const Vector3d& theta) {
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

// Tangent operator T(theta) = I - a hat(theta) + b hat(theta)^2, Eq. (25).
inline Matrix3d tangent(const Vector3d& theta) {
  const auto [a, b, da, db] = so3_coefficients(theta.squaredNorm());
  const Matrix3d m = hat(theta);
  return Matrix3d::Identity() - a * m + b * m * m;
}

// T(theta) c without forming T.
inline Vector3d tangent_times(const Vector3d& theta, const Vector3d& c) {
  const auto [a, b, da, db] = so3_coefficients(theta.squaredNorm());
  const Vector3d p = theta.cross(c);
  return c - a * p + b * theta.cross(p);
}

// T(theta)^-1 = I + hat(theta)/2 - da/(2a) hat(theta)^2; singular at |theta| = 2 pi k, k = 1, 2, ...
inline Matrix3d tangent_inverse(const Vector3d& theta) {
  const auto [a, b, da, db] = so3_coefficients(theta.squaredNorm());
  const Matrix3d m = hat(theta);
  return Matrix3d::Identity() + 0.5 * m - (0.5 * da / a) * m * m;
}

// T(theta)^-1 c without forming T^-1.
inline Vector3d tangent_inverse_times(const Vector3d& theta, const Vector3d& c) {
  const auto [a, b, da, db] = so3_coefficients(theta.squaredNorm());
  const Vector3d p = theta.cross(c);
  return c + 0.5 * p - (0.5 * da / a) * theta.cross(p);
}

// d(T(theta) c)/dtheta for a fixed c, 3x3.
inline Matrix3d tangent_derivative(const Vector3d& theta, const Vector3d& c) {
  const auto [a, b, da, db] = so3_coefficients(theta.squaredNorm());
  const Vector3d p = theta.cross(c);
  const Vector3d radial = db * theta.cross(p) - da * p;
  Matrix3d d = a * hat(c);
  d.noalias() += b * (theta * c.transpose()) + (radial - 2.0 * b * c) * theta.transpose();
  d.diagonal().array() += b * theta.dot(c);
  return d;
}

}  // namespace sigmafmu::lie
