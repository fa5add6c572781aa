// Where the resources of an FMU are.
#pragma once

#include <string>

namespace sigmafmu {

// The folder that a URI (file:///path, file:/path, file://host/path, percent-encoded) or a plain path stands for.
// Scheme and host may be in capitals; localhost, 127.0.0.1 and [::1] are no host. Throws std::runtime_error for another
// scheme and for %00.
std::string folder_of_uri(const std::string& uri);

// The folder of the resources at a location that a master gave, perhaps none. Throws std::runtime_error where it gave
// none; `file` is what is to be read from there.
std::string resources_folder(const char* location, const std::string& file);

}  // namespace sigmafmu
