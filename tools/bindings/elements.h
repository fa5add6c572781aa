// The part of the definitions in sigmafmu._core that has the forces.
#pragma once

#include <nanobind/nanobind.h>

#include "model/definition.h"

void bind_elements(nanobind::module_& m);  // after Frame
void bind_element_lists(nanobind::class_<sigmafmu::MultibodyDef>& c);
