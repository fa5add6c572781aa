// Names of elements (bodies, joints, forces, stations, sensors) as beginnings of the names of FMI variables.
#pragma once

#include <map>
#include <string>

namespace sigmafmu::validation {

// Whether it consists of letters, digits and _ and begins with no digit: an identifier in C and in FMI's structured
// naming convention.
bool is_identifier(const std::string& name);

// Each throws std::invalid_argument with one sentence that says what is wrong with a name.
class Names {
 public:
  // `kind` is "body", "joint", ...; `index` counts within it.
  void add(const std::string& name, const char* kind, std::size_t index);
  // When all are there: none of them is the name of a variable of another, like the element rod.position of rod.
  void check_variables() const;

 private:
  std::map<std::string, const char*> kinds_;
};

}  // namespace sigmafmu::validation
