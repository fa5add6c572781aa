// A block that slides down an inclined rail and carries a pendulum.
#include "model/mechanism.h"

namespace sigmafmu::models {

Mechanism InclinedSlider() {
  Mechanism m;
  m.name = "InclinedSlider";
  m.description = "Block on an inclined rail, with a pendulum on a universal joint";
  m.integrator.step_size = 2e-4;
  m.multibody.gravity = {0, 0, -9.81};

  RigidBodyDef block;
  block.name = "block";
  block.description = "sliding block";
  block.mass = 2;
  block.inertia = {4e-3, 5e-3, 6e-3};
  const int block_index = m.multibody.add(block);
  RigidBodyDef pendulum;
  pendulum.name = "pendulum";
  pendulum.description = "pendulum below the block";
  pendulum.mass = 0.5;
  pendulum.inertia = {5e-3, 5e-3, 2e-4};
  pendulum.initial_position = {0, 0, -0.25};
  pendulum.initial_angular_velocity = {1, 2, 0};
  const int pendulum_index = m.multibody.add(pendulum);

  const Matrix3d rail = axes_with_z({1, 0, -0.5});
  m.multibody.add(JointDef{"rail", JointType::prismatic, kGround, {{0, 0, 0}, rail}, block_index, {{0, 0, 0}, rail}});
  m.multibody.add(JointDef{"hook", JointType::universal, block_index, {{0, 0, -0.05}}, pendulum_index, {{0, 0, 0.2}}});
  return m;
}

}  // namespace sigmafmu::models
