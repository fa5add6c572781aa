#include "integrator/coordinates/local_coordinates_of.h"

namespace sigmafmu {

std::unique_ptr<LocalCoordinates> make_se3_coordinates(const System& system, const IntegratorSettings& settings) {
  return on_group<lie::SE3>(system, settings);
}

}  // namespace sigmafmu
