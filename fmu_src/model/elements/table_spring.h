// A line spring whose tension is the sum of two tables, N = S(L) + D(L') + N_actuator: monotone cubics through their
// points, straight lines beyond their ends. Either may be empty.
#pragma once

#include "model/elements/two_points.h"
#include "model/parameter.h"

namespace sigmafmu {

struct TableSpringDef : TwoPoints {
  static constexpr const char *kKind = "table spring", *kType = "table_spring";

  std::vector<double> length, force;     // S: tension [N] at lengths that increase [m]
  std::vector<double> rate, rate_force;  // D: tension [N] at rates that increase [m/s]

  static const std::vector<Parameter<TableSpringDef>>& parameters() {
    static const std::vector<Parameter<TableSpringDef>> none;
    return none;
  }
  void check_values() const;
  template <typename Archive, typename Any>
  static void visit(Archive& archive, Any& d) {
    visit_points(archive, d);
    archive.optional("length", d.length, !d.length.empty());
    archive.optional("force", d.force, !d.force.empty());
    archive.optional("rate", d.rate, !d.rate.empty());
    archive.optional("rate_force", d.rate_force, !d.rate_force.empty());
  }
};

}  // namespace sigmafmu
