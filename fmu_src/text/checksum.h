// FNV-1a, 64 bit: guards against truncation and accidents, not against attackers.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace sigmafmu {

inline constexpr std::uint64_t kNoChecksum = 0xcbf29ce484222325ULL;  // of nothing

// Of bytes that follow those of another checksum.
inline std::uint64_t checksum(std::string_view bytes, std::uint64_t before = kNoChecksum) {
  std::uint64_t hash = before;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  return hash;
}

inline std::string hexadecimal(std::uint64_t number) {
  std::string digits;
  for (unsigned end = 64; end > 0; end -= 4U) digits += "0123456789abcdef"[(number >> (end - 4U)) & 0xFU];
  return digits;
}

}  // namespace sigmafmu
