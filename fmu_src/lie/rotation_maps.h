// Three coordinate maps x -> R(x) of SO(3), with what SE(3) needs of them: one row each of the table
//
//                |x|           T               T^-1                  S                           S^-1
//   Exponential  phi           1, a, b         1, -1/2, -a'/(2 a t)  1, a, b                     1, -1/2, -a'/(2 a t)
//   Cayley       2 tan(phi/2)  s, s/2, 0       1 + z/4, -1/2, 1/4    1, s/2, s/4                 1, -1/2, 0
//   Cayley2      4 tan(phi/4)  g, g^2/2, g^2/8 1 + z/16, -1/2, 1/8   1, g^2/2, (g + 2 g^2)/16    1, -1/2, 1/16
//
// R is the rotation by phi [rad] about x; t = |x|, z = t^2; a(t), b(t) of so3_coefficients, s = 1/(1 + z/4) =
// cos^2(phi/2), g = 1/(1 + z/16) = cos^2(phi/4). The operators are listed as k0, k1, k2 of k0 I - k1 hat(x) +
// k2 hat(x)^2. T: w_B = T(x) dx/dt. S: translation that goes with the rotation, see se3.h.
//
// x is scaled such that T(0) = I: to first order every x is the rotation vector, and x = h w_B + O(h^2) in a step h.
// The Rodrigues parameters c of Mueller 2022 are x/2, Wiener-Milenkovic parameters x/4 (second-order Cayley map: R is
// cay(x/4) applied twice). Equation numbers are Mueller's, with the corrections of docs/lie.md.
#pragma once

#include "lie/so3.h"

namespace sigmafmu::lie {

// R = exp(hat(x)), Eqs. (30)-(33), (39). x [rad]; one-to-one below pi, T singular at 2 pi k.
struct Exponential {
  static constexpr bool kCanonical = true;  // R(s x) is a rotation at constant speed: T(x) x = x
  SIGMAFMU_INLINE static Quaterniond quaternion(const Vector3d& x) { return exp(x); }
  static Vector3d coordinates(const Quaterniond& quat) { return log(quat); }  // |x| <= pi
  static double angle(double length) { return length; }                       // phi of |x|

  SIGMAFMU_INLINE static SmoothOperator tangent(double z) {
    const auto [a, b] = so3_functions(z);
    return {{1.0}, a, b};
  }
  SIGMAFMU_INLINE static IsotropicOperator tangent_inverse(double z) { return so3_tangent_inverse(z); }
  SIGMAFMU_INLINE static SmoothOperator screw(double z) { return tangent(z); }
  SIGMAFMU_INLINE static IsotropicOperator screw_inverse(double z) { return tangent_inverse(z); }
};

// R = (I - hat(c))^-1 (I + hat(c)), c = x/2, Eqs. (35)-(37), (41). No trigonometric functions. phi < pi; x grows
// without bound on the way there.
struct Cayley {
  static constexpr bool kCanonical = false;
  SIGMAFMU_INLINE static Quaterniond quaternion(const Vector3d& x) {  // cos(phi/2) (1, c)
    const double p0 = 1.0 / std::sqrt(1.0 + 0.25 * x.squaredNorm());
    const double k = 0.5 * p0;
    return {p0, k * x.x(), k * x.y(), k * x.z()};
  }
  static Vector3d coordinates(const Quaterniond& quat) {
    return 2.0 / quat.w() * quat.vec();
  }  // not finite at phi = pi
  static double angle(double length) { return 2.0 * std::atan(0.5 * length); }

  SIGMAFMU_INLINE static SmoothOperator tangent(double z) {
    const Radial s = reciprocal(z, 4.0);
    return {s, 0.5 * s, {0.0}};
  }
  SIGMAFMU_INLINE static IsotropicOperator tangent_inverse(double z) { return {1.0 + 0.25 * z, -0.5, 0.25}; }
  SIGMAFMU_INLINE static SmoothOperator screw(double z) {
    const Radial s = reciprocal(z, 4.0);
    return {{1.0}, 0.5 * s, 0.25 * s};
  }
  SIGMAFMU_INLINE static IsotropicOperator screw_inverse(double) { return {1.0, -0.5, 0.0}; }
};

// R = cay(c)^2, c = x/4: Wiener-Milenkovic parameters, remark at the end of section 6.4. No trigonometric functions.
// One-to-one below pi, where |x| = 4; regular up to 2 pi.
struct Cayley2 {
  static constexpr bool kCanonical = false;
  SIGMAFMU_INLINE static Quaterniond quaternion(const Vector3d& x) {  // (cos(phi/2), 2 cos^2(phi/4) c)
    const double g = 1.0 / (1.0 + 0.0625 * x.squaredNorm());
    const double k = 0.5 * g;
    return {2.0 * g - 1.0, k * x.x(), k * x.y(), k * x.z()};
  }
  static Vector3d coordinates(const Quaterniond& quat) {  // |x| <= 4
    const double sign = quat.w() < 0.0 ? -1.0 : 1.0;
    return 4.0 * sign / (1.0 + sign * quat.w()) * quat.vec();
  }
  static double angle(double length) { return 4.0 * std::atan(0.25 * length); }

  SIGMAFMU_INLINE static SmoothOperator tangent(double z) {
    const Radial g = reciprocal(z, 16.0), gg = g * g;
    return {g, 0.5 * gg, 0.125 * gg};
  }
  SIGMAFMU_INLINE static IsotropicOperator tangent_inverse(double z) { return {1.0 + 0.0625 * z, -0.5, 0.125}; }
  SIGMAFMU_INLINE static SmoothOperator screw(double z) {
    const Radial g = reciprocal(z, 16.0), gg = g * g;
    return {{1.0}, 0.5 * gg, 0.0625 * g + 0.125 * gg};
  }
  SIGMAFMU_INLINE static IsotropicOperator screw_inverse(double) { return {1.0, -0.5, 0.0625}; }
};

}  // namespace sigmafmu::lie
