// Spatial rigid slider-crank. One degree of freedom.
#include "slider_crank.h"

namespace sigmafmu::models {

Mechanism SliderCrank() {
  RigidBodyDef rod;
  rod.name = "rod";
  rod.description = "connecting rod";
  rod.mass = 0.5;
  rod.inertia = {4e-4, 4e-3, 4e-3};
  rod.initial_position = {0.1, 0.05, 0.1};
  rod.initial_velocity = {0.12, -0.24, 0};

  Mechanism m = slider_crank(rod, {-kRodLength / 2, 0, 0}, {kRodLength / 2, 0, 0});
  m.name = "SliderCrank";
  m.description = "Spatial slider-crank: crank, connecting rod and slider in a closed loop, under gravity";
  m.stop_time = 5.0;
  return m;
}

}  // namespace sigmafmu::models
