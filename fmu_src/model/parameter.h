// The numbers of an element that files, checks and the FMU know alike: one table for each type of element.
#pragma once

#include <string>
#include <vector>

namespace sigmafmu {

template <typename Def>
struct Parameter {
  const char* name;  // of the FMU's variable; its key in files is written like_this
  const char* type;  // of real_types(): unit and limits
  const char* description;
  int size;                             // 0: a scalar
  double* (*values)(Def&);              // the first of them
  const char* type_of_angle = nullptr;  // where it belongs to a coordinate that is one
};

// `freeLength` -> `free_length`.
std::string key_of(const std::string& name);

}  // namespace sigmafmu
