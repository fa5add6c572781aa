// A bar with next to no inertia about its axis, on a spring-damper at each end.
#include "model/mechanism.h"

namespace sigmafmu::models {

Mechanism SupportedBar() {
  Mechanism m;
  m.name = "SupportedBar";
  m.description = "Slender bar on two spring-dampers, under gravity";
  m.integrator.step_size = 5e-4;
  m.multibody.gravity = {0, 0, -9.81};

  RigidBodyDef bar;
  bar.name = "bar";
  bar.description = "bar along its x";
  bar.mass = 0.3;
  bar.inertia = {1e-9, 1e-2, 1e-2};
  bar.initial_position = {0, 0, 0.02};
  bar.initial_angular_velocity = {0, 0.5, 0.2};
  const int index = m.multibody.add(bar);

  SpringDamperDef support;
  support.name = "left";
  support.body2 = index;
  support.point1 = support.point2 = {-0.3, 0, 0};
  support.stiffness = {400, 400, 400};
  support.damping = {0.5, 0.5, 0.5};
  m.multibody.add(support);
  support.name = "right";
  support.point1 = support.point2 = {0.3, 0, 0};
  m.multibody.add(support);
  return m;
}

}  // namespace sigmafmu::models
