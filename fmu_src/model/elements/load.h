// A constant force [N] at B's origin and a constant torque [N m] on a body, both in W.
#pragma once

#include <Eigen/Core>

#include "model/elements/references.h"
#include "model/parameter.h"

namespace sigmafmu {

struct LoadDef {
  static constexpr const char *kKind = "load", *kType = nullptr;  // files have one type of load

  std::string name;
  std::string description;
  int body = 0;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();

  static const std::vector<Parameter<LoadDef>>& parameters() {
    using Def = LoadDef;
    static const std::vector<Parameter<Def>> table = {
        {"force", "Force", "Constant force at the centre of mass, in W", 3, [](Def& d) { return d.force.data(); }},
        {"torque", "Torque", "Constant torque, in W", 3, [](Def& d) { return d.torque.data(); }},
    };
    return table;
  }
  void check(const References& of) const { of.not_ground(name, "acts on", body); }
  void check_values() const {}
  template <typename Use>
  void points(Use) const {}  // but for the body's origin
  template <typename Archive, typename Any>
  static void visit(Archive& archive, Any& d) {
    archive.optional("description", d.description);
    archive.body("body", d.body);
    archive.parameters(d);
  }
};

}  // namespace sigmafmu
