#include "integrator/coordinates/local_coordinates_of.h"

namespace sigmafmu {

std::unique_ptr<LocalCoordinates> make_r3xso3_coordinates(const System& system, const IntegratorSettings& settings) {
  return on_group<lie::R3xSO3>(system, settings);
}

std::unique_ptr<LocalCoordinates> make_local_coordinates(const System& system, const IntegratorSettings& settings) {
  return settings.is(LieGroup::se3) ? make_se3_coordinates(system, settings)
                                    : make_r3xso3_coordinates(system, settings);
}

}  // namespace sigmafmu
