// A tendon: a length L = sum_i c_i x_i of coordinates of any joints, angles [rad] with their turns and displacements
// [m], with the tension N = k (L - L_0) + d L' + N_actuator. It does -c_i N along coordinate i, on the second body of
// its joint: a cable over pulleys of radius c_i, muscles over several joints, fixed tendons of MJCF.
#pragma once

#include <string>
#include <vector>

#include "model/elements/references.h"
#include "model/parameter.h"

namespace sigmafmu {

struct TendonDef {
  static constexpr const char *kKind = "tendon", *kType = nullptr;

  struct Term {
    int joint = 0;
    int coordinate = 0;      // of the joint
    double coefficient = 1;  // c_i [m/rad] or [1]
  };
  std::string name;
  std::vector<Term> terms;
  double stiffness = 0;    // k [N/m]
  double damping = 0;      // d [N s/m]
  double free_length = 0;  // L_0 [m], of any sign as L is

  static const std::vector<Parameter<TendonDef>>& parameters() {
    using Def = TendonDef;
    static const std::vector<Parameter<Def>> table = {
        {"stiffness", "Stiffness", "Stiffness of the tendon", 0, [](Def& d) { return &d.stiffness; }},
        {"damping", "Damping", "Damping of the tendon", 0, [](Def& d) { return &d.damping; }},
        {"freeLength", "Displacement", "Length at which the tendon's spring has no force", 0,
         [](Def& d) { return &d.free_length; }},
    };
    return table;
  }
  void check(const References& of) const;
  void check_values() const;
  template <typename Use>
  void points(Use) const {}  // but for those of its joints
  template <typename Archive, typename Any>
  static void visit(Archive& archive, Any& d) {
    archive.required("terms", d.terms);
    archive.parameters(d);
  }
};

}  // namespace sigmafmu
