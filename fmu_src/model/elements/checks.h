// Checks of the numbers of elements (validate.cpp). Each throws std::invalid_argument with one sentence.
#pragma once

#include <string>

#include "model/elements/frame.h"

namespace sigmafmu::validation {

// Finite [m].
void check_point(const std::string& name, const Eigen::Vector3d& point);
// A finite origin and orthonormal, right-handed axes.
void check_frame(const std::string& name, const Frame& frame);
void check_positive(const std::string& name, double value, const char* unit);

}  // namespace sigmafmu::validation
