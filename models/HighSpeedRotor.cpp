// High-speed rotor on two flexible supports at 200 000 rpm (Holzinger, Arnold, Gerstmayr 2025, section 7.2, Table 1).
#include "model/mechanism.h"

namespace sigmafmu::models {

Mechanism HighSpeedRotor() {
  Mechanism m;
  m.name = "HighSpeedRotor";
  m.description = "Rigid rotor at 200 000 rpm on two spring-damper supports, tilted by a constant torque";
  m.stop_time = 1.0;
  m.communication_step = 1e-4;
  m.integrator.step_size = 5e-6;

  RigidBodyDef rotor;
  rotor.name = "rotor";
  rotor.description = "rotor, axis along its x";
  rotor.mass = 1.223;
  rotor.inertia = {0.001541, 0.000812, 0.000812};
  rotor.initial_angular_velocity = {20944, 0, 0};
  const int rotor_index = m.multibody.add(rotor);

  const double stiffness = 4000, damping = 5.165093;     // [N/m], [N s/m]
  const double left_length = 0.11, right_length = 0.09;  // [m]
  SpringDamperDef left;
  left.name = "leftSupport";
  left.body2 = rotor_index;
  left.point1 = left.point2 = {-left_length, 0, 0};
  left.stiffness = {stiffness, stiffness, stiffness};
  left.damping = {damping, damping, damping};
  m.multibody.add(left);

  SpringDamperDef right = left;  // free along the axis
  right.name = "rightSupport";
  right.point1 = right.point2 = {right_length, 0, 0};
  right.stiffness.x() = right.damping.x() = 0;
  m.multibody.add(right);

  LoadDef load;  // Eq. (86): weight of a rotor whose disk sits off the middle of the supports
  load.name = "load";
  load.description = "constant load on the rotor";
  load.body = rotor_index;
  load.torque = {0, 0, -((left_length + right_length) / 2 - left_length) * rotor.mass * 9.81};
  m.multibody.add(load);
  return m;
}

}  // namespace sigmafmu::models
