// A mechanism as text: JSON, the same for those of models/ and those of users.
//
// All that a Mechanism says is in it, under the names of json_tables.h; numbers are read back as the same bits. Bodies
// are referred to by name, the ground is `ground`, modal data are in files of their own. Keys may be left out where the
// definition has a default; what is not set, as a joint's initial angle, has no key.
#pragma once

#include <map>
#include <string>

#include "model/mechanism.h"

namespace sigmafmu {

// Both throw std::invalid_argument with one sentence, which begins with the path of what is wrong, as
// `joints[3].bodies[0]`: from_json for text that is no JSON, unknown, missing and repeated keys, values of another type
// and names of no body, to_json for what JSON cannot hold. What the numbers mean is left to validate.
std::string to_json(const Mechanism& mechanism);
Mechanism from_json(const std::string& text);

// A JSON object of texts, by their keys. Throws std::invalid_argument for anything else.
std::map<std::string, std::string> texts_from_json(const std::string& text);

}  // namespace sigmafmu
