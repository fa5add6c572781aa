#include "fmi/resources.h"

#include <algorithm>
#include <cctype>
#include <stdexcept>

#include "model/modal_file.h"
#include "text/text.h"

namespace sigmafmu {
namespace {

std::string decode_percent(const std::string& text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '%' && i + 2 < text.size() && std::isxdigit(static_cast<unsigned char>(text[i + 1])) &&
        std::isxdigit(static_cast<unsigned char>(text[i + 2]))) {
      result += static_cast<char>(std::stoi(text.substr(i + 1, 2), nullptr, 16));
      i += 2;
    } else {
      result += text[i];
    }
  }
  return result;
}

std::string lower_case(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

// What a URI has before its first colon; empty for a path, perhaps one that starts with a drive.
std::string scheme_of(const std::string& uri) {
  const std::size_t colon = uri.find(':');
  if (colon == std::string::npos || colon < 2 || uri.find_first_of("/\\") < colon) return {};
  return uri.substr(0, colon);
}

bool is_this_machine(const std::string& host) {
  return host.empty() || host == "localhost" || host == "127.0.0.1" || host == "[::1]";
}

}  // namespace

std::string folder_of_uri(const std::string& uri) {
  const std::string scheme = scheme_of(uri);
  if (scheme.empty()) return uri;
  if (lower_case(scheme) != "file") {
    fail<std::runtime_error>("The resource location is ", utf8(uri), "; it must be a file URI, as file:///folder.");
  }
  std::string path = uri.substr(scheme.size() + 1);
  if (path.rfind("//", 0) == 0) {  // another machine's name stays: //host/folder is how Windows names it
    const std::size_t end = std::min(path.find('/', 2), path.size());
    if (is_this_machine(lower_case(path.substr(2, end - 2)))) path.erase(0, end);
  }
  path = decode_percent(path);
  if (path.find('\0') != std::string::npos) {
    fail<std::runtime_error>("The resource location is ", utf8(uri), "; %00 is not possible in a path.");
  }
  const bool drive =
      path.size() > 2 && path[0] == '/' && std::isalpha(static_cast<unsigned char>(path[1])) && path[2] == ':';
  return drive ? path.substr(1) : path;
}

std::string resources_folder(const char* location, const std::string& file) {
  if (location && *location) return folder_of_uri(location);
  fail<std::runtime_error>("The resource location is missing; this FMU reads ", file, " from there.");
}

}  // namespace sigmafmu
