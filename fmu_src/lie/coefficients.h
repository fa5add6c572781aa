// Scalar functions of t = |x| in the closed forms on SO(3) and SE(3). The one place where small angles are guarded.
//
// Every function here is smooth in t^2, and so is D f = f'(t)/t = 2 df/d(t^2): there is no 0/0 for a caller to avoid.
#pragma once

#include <cmath>

// For the small functions that every step calls for every body: compilers leave some of them as calls otherwise.
// FLATTEN inlines all that a function calls, but what is NOINLINE. Not with sanitizers, which make the code many times
// as long.
#if defined(__GNUC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define SIGMAFMU_INLINE inline __attribute__((always_inline))
#define SIGMAFMU_FLATTEN __attribute__((flatten))
#define SIGMAFMU_NOINLINE __attribute__((noinline))
#else
#define SIGMAFMU_INLINE inline
#define SIGMAFMU_FLATTEN
#define SIGMAFMU_NOINLINE
#endif

namespace sigmafmu::lie {

// f with its first and second derivative D. D obeys the rules of differentiation.
struct Radial {
  double f;
  double d = 0;
  double dd = 0;
};

constexpr Radial operator*(double c, const Radial& p) { return {c * p.f, c * p.d, c * p.dd}; }
constexpr Radial operator+(const Radial& p, const Radial& q) { return {p.f + q.f, p.d + q.d, p.dd + q.dd}; }
constexpr Radial operator*(const Radial& p, const Radial& q) {
  return {p.f * q.f, p.d * q.f + p.f * q.d, p.dd * q.f + 2 * p.d * q.d + p.f * q.dd};
}

// 1 / (1 + x / n), x = t^2.
constexpr Radial reciprocal(double x, double n) {
  const double g = 1.0 / (1.0 + x / n);
  return {g, -2 / n * g * g, 8 / (n * n) * g * g * g};
}

namespace detail {

inline constexpr int kTerms = 9;  // 1/19! < eps/6: as many as t <= 1 needs

// sum_k (-x)^k / (2k + p)! and its derivatives D.
struct Series {
  double value[kTerms];
  double derivative[kTerms];
  double second[kTerms];
};

constexpr Series factorial_series(int p) {
  Series s{};
  double factorial = 1;
  for (int i = 2; i <= p; ++i) factorial *= i;
  double sign = 1;
  for (int k = 0; k < kTerms + 2; ++k) {
    if (k < kTerms) s.value[k] = sign / factorial;
    if (k > 0 && k <= kTerms) s.derivative[k - 1] = 2 * k * sign / factorial;
    if (k > 1) s.second[k - 2] = 2 * k * (2 * k - 2) * sign / factorial;
    sign = -sign;
    factorial *= (2 * k + p + 1) * (2 * k + p + 2);
  }
  return s;
}

SIGMAFMU_INLINE double horner(const double (&c)[kTerms], double x) {
  double sum = c[kTerms - 1];
  for (int k = kTerms - 2; k >= 0; --k) sum = sum * x + c[k];
  return sum;
}

}  // namespace detail

struct So3Coefficients {
  double a;   // (1 - cos t) / t^2
  double b;   // (t - sin t) / t^3
  double da;  // a'(t) / t
  double db;  // b'(t) / t
};

// x = t^2 [rad^2]. Below 1 by power series, which needs no trigonometric function and has no cancellation.
SIGMAFMU_INLINE So3Coefficients so3_coefficients(double x) {
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

// The same a and b with their second derivatives.
struct So3Functions {
  Radial a, b;
};

SIGMAFMU_INLINE So3Functions so3_functions(double x) {
  constexpr auto cosine = detail::factorial_series(2), sine = detail::factorial_series(3);
  const auto [a, b, da, db] = so3_coefficients(x);
  const bool series = x < 1.0;
  const double dda = series ? detail::horner(cosine.second, x) : (b - a - 4.0 * da) / x;
  const double ddb = series ? detail::horner(sine.second, x) : (da - 5.0 * db) / x;
  return {{a, da, dda}, {b, db, ddb}};
}

}  // namespace sigmafmu::lie
