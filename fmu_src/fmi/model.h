// What tells one FMU from another: defined in a file that the build generates for each mechanism.
#pragma once

#include "model/mechanism.h"

namespace sigmafmu {

Mechanism make_mechanism();
extern const char* const kGuid;  // hash of modelDescription.xml

}  // namespace sigmafmu
