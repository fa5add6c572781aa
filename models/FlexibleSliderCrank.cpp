// The spatial slider-crank with a flexible connecting rod: floating frame of reference with modal coordinates. Five
// degrees of freedom.
#include "slider_crank.h"

namespace sigmafmu::models {

Mechanism FlexibleSliderCrank() {
  RigidBodyDef rod;  // its frame in B; both ends stay on its x axis
  rod.name = "rod";
  rod.description = "flexible connecting rod";
  rod.initial_position = {0, 0.1, 0.2};
  rod.initial_velocity = {0, -0.48, 0};
  rod.modal = modal_file("rod.json", 4);

  Mechanism m = slider_crank(rod, Vector3d::Zero(), {kRodLength, 0, 0});
  m.name = "FlexibleSliderCrank";
  m.description = "Spatial slider-crank with a connecting rod that bends in two planes, under gravity";
  m.stop_time = 2.0;

  // sections of four nodes, 0.03 m apart
  const auto section = [](int k) { return std::vector<int>{4 * k, 4 * k + 1, 4 * k + 2, 4 * k + 3}; };
  for (int k : {1, 2, 3, 4}) {
    m.add(StationDef{"rod.station" + std::to_string(k), "point of the centre line", kRod, section(2 * k)});
  }
  m.add(StationDef{
      "middle", "middle of the rod", kRod, section(5), {Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()}});
  return m;
}

}  // namespace sigmafmu::models
