// What the parts of validate (definition.h, mechanism.h) share.
#pragma once

#include <cmath>
#include <stdexcept>
#include <string>

#include "model/definition.h"
#include "text/text.h"

namespace sigmafmu::validation {

template <typename... Parts>
[[noreturn]] void fail(const Parts&... parts) {
  sigmafmu::fail<std::invalid_argument>(parts...);
}

inline void require_finite(const std::string& name, const Vector3d& x, const char* unit) {
  for (int i = 0; i < 3; ++i) {
    if (!std::isfinite(x[i])) fail(name, "[", i + 1, "] is ", x[i], " ", unit, "; it must be finite.");
  }
}

// Of validate, what a System is built by, whatever the numbers are: names, bodies, nodes, modal data.
void validate_structure(const MultibodyDef& definition);

void validate_body(const MultibodyDef& definition, const RigidBodyDef& body);  // without its modal data
void validate_modal(const std::string& body, const ModalDef& modal);
// What is said of the file itself, whether it has been read or not.
void validate_modal_file(const std::string& body, const ModalDef& modal);

}  // namespace sigmafmu::validation
