#include "solve/kkt_layout.h"

namespace sigmafmu {

BlockLU make_kkt_solver(const BlockPattern& pattern, int sets) {
  std::vector<int> sizes, stage;
  for (const Unknown& unknown : pattern.unknowns) {
    sizes.push_back(unknown.size);
    stage.push_back(0);
  }
  for (int m : pattern.constraint_sizes) {
    sizes.push_back(sets * m);
    stage.push_back(1);
  }
  std::vector<std::pair<int, int>> written, added;
  for (const auto& pair : pattern.pairs) written.emplace_back(pair.row, pair.column);
  std::vector<std::vector<int>> constraints(pattern.unknown_count());
  for (const auto& [constraint, unknown, offset] : pattern.incidences) {
    written.emplace_back(pattern.constraint_node(constraint), unknown);
    constraints[unknown].push_back(pattern.constraint_node(constraint));
  }
  if (sets == 2) {  // mu of a constraint moves all unknowns of a body whose pose or modes it acts on
    for (int p = 0; p < pattern.inertia_pairs; ++p) {
      for (int node : constraints[pattern.pairs[p].column]) added.emplace_back(node, pattern.pairs[p].row);
    }
  }
  return BlockLU(sizes, written, added, stage);
}

}  // namespace sigmafmu
