// Flexible beam on a spherical joint under gravity: floating frame of reference with modal coordinates.
#include "model/mechanism.h"

namespace sigmafmu::models {

Mechanism FlexiblePendulum() {
  Mechanism m;
  m.name = "FlexiblePendulum";
  m.description =
      "Flexible pendulum: a beam that bends in two planes, held at its end by a spherical joint, under gravity";
  m.stop_time = 2.0;
  m.communication_step = 1e-3;
  m.integrator.step_size = 1e-4;
  m.multibody.gravity = {0, 0, -9.81};

  RigidBodyDef beam;  // along x, its frame at the held end
  beam.name = "beam";
  beam.description = "flexible beam";
  beam.initial_angular_velocity = {2, -3, 6};
  beam.modal = modal_file("beam.json", 4);
  const int beam_index = m.multibody.add(beam);

  JointDef pivot;
  pivot.name = "pivot";
  pivot.type = JointType::spherical;
  pivot.body2 = beam_index;
  m.multibody.add(pivot);

  // sections of four nodes, 0.1 m apart
  const auto section = [](int k) { return std::vector<int>{4 * k, 4 * k + 1, 4 * k + 2, 4 * k + 3}; };
  for (int k : {1, 2, 3, 4}) {
    m.add(StationDef{"beam.station" + std::to_string(k), "point of the centre line", beam_index, section(2 * k)});
  }
  m.add(StationDef{"tip",
                   "middle of the free end",
                   beam_index,
                   section(10),
                   {Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()}});
  return m;
}

}  // namespace sigmafmu::models
