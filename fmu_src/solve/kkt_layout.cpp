#include "solve/kkt_layout.h"

namespace sigmafmu {
namespace {

using Lists = std::vector<std::vector<int>>;

// The bodies of each joint.
Lists bodies_of_joints(const BlockPattern& pattern) {
  Lists bodies(pattern.joint_sizes.size());
  for (const auto& i : pattern.incidences) bodies[i.joint].push_back(i.body);
  return bodies;
}

// Bodies that each joint follows at least, so that its equations are regular when all bodies that are left stand still.
//
// A spanning tree of the bodies, rooted on the ground, ties each body to its parent by a joint of its own. Any joint
// closes a way along the tree from one of its bodies to the other. The bodies of this way, but for the one next to the
// root, move against each other as freely as in the mechanism, whatever stands still besides: the joint follows these.
// For a joint of the tree it is the child alone.
Lists bodies_on_ways(const BlockPattern& pattern) {
  const int bodies = static_cast<int>(pattern.body_sizes.size()), ground = bodies;
  Lists ends = bodies_of_joints(pattern), beside(bodies + 1);
  for (auto& pair : ends) {
    pair.resize(2, ground);
    beside[pair[0]].push_back(pair[1]);
    beside[pair[1]].push_back(pair[0]);
  }

  std::vector<int> parent(bodies + 1, -1), depth(bodies + 1, -1), found;
  for (int root = ground; root >= 0; --root) {  // the ground, then bodies that nothing ties to it
    if (depth[root] >= 0) continue;
    depth[root] = 0;
    found.assign(1, root);
    for (std::size_t next = 0; next < found.size(); ++next) {  // breadth first: short ways
      for (int i : beside[found[next]]) {
        if (depth[i] >= 0) continue;
        depth[i] = depth[found[next]] + 1;
        parent[i] = found[next];
        found.push_back(i);
      }
    }
  }

  Lists before;
  for (const auto& pair : ends) {
    before.emplace_back();
    for (int a = pair[0], b = pair[1]; a != b;) {
      int& lower = depth[a] > depth[b] ? a : b;
      before.back().push_back(lower);
      lower = parent[lower];
    }
  }
  return before;
}

BlockLU make_plan(const BlockPattern& pattern, Kkt form) {
  const bool stabilized = form == Kkt::stabilized;
  const std::size_t bodies = pattern.body_sizes.size(), flexible = pattern.modal_sizes.size();
  std::vector<int> sizes = pattern.body_sizes;
  sizes.insert(sizes.end(), pattern.modal_sizes.begin(), pattern.modal_sizes.end());
  for (int m : pattern.joint_sizes) sizes.push_back(stabilized ? 2 * m : m);

  auto assigned = pattern.body_pairs, modal = pattern.modal_pairs;
  if (form == Kkt::index1) {  // M couples nothing but the frame and the modes of a body
    assigned.resize(bodies);
    modal.resize(3 * flexible);
  }
  assigned.insert(assigned.end(), modal.begin(), modal.end());
  for (const auto& i : pattern.incidences) assigned.emplace_back(pattern.joint_node(i.joint), i.body);
  for (const auto& i : pattern.modal_incidences) {
    assigned.emplace_back(pattern.joint_node(i.joint), pattern.modal_node(i.body));
  }
  BlockGraph graph(sizes);
  if (stabilized) {
    Lists joints(bodies);  // at each body
    for (const auto& i : pattern.incidences) joints[i.body].push_back(pattern.joint_node(i.joint));
    for (std::size_t f = 0; f < flexible; ++f) {  // mu of a joint moves the modes of a body whose frame it holds
      const auto [frame, modes] = pattern.modal_pairs[3 * f];
      for (int joint : joints[frame]) assigned.emplace_back(joint, modes);
    }
    std::vector<std::pair<int, int>> meeting;  // B B^T
    for (const auto& together : joints) {
      for (int a : together) {
        for (int b : together) meeting.emplace_back(a, b);
      }
    }
    graph.connect(meeting);
  }
  graph.connect(assigned);
  // Both bodies of a joint before it cost more, but that keeps apart what light bodies say and what heavy ones say: the
  // index-1 form is to be solved to the last digits.
  const Lists before = form == Kkt::index1 ? bodies_of_joints(pattern) : bodies_on_ways(pattern);
  for (std::size_t j = 0; j < before.size(); ++j) graph.after[pattern.joint_node(static_cast<int>(j))] = before[j];
  return BlockLU(graph, assigned, elimination_order(graph));
}

}  // namespace

std::shared_ptr<const BlockLU> KktPlans::get(const BlockPattern& pattern, Kkt form) {
  std::shared_ptr<const BlockLU>& plan = (*plans_)[static_cast<std::size_t>(form)];
  if (!plan) plan = std::make_shared<const BlockLU>(make_plan(pattern, form));
  return plan;
}

}  // namespace sigmafmu
