// Shell patterns.
#pragma once

#include <string_view>

namespace sigmafmu {

// Whether `pattern` with * (anything), ? (one character) and [abc], [a-z] or [!abc] (one of them) matches all of
// `text`.
inline bool glob_matches(std::string_view pattern, std::string_view text) {
  for (;; pattern.remove_prefix(1), text.remove_prefix(1)) {
    if (pattern.empty()) return text.empty();
    if (pattern[0] == '*') {
      for (std::size_t i = 0; i <= text.size(); ++i) {
        if (glob_matches(pattern.substr(1), text.substr(i))) return true;
      }
      return false;
    }
    if (text.empty()) return false;
    const std::size_t end = pattern[0] == '[' ? pattern.find(']', 2) : std::string_view::npos;
    if (end == std::string_view::npos) {
      if (pattern[0] != '?' && pattern[0] != text[0]) return false;
      continue;
    }
    const bool other = pattern[1] == '!';
    bool found = false;
    for (std::size_t i = other ? 2 : 1; i < end; ++i) {
      const bool range = i + 2 < end && pattern[i + 1] == '-';
      found = found || (pattern[i] <= text[0] && text[0] <= pattern[range ? i + 2 : i]);
      if (range) i += 2;
    }
    if (found == other) return false;
    pattern.remove_prefix(end);
  }
}

}  // namespace sigmafmu
