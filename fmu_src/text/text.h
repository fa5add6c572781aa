// Texts for people: messages of errors, warnings and the log. Numbers look the same whatever locale a master has set
// for its process, `1234567.5` and never `1.234.567,5`: no other stream is used in these sources, a test sees to it.
#pragma once

#include <locale>
#include <sstream>
#include <string>

namespace sigmafmu {

// A stream that writes numbers with so many significant digits; 17 tell any two apart.
inline std::ostringstream text_stream(int digits = 17) {
  std::ostringstream stream;
  stream.imbue(std::locale::classic());
  stream.precision(digits);
  return stream;
}

template <typename... Parts>
std::string text(const Parts&... parts) {
  std::ostringstream stream = text_stream();
  (stream << ... << parts);
  return stream.str();
}

template <typename Error, typename... Parts>
[[noreturn]] void fail(const Parts&... parts) {
  throw Error(text(parts...));
}

}  // namespace sigmafmu
