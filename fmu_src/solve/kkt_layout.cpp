#include "solve/kkt_layout.h"

namespace sigmafmu {

BlockLU make_kkt_solver(const BlockPattern& pattern, int sets) {
  std::vector<int> sizes = pattern.body_sizes;
  sizes.insert(sizes.end(), pattern.modal_sizes.begin(), pattern.modal_sizes.end());
  std::vector<int> stage(sizes.size(), 0);
  for (int m : pattern.joint_sizes) {
    sizes.push_back(sets * m);
    stage.push_back(1);
  }
  auto edges = pattern.body_pairs;
  edges.insert(edges.end(), pattern.modal_pairs.begin(), pattern.modal_pairs.end());
  for (const auto& i : pattern.incidences) edges.emplace_back(pattern.joint_node(i.joint), i.body);
  for (const auto& i : pattern.modal_incidences) {
    edges.emplace_back(pattern.joint_node(i.joint), pattern.modal_node(i.body));
  }
  if (sets == 2) {  // mu of a joint moves the modes of a flexible body whose frame it holds
    for (const auto& i : pattern.incidences) {
      for (std::size_t f = 0; f < pattern.modal_sizes.size(); ++f) {
        const auto [frame, modes] = pattern.modal_pairs[3 * f];
        if (frame == i.body) edges.emplace_back(pattern.joint_node(i.joint), modes);
      }
    }
  }
  return BlockLU(sizes, edges, stage);
}

}  // namespace sigmafmu
