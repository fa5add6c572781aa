// Files of modal data, which make bodies of a mechanism flexible: JSON, as docs/modes.md describes it.
#pragma once

#include <string>

#include "model/mechanism.h"

namespace sigmafmu {

// Reads the modal data of every flexible body from files in `folder` (UTF-8). Throws std::runtime_error with one
// sentence that names the file when it is missing, no such file, or holds data that the mechanism cannot use.
void load_modal_files(Mechanism& mechanism, const std::string& folder);

// The folder that a URI (file:///path, file:/path, file://host/path, percent-encoded) or a plain path stands for.
// Scheme and host may be in capitals; localhost, 127.0.0.1 and [::1] are no host. Throws std::runtime_error for another
// scheme and for %00.
std::string folder_of_uri(const std::string& uri);

}  // namespace sigmafmu
