// sigmafmu._core.lie: SO(3), and every group with every coordinate map.
#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>

#include <string>

#include "lie/lgt.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace sigmafmu::lie;
using Eigen::Vector4d;

namespace {

// Positions and quaternions (w, x, y, z) come and go as q of QuaternionPosition.
Pose pose(const Vector7d& q) { return QuaternionPosition::pose(q); }
Vector7d array(const Pose& c) { return QuaternionPosition::coordinates(c); }
Eigen::Quaterniond quat(const Vector4d& q) { return {q[0], q[1], q[2], q[3]}; }
Vector4d wxyz(const Eigen::Quaterniond& q) { return {q.w(), q.x(), q.y(), q.z()}; }

// One submodule per group and map: functions of X (6 numbers), poses of 7 numbers.
template <class Group>
void bind_group(nb::module_& lie, const char* name, const char* doc) {
  nb::module_ m = lie.def_submodule(name, doc);
  m.def(
      "product", [](const Vector7d& c1, const Vector7d& c2) { return array(Group::product(pose(c1), pose(c2))); },
      "c1"_a, "c2"_a);
  m.def("inverse", [](const Vector7d& c) { return array(Group::inverse(pose(c))); }, "c"_a);
  m.def("psi", [](const Vector6d& X) { return array(Group::psi(X)); }, "X"_a, "The motion with local coordinates X.");
  m.def(
      "psi_inverse", [](const Vector7d& c) { return Group::psi_inverse(pose(c)); }, "c"_a,
      "Local coordinates of a motion.");
  m.def("tangent", &Group::tangent, "X"_a, "T(X), 6x6: V = T(X) dX/dt.");
  m.def("tangent_times", &Group::tangent_times, "X"_a, "w"_a);
  m.def("tangent_inverse", &Group::tangent_inverse, "X"_a);
  m.def("tangent_inverse_times", &Group::tangent_inverse_times, "X"_a, "w"_a);
  m.def("tangent_derivative", &Group::tangent_derivative, "X"_a, "w"_a, "d(T(X) w)/dX, 6x6.");
  m.def("commutator", &Group::commutator, "V"_a, "W"_a);
  m.def(
      "velocity", [](const Vector4d& q, const Vector6d& mixed) { return Group::velocity(quat(q), mixed); },
      "quaternion"_a, "mixed"_a, "The group's velocity of (v_WB in W, w_WB in B).");
  m.def(
      "mixed_velocity", [](const Vector4d& q, const Vector6d& V) { return Group::mixed_velocity(quat(q), V); },
      "quaternion"_a, "V"_a);
  m.def(
      "acceleration",
      [](const Vector4d& q, const Vector6d& mixed, const Vector6d& mixed_rate) {
        return Group::acceleration(quat(q), mixed, mixed_rate);
      },
      "quaternion"_a, "mixed"_a, "mixed_rate"_a);
  m.def(
      "mixed_acceleration",
      [](const Vector4d& q, const Vector6d& V, const Vector6d& Vdot) {
        return Group::mixed_acceleration(quat(q), V, Vdot);
      },
      "quaternion"_a, "V"_a, "Vdot"_a);
  m.def("tau_quaternion", &tau<QuaternionPosition, Group>, "q"_a, "X"_a, "q' of q = (position, quaternion).");
  m.def("tau_rotation_vector", &tau<RotationVectorPosition, Group>, "q"_a, "X"_a,
        "q' of q = (position, rotation vector).");
}

template <class Map>
void bind_map(nb::module_& lie, const char* r3xso3, const char* se3, const char* x) {
  bind_group<R3xSO3<Map>>(lie, r3xso3, (std::string("R^3 x SO(3); X = (displacement in W, ") + x + ").").c_str());
  bind_group<SE3<Map>>(lie, se3, (std::string("SE(3); X = (y in B, ") + x + ").").c_str());
  lie.attr(r3xso3).attr("angle") = lie.attr(se3).attr("angle") =
      nb::cpp_function(&Map::angle, "length"_a, "Rotation angle [rad] of |x|.");
}

void bind_so3(nb::module_& m) {
  m.def("hat", &sigmafmu::lie::hat, "w"_a, "3x3 matrix with hat(w) x = w cross x.");
  m.def(
      "exp", [](const Vector3d& theta) { return wxyz(exp(theta)); }, "theta"_a,
      "Unit quaternion (w, x, y, z) of a rotation vector [rad].");
  m.def(
      "log", [](const Vector4d& q) { return log(quat(q)); }, "quaternion"_a,
      "Rotation vector [rad], at most pi long, of a unit quaternion (w, x, y, z).");
  m.def("rotation_matrix", [](const Vector4d& q) { return quat(q).toRotationMatrix(); }, "quaternion"_a);
  m.def("tangent", &sigmafmu::lie::tangent, "theta"_a, "T(theta), 3x3.");
  m.def("tangent_times", &sigmafmu::lie::tangent_times, "theta"_a, "c"_a);
  m.def("tangent_inverse", &sigmafmu::lie::tangent_inverse, "theta"_a);
  m.def("tangent_inverse_times", &sigmafmu::lie::tangent_inverse_times, "theta"_a, "c"_a);
  m.def("tangent_derivative", &sigmafmu::lie::tangent_derivative, "theta"_a, "c"_a, "d(T(theta) c)/dtheta, 3x3.");
  m.def(
      "coefficients",
      [](double x) {
        const auto k = so3_coefficients(x);
        return Vector4d(k.a, k.b, k.da, k.db);
      },
      "x"_a, "(a, b, a'/t, b'/t) at t^2 = x.");
  m.def(
      "compose", [](const Vector7d& q, const Vector6d& theta) { return compose(q, theta); }, "q"_a, "theta"_a,
      "q o exp(theta) on R^3 x SO(3).");
}

}  // namespace

void bind_lie(nb::module_& lie) {
  bind_so3(lie);
  bind_map<Exponential>(lie, "r3xso3_exp", "se3_exp", "x rotation vector");
  bind_map<Cayley>(lie, "r3xso3_cayley", "se3_cayley", "x twice the Rodrigues parameters");
  bind_map<Cayley2>(lie, "r3xso3_cayley2", "se3_cayley2", "x four times the Wiener-Milenkovic parameters");
  lie.def(
      "nearest",
      [](const Vector4d& q, const Vector4d& previous) -> Vector4d { return wxyz(nearest(quat(q), quat(previous))); },
      "quaternion"_a, "previous"_a, "The quaternion or its negative, whichever is nearer to the previous one.");
}
