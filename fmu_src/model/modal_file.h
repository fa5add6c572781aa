// Files of modal data, which make bodies of a mechanism flexible: JSON, as docs/modes.md describes it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "model/mechanism.h"
#include "text/checksum.h"

namespace sigmafmu {

// Names of the files that the mechanism reads.
std::vector<std::string> modal_files(const Mechanism& mechanism);

// Reads the modal data of every body that has a file, from `folder` (UTF-8); returns a checksum of the files, which
// goes on from that of others. Throws an exception with one sentence that names the file when it is missing, no such
// file, or holds data that the mechanism cannot use.
std::uint64_t load_modal_files(Mechanism& mechanism, const std::string& folder, std::uint64_t before = kNoChecksum);

// The text with replacement characters for bytes that are no UTF-8, which FMI's strings are.
std::string utf8(const std::string& text);

}  // namespace sigmafmu
