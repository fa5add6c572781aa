#include "solve/order.h"

#include <algorithm>
#include <set>

namespace sigmafmu {
namespace {

class QuotientGraph {
 public:
  explicit QuotientGraph(const BlockGraph& graph)
      : sizes_(graph.sizes),
        neighbours_(graph.neighbours),
        elements_(graph.nodes()),
        members_(graph.nodes()),
        mark_(graph.nodes(), 0) {}

  // Unknowns beside a node.
  int degree(int node) {
    int sum = 0;
    for_neighbours(node, [&](int j) { sum += sizes_[j]; });
    return sum;
  }

  // Returns the neighbours of the pivot.
  const std::vector<int>& eliminate(int pivot) {
    std::vector<int>& element = members_[pivot];
    for_neighbours(pivot, [&](int j) { element.push_back(j); });  // marks them and the pivot
    for (int e : elements_[pivot]) members_[e].clear();
    const auto remove = [](std::vector<int>& list, auto from) {
      list.erase(std::remove_if(list.begin(), list.end(), from), list.end());
    };
    for (int i : element) {
      remove(neighbours_[i], [&](int j) { return mark_[j] == stamp_; });  // the new element says that as well
      remove(elements_[i], [&](int e) { return members_[e].empty(); });
      elements_[i].push_back(pivot);
    }
    return element;
  }

 private:
  template <typename Visit>
  void for_neighbours(int node, Visit visit) {
    mark_[node] = ++stamp_;
    const auto visit_new = [&](const std::vector<int>& list) {
      for (int j : list) {
        if (mark_[j] == stamp_) continue;
        mark_[j] = stamp_;
        visit(j);
      }
    };
    visit_new(neighbours_[node]);
    for (int e : elements_[node]) visit_new(members_[e]);
  }

  const std::vector<int>& sizes_;
  std::vector<std::vector<int>> neighbours_, elements_;  // of nodes
  std::vector<std::vector<int>> members_;                // of elements: nodes that are left
  std::vector<int> mark_;
  int stamp_ = 0;
};

}  // namespace

BlockGraph::BlockGraph(std::vector<int> node_sizes)
    : sizes(std::move(node_sizes)), neighbours(sizes.size()), after(sizes.size()) {}

void BlockGraph::connect(const std::vector<std::pair<int, int>>& pairs) {
  for (auto [i, j] : pairs) {
    if (i == j) continue;
    neighbours[i].push_back(j);
    neighbours[j].push_back(i);
  }
  for (std::vector<int>& list : neighbours) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
}

std::vector<int> elimination_order(const BlockGraph& graph) {
  const int nodes = graph.nodes();
  std::vector<int> waits_for(nodes), degree(nodes, -1);  // -1: eliminated, or not yet allowed
  std::vector<std::vector<int>> followers(nodes);
  for (int i = 0; i < nodes; ++i) {
    waits_for[i] = static_cast<int>(graph.after[i].size());
    for (int j : graph.after[i]) followers[j].push_back(i);
  }
  QuotientGraph quotient(graph);
  std::set<std::pair<int, int>> candidates;  // degree, node
  const auto update = [&](int i) {
    candidates.erase({degree[i], i});
    candidates.insert({degree[i] = quotient.degree(i), i});
  };
  for (int i = 0; i < nodes; ++i) {
    if (waits_for[i] == 0) update(i);
  }
  std::vector<int> order;
  while (!candidates.empty()) {
    const int pivot = candidates.begin()->second;
    candidates.erase(candidates.begin());
    order.push_back(pivot);
    for (int i : quotient.eliminate(pivot)) {
      if (waits_for[i] == 0) update(i);
    }
    for (int i : followers[pivot]) {
      if (--waits_for[i] == 0) update(i);
    }
  }
  return order;
}

std::vector<std::vector<int>> factor_pattern(const BlockGraph& graph, const std::vector<int>& order) {
  const int nodes = graph.nodes();
  std::vector<int> turn(nodes), mark(nodes, -1);
  for (int k = 0; k < nodes; ++k) turn[order[k]] = k;
  std::vector<std::vector<int>> pattern(nodes), children(nodes);
  for (int i : order) {
    std::vector<int>& later = pattern[i];
    const auto add = [&](const std::vector<int>& list) {
      for (int j : list) {
        if (turn[j] <= turn[i] || mark[j] == i) continue;
        mark[j] = i;
        later.push_back(j);
      }
    };
    add(graph.neighbours[i]);
    for (int child : children[i]) add(pattern[child]);  // it hands its ties on to the first that it ties
    std::sort(later.begin(), later.end());
    const auto first = std::min_element(later.begin(), later.end(), [&](int a, int b) { return turn[a] < turn[b]; });
    if (first != later.end()) children[*first].push_back(i);
  }
  return pattern;
}

double factorization_cost(const std::vector<int>& sizes, const std::vector<std::vector<int>>& pattern) {
  double cost = 0;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const double n = sizes[i];
    double beside = 0;
    for (int j : pattern[i]) beside += sizes[j];
    cost += n * n * n / 3 + n * n * beside + n * beside * beside;
  }
  return cost;
}

}  // namespace sigmafmu
