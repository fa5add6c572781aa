// Two links: the first on a hinge, the second on a ball.
#include <cmath>

#include "model/mechanism.h"

namespace sigmafmu::models {

Mechanism HangingChain() {
  Mechanism m;
  m.name = "HangingChain";
  m.description = "Two links under gravity, the upper one on a hinge, the lower one on a ball";
  m.integrator.step_size = 2e-4;
  m.multibody.gravity = {0, 0, -9.81};

  RigidBodyDef link;
  link.name = "upper";
  link.description = "link on the hinge";
  link.mass = 0.4;
  link.inertia = {3e-3, 3.2e-3, 4e-4};
  link.initial_position = {0, 0.15, 0};
  link.initial_quaternion = {std::sqrt(0.5), -std::sqrt(0.5), 0, 0};  // z of the link along y
  const int upper = m.multibody.add(link);
  link.name = "lower";
  link.description = "link on the ball";
  link.initial_position = {0, 0.45, 0};
  link.initial_angular_velocity = {0, 0.5, 3};
  const int lower = m.multibody.add(link);

  const Matrix3d hinge = axes_with_z(Vector3d::UnitX());
  m.multibody.add(JointDef{"hinge", JointType::revolute, kGround, {{0, 0, 0}, hinge}, upper, {{0, 0, -0.15}, hinge}});
  m.multibody.add(JointDef{"ball", JointType::spherical, upper, {{0, 0, 0.15}}, lower, {{0, 0, -0.15}}});
  return m;
}

}  // namespace sigmafmu::models
