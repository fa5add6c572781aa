// What the slider-cranks share: all of the mechanism but the inertia and the flexibility of its connecting rod (IFToMM
// library of computational benchmark problems; Holzinger, Arnold, Gerstmayr 2025, section 7.3). 17 joint equations.
#pragma once

#include <cmath>

#include "model/mechanism.h"

namespace sigmafmu::models {

inline constexpr double kCrankLength = 0.08, kRodLength = 0.3;  // AB, BC [m]
inline constexpr int kRod = 1;                                  // index of the rod among the bodies

// `rod` has x from B to C; `B` and `C` are these points in its frame [m]. Its initial orientation and angular velocity
// are set here, position and velocity of its frame are the caller's.
inline Mechanism slider_crank(RigidBodyDef rod, const Vector3d& B, const Vector3d& C) {
  Mechanism m;
  m.communication_step = 1e-3;
  m.integrator.step_size = 1e-4;
  m.multibody.gravity = {0, 0, -9.81};

  RigidBodyDef crank;  // z along the crank from A to B
  crank.name = "crank";
  crank.description = "crank";
  crank.mass = 0.12;
  crank.inertia = {1e-4, 1e-4, 1e-5};
  crank.initial_position = {0, 0.1, 0.16};
  crank.initial_velocity = {0, -0.24, 0};
  crank.initial_angular_velocity = {6, 0, 0};
  const int crank_index = m.multibody.add(crank);

  Matrix3d R;
  R.col(0) = Vector3d(2, -1, -2) / 3;
  R.col(1) = Vector3d(0, 2, -1) / std::sqrt(5.0);
  R.col(2) = Vector3d(5, 2, 4) / (3 * std::sqrt(5.0));
  // quaternion of R: trace(R) > 0 here
  const double w = 0.5 * std::sqrt(1 + R.trace());
  rod.initial_quaternion = {w, (R(2, 1) - R(1, 2)) / (4 * w), (R(0, 2) - R(2, 0)) / (4 * w),
                            (R(1, 0) - R(0, 1)) / (4 * w)};
  rod.initial_angular_velocity = R.transpose() * Vector3d(1.92, -0.96, 0.48);
  m.multibody.add(rod);

  RigidBodyDef slider;
  slider.name = "slider";
  slider.description = "slider on the x axis of W";
  slider.mass = 2.0;
  slider.inertia = {1e-4, 1e-4, 1e-4};
  slider.initial_position = {0.2, 0, 0};
  slider.initial_velocity = {0.24, 0, 0};
  const int slider_index = m.multibody.add(slider);

  const Matrix3d z_along_x = axes_with_z(Vector3d::UnitX());
  const Vector3d A(0, 0.1, 0.12);  // in W
  m.multibody.add(JointDef{
      "crankPivot", JointType::revolute, kGround, {A, z_along_x}, crank_index, {{0, 0, -kCrankLength / 2}, z_along_x}});
  m.multibody.add(JointDef{"crankPin", JointType::spherical, crank_index, {{0, 0, kCrankLength / 2}}, kRod, {B}});
  m.multibody.add(JointDef{"wristPin", JointType::universal, kRod, {C}, slider_index, {}});
  m.multibody.add(
      JointDef{"guide", JointType::prismatic, kGround, {{0, 0, 0}, z_along_x}, slider_index, {{0, 0, 0}, z_along_x}});
  return m;
}

}  // namespace sigmafmu::models
