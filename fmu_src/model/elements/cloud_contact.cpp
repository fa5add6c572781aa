#include "model/elements/cloud_contact.h"

#include "model/validation.h"

namespace sigmafmu {

void CloudContactDef::check_values() const {
  validation::check_frame(name + ".frame1", frame1);
  if (points2.empty()) validation::fail(name, " has no points; it must have at least one.");
  for (std::size_t i = 0; i < points2.size(); ++i) {
    validation::check_point(name + ".points2[" + std::to_string(i + 1) + "]", points2[i]);
  }
  validation::check_positive(name + ".radius", radius, "m");
  surface.check_values(name);
}

}  // namespace sigmafmu
