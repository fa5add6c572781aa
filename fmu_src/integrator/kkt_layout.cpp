#include "integrator/kkt_layout.h"

namespace sigmafmu {

BlockLU make_kkt_solver(const BlockPattern& pattern, int sets) {
  const int bodies = static_cast<int>(pattern.body_sizes.size());
  std::vector<int> sizes = pattern.body_sizes;
  std::vector<int> stage(sizes.size(), 0);
  for (int m : pattern.joint_sizes) {
    sizes.push_back(sets * m);
    stage.push_back(1);
  }
  auto edges = pattern.body_pairs;
  for (const auto& i : pattern.incidences) edges.emplace_back(bodies + i.joint, i.body);
  return BlockLU(sizes, edges, stage);
}

}  // namespace sigmafmu
