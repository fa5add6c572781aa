// The group SE(3) of one rigid body: body-fixed twists V = (v_WB, w_WB), both in body axes [m/s], [rad/s].
//
// Local coordinates X = (y, x), 6 numbers, translation first as everywhere here (Mueller 2022 puts rotation first),
// stand for the motion psi(X) in the body's axes at the start of a step:
//
//   psi(X) = (R(x), S(x)^T y),   V = T(X) dX/dt,   T(X) = ( S(x)  d(S(x) y)/dx - hat(S(x) y) T(x) )
//                                                         (  0               T(x)                 )
//
// R, T(x) and S(x) of the coordinate map are in rotation_maps.h: screw coordinates (44)-(47), extended Rodrigues
// parameters X = 2 (d, c) (48), (49), and their second order X = 4 (d, c). T(X) follows from V = (R^T d(S^T y)/dt, w)
// with S^T = R S. T(0) = I for all of them.
#pragma once

#include "lie/pose.h"
#include "lie/rotation_maps.h"

namespace sigmafmu::lie {

template <class Map>
struct SE3 {
  using Coordinates = Map;
  using Coupled = SE3;  // translation and rotation mix: all six entries
  static constexpr int kSize = 6;

  // C1 C2, Eq. (43); the quaternion stays unit up to rounding.
  static Pose product(const Pose& c1, const Pose& c2) {
    return {c1.p + c1.quat * c2.p, unit_product(c1.quat, c2.quat)};
  }
  static Pose inverse(const Pose& c) {
    const Quaterniond r = c.quat.conjugate();
    return {-(r * c.p), r};
  }

  // The motion with coordinates X; displacement [m].
  static Pose psi(const Vector6d& X) {
    const Vector3d x = X.tail<3>(), y = X.head<3>();
    return {Map::screw(x.squaredNorm()).k.times(-x, y), Map::quaternion(x)};
  }
  // The X of least rotation with psi(X) = C.
  static Vector6d psi_inverse(const Pose& c) {
    const Vector3d x = Map::coordinates(c.quat);
    Vector6d X;
    X << Map::screw_inverse(x.squaredNorm()).times(-x, c.p), x;
    return X;
  }

  // T(X), 6x6.
  SIGMAFMU_NOINLINE static Matrix6d tangent(const Vector6d& X) {
    const Terms t(X);
    Matrix6d m = Matrix6d::Zero();
    m.topLeftCorner<3, 3>() = t.S.k.matrix(t.x);
    m.bottomRightCorner<3, 3>() = t.T.k.matrix(t.x);
    m.topRightCorner<3, 3>() = t.S.derivative(t.x, t.y) - hat(t.Sy) * m.bottomRightCorner<3, 3>();
    return m;
  }
  // T(X) w without forming T.
  SIGMAFMU_NOINLINE static Vector6d tangent_times(const Vector6d& X, const Vector6d& w) {
    const Terms t(X);
    const Vector3d wt = w.head<3>(), wr = w.tail<3>(), Twr = t.T.k.times(t.x, wr);
    Vector6d r;
    r << t.S.k.times(t.x, wt) + t.S.derivative_times(t.x, t.y, wr) - t.Sy.cross(Twr), Twr;
    return r;
  }
  // T(X)^-1, 6x6; singular where T(x) is.
  SIGMAFMU_NOINLINE static Matrix6d tangent_inverse(const Vector6d& X) {
    const Terms t(X);
    const double z = t.x.squaredNorm();
    const Matrix3d T_inverse = Map::tangent_inverse(z).matrix(t.x), S_inverse = Map::screw_inverse(z).matrix(t.x);
    Matrix6d m = Matrix6d::Zero();
    m.topLeftCorner<3, 3>() = S_inverse;
    m.bottomRightCorner<3, 3>() = T_inverse;
    m.topRightCorner<3, 3>() = S_inverse * (hat(t.Sy) - t.S.derivative(t.x, t.y) * T_inverse);
    return m;
  }
  // T(X)^-1 w without forming T^-1.
  SIGMAFMU_NOINLINE static Vector6d tangent_inverse_times(const Vector6d& X, const Vector6d& w) {
    const Terms t(X);
    const double z = t.x.squaredNorm();
    const Vector3d wt = w.head<3>(), wr = w.tail<3>(), xdot = Map::tangent_inverse(z).times(t.x, wr);
    const Vector3d rest = wt - t.S.derivative_times(t.x, t.y, xdot) + t.Sy.cross(wr);
    Vector6d r;
    r << Map::screw_inverse(z).times(t.x, rest), xdot;
    return r;
  }
  // d(T(X) w)/dX for a fixed w, 6x6.
  SIGMAFMU_NOINLINE static Matrix6d tangent_derivative(const Vector6d& X, const Vector6d& w) {
    const Terms t(X);
    const Vector3d wt = w.head<3>(), wr = w.tail<3>();
    const Matrix3d dTwr = t.T.derivative(t.x, wr), Twr = hat(t.T.k.times(t.x, wr));
    Matrix6d m = Matrix6d::Zero();
    m.topLeftCorner<3, 3>() = t.S.derivative_along(t.x, wr) + Twr * t.S.k.matrix(t.x);
    m.topRightCorner<3, 3>() = t.S.derivative(t.x, wt) + t.S.second_derivative(t.x, t.y, wr) +
                               Twr * t.S.derivative(t.x, t.y) - hat(t.Sy) * dTwr;
    m.bottomRightCorner<3, 3>() = dTwr;
    return m;
  }

  // [V, W], the bracket of the Lie algebra: hat(V) W.
  static Vector6d commutator(const Vector6d& V, const Vector6d& W) {
    const Vector3d v = V.head<3>(), w = V.tail<3>();
    Vector6d c;
    c << w.cross(W.head<3>()) + v.cross(W.tail<3>()), w.cross(W.tail<3>());
    return c;
  }

  // The group's velocity of mixed ones (v_WB in W, w_WB_B), and back: diag(R_WB^T, I), diag(R_WB, I).
  static Vector6d velocity(const Quaterniond& quat_WB, const Vector6d& mixed) {
    return turned(quat_WB.conjugate(), mixed);
  }
  static Vector6d mixed_velocity(const Quaterniond& quat_WB, const Vector6d& V) { return turned(quat_WB, V); }

  // The same for their time derivatives: d(v_B)/dt = R_WB^T d(v_W)/dt - w_B cross v_B.
  static Vector6d acceleration(const Quaterniond& quat_WB, const Vector6d& mixed, const Vector6d& mixed_rate) {
    const Vector3d w = mixed.tail<3>();
    Vector6d r = turned(quat_WB.conjugate(), mixed_rate);
    r.head<3>() -= w.cross(quat_WB.conjugate() * mixed.head<3>());
    return r;
  }
  static Vector6d mixed_acceleration(const Quaterniond& quat_WB, const Vector6d& V, const Vector6d& Vdot) {
    Vector6d r = Vdot;
    r.head<3>() += V.tail<3>().cross(V.head<3>());
    return turned(quat_WB, r);
  }
  // d(Vdot)/dt of the mixed velocities and their first and second derivatives.
  static Vector6d jerk(const Quaterniond& quat_WB, const Vector6d& mixed, const Vector6d& mixed_rate,
                       const Vector6d& mixed_rate2) {
    const Vector3d w = mixed.tail<3>(), wdot = mixed_rate.tail<3>();
    const Quaterniond R_BW = quat_WB.conjugate();
    const Vector3d v_B = R_BW * Vector3d(mixed.head<3>()), a_B = R_BW * Vector3d(mixed_rate.head<3>());
    Vector6d r = turned(R_BW, mixed_rate2);
    r.head<3>() -= 2.0 * w.cross(a_B) + wdot.cross(v_B) - w.cross(w.cross(v_B));
    return r;
  }

 private:
  // What every tangent function starts with.
  struct Terms {
    Vector3d x, y;
    SmoothOperator T, S;
    Vector3d Sy;

    explicit Terms(const Vector6d& X)
        : x(X.tail<3>()),
          y(X.head<3>()),
          T(Map::tangent(x.squaredNorm())),
          S(Map::screw(x.squaredNorm())),
          Sy(S.k.times(x, y)) {}
  };

  static Vector6d turned(const Quaterniond& quat, Vector6d v) {
    v.head<3>() = quat * Vector3d(v.head<3>());
    return v;
  }
};

}  // namespace sigmafmu::lie
