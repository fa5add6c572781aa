// Files as text; the only input of these sources.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>

namespace sigmafmu {

// The path of a file in a folder; names and path are UTF-8.
inline std::string path_in(const std::string& folder, const std::string& name) {
  return (std::filesystem::u8path(folder) / std::filesystem::u8path(name)).u8string();
}

// The bytes of a file, none where it cannot be opened; the path is UTF-8.
inline std::optional<std::string> read_file(const std::string& path) {
  std::ifstream file(std::filesystem::u8path(path), std::ios::binary);
  if (!file) return std::nullopt;
  return std::string(std::istreambuf_iterator<char>(file), {});
}

}  // namespace sigmafmu
