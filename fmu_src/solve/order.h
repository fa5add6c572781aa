// Order of elimination of a matrix of blocks with a symmetric pattern, a graph of nodes: minimum degree.
//
// Of the nodes that may be eliminated the next one is that with the fewest unknowns beside it, the first of several. To
// eliminate it ties its neighbours together. The quotient graph (George, Liu, "The evolution of the minimum degree
// ordering algorithm", SIAM Review 31, 1989) stores no such ties: an eliminated node becomes an element, the list of
// its neighbours, and absorbs the elements that it was in. So the graph never grows, and degrees are exact.
#pragma once

#include <utility>
#include <vector>

namespace sigmafmu {

struct BlockGraph {
  std::vector<int> sizes;                    // unknowns of each node
  std::vector<std::vector<int>> neighbours;  // of each node, in ascending order, without the node itself
  std::vector<std::vector<int>> after;       // the nodes that must be eliminated before each

  explicit BlockGraph(std::vector<int> node_sizes);
  int nodes() const { return static_cast<int>(sizes.size()); }
  // Adds the blocks (i, j) and (j, i) of each pair; pairs may be repeated.
  void connect(const std::vector<std::pair<int, int>>& pairs);
};

std::vector<int> elimination_order(const BlockGraph& graph);

// The neighbours that each node has when its turn comes, in ascending order: the blocks of the factors.
std::vector<std::vector<int>> factor_pattern(const BlockGraph& graph, const std::vector<int>& order);

// Multiplications of a factorization with that pattern.
double factorization_cost(const std::vector<int>& sizes, const std::vector<std::vector<int>>& pattern);

}  // namespace sigmafmu
