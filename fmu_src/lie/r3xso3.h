// The group R^3 x SO(3) of one rigid body: mixed velocities v = (v_WB in W, w_WB_B in body axes).
//
// Absolute coordinates of a body: q = (p_WB [m], quat_WB (w, x, y, z)), 7 numbers; local coordinates
// theta = (theta_t [m], theta_r [rad]), 6 numbers. The hat operator and T act on the rotation alone
// (Holzinger, Arnold, Gerstmayr 2025, Eqs. A.6, A.7, B.2).
#pragma once

#include "lie/pose.h"
#include "lie/rotation_maps.h"

namespace sigmafmu::lie {

template <typename Coordinates>
inline Quaterniond quaternion(const Coordinates& q) {
  return {q[3], q[4], q[5], q[6]};
}

// q o exp(theta), the local-global transition map (44). The quaternion is brought back to unit length to rounding.
template <typename Coordinates, typename Local>
inline Vector7d compose(const Coordinates& q, const Local& theta) {
  const Quaterniond r = unit_product(quaternion(q), exp(Vector3d(theta[3], theta[4], theta[5])));
  Vector7d result;
  for (int i = 0; i < 3; ++i) result[i] = q[i] + theta[i];
  result[3] = r.w(), result[4] = r.x(), result[5] = r.y(), result[6] = r.z();
  return result;
}

// SO(3) with one of the coordinate maps of rotation_maps.h, R = R(x): the part of R^3 x SO(3) in which coordinates and
// velocities differ. Same functions as SE3 in se3.h, which says what they mean.
template <class Map>
struct SO3 {
  static constexpr int kSize = 3;

  static Matrix3d tangent(const Vector3d& x) { return Map::tangent(x.squaredNorm()).k.matrix(x); }
  SIGMAFMU_INLINE static Vector3d tangent_times(const Vector3d& x, const Vector3d& w) {
    return Map::tangent(x.squaredNorm()).k.times(x, w);
  }
  static Matrix3d tangent_inverse(const Vector3d& x) { return Map::tangent_inverse(x.squaredNorm()).matrix(x); }
  SIGMAFMU_INLINE static Vector3d tangent_inverse_times(const Vector3d& x, const Vector3d& w) {
    return Map::tangent_inverse(x.squaredNorm()).times(x, w);
  }
  static Matrix3d tangent_derivative(const Vector3d& x, const Vector3d& w) {
    return Map::tangent(x.squaredNorm()).derivative(x, w);
  }
  static Vector3d commutator(const Vector3d& v, const Vector3d& w) { return v.cross(w); }
};

// R^3 x SO(3): X = (displacement in W [m], x). Translation and rotation do not mix.
template <class Map>
struct R3xSO3 {
  using Coordinates = Map;
  using Coupled = SO3<Map>;  // acts on the last Coupled::kSize entries; T = I for the others

  static Pose product(const Pose& c1, const Pose& c2) { return {c1.p + c2.p, unit_product(c1.quat, c2.quat)}; }
  static Pose inverse(const Pose& c) { return {-c.p, c.quat.conjugate()}; }

  static Pose psi(const Vector6d& X) { return {X.head<3>(), Map::quaternion(X.tail<3>())}; }  // Eqs. (29), (35)
  static Vector6d psi_inverse(const Pose& c) {
    Vector6d X;
    X << c.p, Map::coordinates(c.quat);
    return X;
  }

  static Matrix6d tangent(const Vector6d& X) {  // Eqs. (34), (36), transposed
    return with_rotation(Coupled::tangent(X.tail<3>()), 1.0);
  }
  static Vector6d tangent_times(const Vector6d& X, const Vector6d& w) {
    return with_rotation(w, Coupled::tangent_times(X.tail<3>(), w.tail<3>()));
  }
  static Matrix6d tangent_inverse(const Vector6d& X) {  // Eqs. (33), (37), transposed
    return with_rotation(Coupled::tangent_inverse(X.tail<3>()), 1.0);
  }
  static Vector6d tangent_inverse_times(const Vector6d& X, const Vector6d& w) {
    return with_rotation(w, Coupled::tangent_inverse_times(X.tail<3>(), w.tail<3>()));
  }
  static Matrix6d tangent_derivative(const Vector6d& X, const Vector6d& w) {
    return with_rotation(Coupled::tangent_derivative(X.tail<3>(), w.tail<3>()), 0.0);
  }

  static Vector6d commutator(const Vector6d& V, const Vector6d& W) {
    Vector6d c;
    c << Vector3d::Zero(), V.tail<3>().cross(W.tail<3>());
    return c;
  }

  // The group's velocities are the mixed ones of the equations of motion.
  static Vector6d velocity(const Quaterniond&, const Vector6d& mixed) { return mixed; }
  static Vector6d mixed_velocity(const Quaterniond&, const Vector6d& V) { return V; }
  static Vector6d acceleration(const Quaterniond&, const Vector6d&, const Vector6d& mixed_rate) { return mixed_rate; }
  static Vector6d mixed_acceleration(const Quaterniond&, const Vector6d&, const Vector6d& Vdot) { return Vdot; }
  static Vector6d jerk(const Quaterniond&, const Vector6d&, const Vector6d&, const Vector6d& mixed_rate2) {
    return mixed_rate2;
  }

 private:
  static Matrix6d with_rotation(const Matrix3d& rotation, double translation) {
    Matrix6d m = Matrix6d::Zero();
    m.topLeftCorner<3, 3>().diagonal().setConstant(translation);
    m.bottomRightCorner<3, 3>() = rotation;
    return m;
  }
  static Vector6d with_rotation(Vector6d w, const Vector3d& rotation) {
    w.tail<3>() = rotation;
    return w;
  }
};

}  // namespace sigmafmu::lie
