#include "solve/kkt_layout.h"

namespace sigmafmu {
namespace {

using Lists = std::vector<std::vector<int>>;

// The bodies of each constraint. Poses come first among the unknowns, so they have the numbers of the bodies.
Lists bodies_of_constraints(const BlockPattern& pattern) {
  Lists bodies(pattern.constraint_count());
  for (const auto& i : pattern.incidences) {
    if (pattern.unknowns[i.unknown].pose) bodies[i.constraint].push_back(i.unknown);
  }
  return bodies;
}

// The unknowns that each constraint acts on.
Lists unknowns_of_constraints(const BlockPattern& pattern) {
  Lists unknowns(pattern.constraint_count());
  for (const auto& i : pattern.incidences) unknowns[i.constraint].push_back(i.unknown);
  return unknowns;
}

// The modes of each body, and of the ground, if any constraint acts on them.
Lists modes_in_joints(const BlockPattern& pattern) {
  Lists modes(pattern.bodies + 1);
  for (const auto& i : pattern.incidences) {
    if (pattern.unknowns[i.unknown].pose) continue;
    std::vector<int>& of_body = modes[pattern.unknowns[i.unknown].body];
    if (of_body.empty()) of_body.push_back(i.unknown);
  }
  return modes;
}

// Bodies that each constraint follows at least, so that its equations are regular when all bodies that are left stand
// still.
//
// A spanning tree of the bodies, rooted on the ground, ties each body to its parent by a joint of its own. Any joint
// closes a way along the tree from one of its bodies to the other. The bodies of this way, but for the one next to the
// root, move against each other as freely as in the mechanism, whatever stands still besides: the joint follows these.
// For a joint of the tree it is the child alone. A constraint of more bodies follows the ways from its first to each.
//
// Modes that joints act on move as freely, those of the body next to the root as well: a loop follows them, too, since
// it may be they alone that let it close.
Lists unknowns_on_ways(const BlockPattern& pattern) {
  const int bodies = pattern.bodies, ground = bodies;
  Lists ends = bodies_of_constraints(pattern), beside(bodies + 1);
  for (auto& of_constraint : ends) {
    if (of_constraint.size() < 2) of_constraint.resize(2, ground);
    for (std::size_t k = 1; k < of_constraint.size(); ++k) {
      beside[of_constraint[0]].push_back(of_constraint[k]);
      beside[of_constraint[k]].push_back(of_constraint[0]);
    }
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

  const Lists modes = modes_in_joints(pattern);
  std::vector<bool> hangs(bodies, false);  // on its parent, by a joint before
  Lists before;
  for (const auto& of_constraint : ends) {
    before.emplace_back();
    std::vector<int>& way = before.back();
    std::vector<int> nearest_to_root;
    for (std::size_t k = 1; k < of_constraint.size(); ++k) {
      int a = of_constraint[0], b = of_constraint[k];
      while (a != b) {
        int& lower = depth[a] > depth[b] ? a : b;
        way.push_back(lower);
        lower = parent[lower];
      }
      nearest_to_root.push_back(a);
    }
    if (way.size() == 1 && !hangs[way[0]]) {
      hangs[way[0]] = true;
      continue;
    }
    std::vector<int> closed = way;
    closed.insert(closed.end(), nearest_to_root.begin(), nearest_to_root.end());
    for (int body : closed) way.insert(way.end(), modes[body].begin(), modes[body].end());
  }
  return before;
}

BlockLU make_plan(const BlockPattern& pattern, Kkt form) {
  const bool stabilized = form == Kkt::stabilized;
  std::vector<int> sizes;
  sizes.reserve(pattern.unknowns.size() + 2 * pattern.constraint_sizes.size());
  for (const Unknown& unknown : pattern.unknowns) sizes.push_back(unknown.size);
  for (int of_multipliers = 0; of_multipliers < (stabilized ? 2 : 1); ++of_multipliers) {
    sizes.insert(sizes.end(), pattern.constraint_sizes.begin(), pattern.constraint_sizes.end());
  }

  std::vector<std::pair<int, int>> assigned;
  const int pairs = form == Kkt::index1 ? pattern.inertia_pairs : static_cast<int>(pattern.pairs.size());
  assigned.reserve(pairs + 2 * pattern.incidences.size());
  for (int p = 0; p < pairs; ++p) assigned.emplace_back(pattern.pairs[p].row, pattern.pairs[p].column);
  Lists constraints(pattern.unknown_count());  // on each unknown
  for (const auto& i : pattern.incidences) {
    assigned.emplace_back(pattern.lambda_node(i.constraint), i.unknown);
    if (stabilized) assigned.emplace_back(pattern.mu_node(i.constraint), i.unknown);
    constraints[i.unknown].push_back(i.constraint);
  }
  BlockGraph graph(sizes);
  graph.connect(assigned);
  // Both bodies of a joint before it cost more, but that keeps apart what light bodies say and what heavy ones say: the
  // index-1 form is to be solved to the last digits.
  const Lists before = form == Kkt::index1 ? unknowns_of_constraints(pattern) : unknowns_on_ways(pattern);
  for (int c = 0; c < pattern.constraint_count(); ++c) graph.after[pattern.lambda_node(c)] = before[c];
  if (stabilized) {  // mu waits for nothing: B B^T is regular from the beginning
    std::vector<std::pair<int, int>> added;
    for (int p = 0; p < pattern.inertia_pairs; ++p) {  // mu moves all unknowns of the bodies that it acts on
      for (int c : constraints[pattern.pairs[p].column]) added.emplace_back(pattern.mu_node(c), pattern.pairs[p].row);
    }
    for (const auto& together : constraints) {  // B B^T
      for (int a : together) {
        for (int b : together) added.emplace_back(pattern.mu_node(a), pattern.mu_node(b));
        if (pattern.velocity_equations[a] == 0) continue;
        for (int b : together) added.emplace_back(pattern.lambda_node(a), pattern.mu_node(b));
      }
    }
    for (int c = 0; c < pattern.constraint_count(); ++c) {  // of soft constraints
      added.emplace_back(pattern.lambda_node(c), pattern.mu_node(c));
    }
    graph.connect(added);
  }
  return BlockLU(graph, assigned, elimination_order(graph));
}

}  // namespace

std::shared_ptr<const BlockLU> KktPlans::get(const BlockPattern& pattern, Kkt form) {
  std::shared_ptr<const BlockLU>& plan = (*plans_)[static_cast<std::size_t>(form)];
  if (!plan) plan = std::make_shared<const BlockLU>(make_plan(pattern, form));
  return plan;
}

}  // namespace sigmafmu
