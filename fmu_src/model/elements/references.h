// What elements refer to, for their checks (validate.cpp). Each throws std::invalid_argument with one sentence.
#pragma once

#include <string>

#include "model/elements/body_references.h"

namespace sigmafmu {

struct MultibodyDef;

class References {
 public:
  explicit References(const MultibodyDef& definition) : d_(definition) {}

  void body(const std::string& name, int body) const;
  void pair(const std::string& name, int body1, int body2) const;
  void not_ground(const std::string& name, const char* verb, int body) const;
  void node(const std::string& name, int body, int node) const;
  // `what` acts on a joint; on a coordinate of a joint.
  void joint(const char* what, int joint) const;
  void coordinate(const char* what, int joint, int coordinate) const;

  const MultibodyDef& definition() const { return d_; }
  bool is_flexible(int body) const;
  int nodes(int body) const;
  std::string name_of(int body) const;

 private:
  int bodies() const;
  const MultibodyDef& d_;
};

}  // namespace sigmafmu
