// Heavy top on a spherical joint (Bruels, Cardona, Arnold 2012; Holzinger, Arnold, Gerstmayr 2025, section 7.1).
#include "model/mechanism.h"

namespace sigmafmu::models {

Mechanism HeavyTop() {
  Mechanism m;
  m.name = "HeavyTop";
  m.description = "Heavy top: a spinning rigid body held by a spherical joint, under gravity";
  m.stop_time = 2.0;
  m.communication_step = 1e-3;
  m.integrator.step_size = 2.5e-4;
  m.multibody.gravity = {0, 0, -9.81};

  RigidBodyDef top;
  top.name = "top";
  top.description = "spinning top";
  top.mass = 15.0;
  top.inertia = {0.234375, 0.46875, 0.234375};
  top.initial_position = {0, 1, 0};
  top.initial_angular_velocity = {0, 150, -4.61538};
  top.initial_velocity = top.initial_angular_velocity.cross(top.initial_position);
  const int top_index = m.multibody.add(top);

  JointDef pivot;
  pivot.name = "pivot";
  pivot.type = JointType::spherical;
  pivot.body2 = top_index;
  pivot.frame2.origin = {0, -1, 0};
  m.multibody.add(pivot);
  return m;
}

}  // namespace sigmafmu::models
