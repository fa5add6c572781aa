// Cantilever on a hub that a motor spins up (the beam of Wu and Haug 1988, the manoeuvre of Kane, Ryan and Banerjee
// 1987, slower). The torque is an input: without it the mechanism stays at rest.
#include "model/mechanism.h"

namespace sigmafmu::models {

Mechanism SpinUpBeam() {
  Mechanism m;
  m.name = "SpinUpBeam";
  m.description = "Flexible cantilever on a hub that the motor of a revolute joint spins up";
  m.stop_time = 30.0;
  m.communication_step = 1e-2;
  m.integrator.step_size = 5e-3;

  RigidBodyDef hub;
  hub.name = "hub";
  hub.description = "hub, turns about W z";
  hub.mass = 100.0;
  hub.inertia = {500, 500, 1000};
  const int hub_index = m.multibody.add(hub);

  RigidBodyDef beam;  // along x, its frame at the root
  beam.name = "beam";
  beam.description = "flexible beam";
  beam.modal = modal_file("beam.json", 3);
  const int beam_index = m.multibody.add(beam);

  m.multibody.add(JointDef{"hubPivot", JointType::revolute, kGround, {}, hub_index, {}});
  m.multibody.add(JointDef{"clamp", JointType::fixed, hub_index, {}, beam_index, {}});

  // sections of four nodes, 0.2 m apart
  const auto section = [](int k) { return std::vector<int>{4 * k, 4 * k + 1, 4 * k + 2, 4 * k + 3}; };
  for (int k : {1, 2, 3, 4}) {
    m.add(StationDef{"beam.station" + std::to_string(k), "point of the centre line", beam_index, section(8 * k)});
  }
  m.add(StationDef{"tip", "middle of the free end", beam_index, section(40), {Vector3d::UnitY()}});
  return m;
}

}  // namespace sigmafmu::models
