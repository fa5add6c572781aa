// Values of JSON as the files of a mechanism have them; only what reads or writes JSON includes this.
#pragma once

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "text/text.h"

namespace sigmafmu::json {

using Json = nlohmann::ordered_json;

// A value in a message: its beginning, cut between characters.
inline std::string excerpt(const Json& value) {
  const std::string text = value.dump();
  std::size_t end = std::min<std::size_t>(text.size(), 40);
  const auto continues = [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; };
  while (end < text.size() && continues(text[end])) --end;
  return text.substr(0, end);
}

// The text with replacement characters for bytes that are no UTF-8.
inline std::string with_replacements(const std::string& text) {
  try {
    Json(text).dump();
    return text;
  } catch (const Json::exception&) {
    const std::string quoted = Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
    return quoted.substr(1, quoted.size() - 2);
  }
}

// Throws std::runtime_error with one sentence that begins with `complaint`. Keys that are there twice are refused, and
// deep nesting, since values are destroyed and printed by recursion.
inline Json parse_json(const std::string& text, const std::string& complaint) {
  constexpr int kDeepest = 16;
  std::vector<std::set<std::string>> keys;  // of the objects around
  const auto check = [&](int depth, Json::parse_event_t event, const Json& value) {
    using Event = Json::parse_event_t;
    if (depth > kDeepest) fail<std::runtime_error>(complaint, "its lists are nested deeper than ", kDeepest, ".");
    if (event == Event::object_start) keys.emplace_back();
    if (event == Event::object_end) keys.pop_back();
    if (event == Event::key && !keys.back().insert(value.get<std::string>()).second) {
      fail<std::runtime_error>(complaint, "the key ", value.get<std::string>(), " is there twice.");
    }
    return true;
  };
  try {
    return Json::parse(text, check);
  } catch (const Json::exception& e) {
    fail<std::runtime_error>(complaint, with_replacements(e.what()), ".");  // it quotes what it reads
  }
}

inline double number(const Json& value, const std::string& name) {
  if (!value.is_number()) fail<std::runtime_error>(name, " is ", excerpt(value), "; it must be a number.");
  return value.get<double>();
}

inline const Json& list(const Json& value, const std::string& name, std::size_t size) {
  if (!value.is_array()) fail<std::runtime_error>(name, " must be a list.");
  if (value.size() != size) {
    fail<std::runtime_error>(name, " has ", value.size(), " entries; it must have ", size, ".");
  }
  return value;
}

inline std::string at(const std::string& name, std::size_t i) { return name + "[" + std::to_string(i) + "]"; }

}  // namespace sigmafmu::json
