// All that modelDescription.xml, documentation and terminals tell of a mechanism, as JSON: numbers are texts, written
// as the XML has them. tools/sigmafmu/contents makes the files of an FMU of it.
#pragma once

#include <string>

#include "model/mechanism.h"

namespace sigmafmu {

// The mechanism has its modal data. Throws std::exception with one sentence for one that is wrong or cannot move.
std::string describe(Mechanism mechanism);

}  // namespace sigmafmu
