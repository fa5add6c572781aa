// Linear maps K(x) = k0 I - k1 hat(x) + k2 hat(x)^2 whose coefficients depend on |x| alone.
//
// T, its inverse and the translation of a screw motion have this form for every coordinate map on SO(3) and SE(3), so
// their products with vectors and their derivatives stand here, once.
#pragma once

#include <Eigen/Core>

#include "lie/coefficients.h"

namespace sigmafmu::lie {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// hat(w) x = w cross x.
SIGMAFMU_INLINE Matrix3d hat(const Vector3d& w) {
  Matrix3d m;
  m(0, 0) = 0, m(0, 1) = -w.z(), m(0, 2) = w.y();
  m(1, 0) = w.z(), m(1, 1) = 0, m(1, 2) = -w.x();
  m(2, 0) = -w.y(), m(2, 1) = w.x(), m(2, 2) = 0;
  return m;
}

// R hat(w): its rows are those of R cross w.
SIGMAFMU_INLINE Matrix3d times_hat(const Matrix3d& R, const Vector3d& w) {
  Matrix3d m;
  m.col(0) = R.col(1) * w.z() - R.col(2) * w.y();
  m.col(1) = R.col(2) * w.x() - R.col(0) * w.z();
  m.col(2) = R.col(0) * w.y() - R.col(1) * w.x();
  return m;
}

// hat(a) hat(b) = b a^T - (a . b) I.
SIGMAFMU_INLINE Matrix3d hat_times_hat(const Vector3d& a, const Vector3d& b) {
  Matrix3d m;
  m(0, 0) = -(a.y() * b.y() + a.z() * b.z()), m(0, 1) = b.x() * a.y(), m(0, 2) = b.x() * a.z();
  m(1, 0) = b.y() * a.x(), m(1, 1) = -(a.x() * b.x() + a.z() * b.z()), m(1, 2) = b.y() * a.z();
  m(2, 0) = b.z() * a.x(), m(2, 1) = b.z() * a.y(), m(2, 2) = -(a.x() * b.x() + a.y() * b.y());
  return m;
}

// K(x) at one x, which the caller passes again. K(-x) = K(x)^T.
struct IsotropicOperator {
  double k0, k1, k2;

  SIGMAFMU_INLINE Matrix3d matrix(const Vector3d& x) const {
    const Matrix3d m = hat(x);
    Matrix3d K = -k1 * m;
    K.diagonal().setConstant(k0);
    K.noalias() += (k2 * m) * m;
    return K;
  }
  // K(x) c without forming K.
  SIGMAFMU_INLINE Vector3d times(const Vector3d& x, const Vector3d& c) const {
    const Vector3d p = x.cross(c);
    return k0 * c - k1 * p + k2 * x.cross(p);
  }
  // d(K(x) c)/dx, 3x3, for a fixed c. d: the coefficients' derivatives D.
  SIGMAFMU_INLINE Matrix3d derivative(const IsotropicOperator& d, const Vector3d& x, const Vector3d& c) const {
    const Vector3d radial = d.times(x, c);
    Matrix3d m = k1 * hat(c);  // x cross (x cross c) = x (x . c) - c |x|^2
    m.noalias() += k2 * (x * c.transpose()) + (radial - 2.0 * k2 * c) * x.transpose();
    m.diagonal().array() += k2 * x.dot(c);
    return m;
  }
};

// K(x) with its first and second derivatives.
struct SmoothOperator {
  IsotropicOperator k, d, dd;

  SIGMAFMU_INLINE SmoothOperator(const Radial& k0, const Radial& k1, const Radial& k2)
      : k{k0.f, k1.f, k2.f}, d{k0.d, k1.d, k2.d}, dd{k0.dd, k1.dd, k2.dd} {}

  // d(K(x) c)/dx, 3x3.
  SIGMAFMU_INLINE Matrix3d derivative(const Vector3d& x, const Vector3d& c) const { return k.derivative(d, x, c); }

  // d(K(x) c)/dx w without forming the matrix.
  Vector3d derivative_times(const Vector3d& x, const Vector3d& c, const Vector3d& w) const {
    return x.dot(w) * d.times(x, c) - k.k1 * w.cross(c) + k.k2 * double_product(x, c, w);
  }
  // The matrix dK(x)/dx w, 3x3: what it makes of c is the vector above.
  Matrix3d derivative_along(const Vector3d& x, const Vector3d& w) const {
    Matrix3d m = x.dot(w) * d.matrix(x);
    m.noalias() -= k.k1 * hat(w);
    m.noalias() += k.k2 * (w * x.transpose() + x * w.transpose());
    m.diagonal().array() -= 2.0 * k.k2 * x.dot(w);
    return m;
  }
  // d(dK(x)/dx w c)/dx, 3x3, for fixed c and w.
  Matrix3d second_derivative(const Vector3d& x, const Vector3d& c, const Vector3d& w) const {
    Matrix3d m = x.dot(w) * d.derivative(dd, x, c);
    m.noalias() += d.times(x, c) * w.transpose();
    m.noalias() += (d.k2 * double_product(x, c, w) - d.k1 * w.cross(c)) * x.transpose();
    m.noalias() += k.k2 * (w * c.transpose() - 2.0 * c * w.transpose());
    m.diagonal().array() += k.k2 * w.dot(c);
    return m;
  }

 private:
  // d/dx (x cross (x cross c)) w
  static Vector3d double_product(const Vector3d& x, const Vector3d& c, const Vector3d& w) {
    return w.cross(x.cross(c)) + x.cross(w.cross(c));
  }
};

}  // namespace sigmafmu::lie
