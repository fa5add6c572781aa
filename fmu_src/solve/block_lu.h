// LU factorization of a matrix of small dense blocks with a structurally symmetric pattern.
//
// The order of elimination and all fill-in are settled once, in the constructor; factorize and solve walk a fixed
// list of blocks and never allocate. Rows are pivoted within diagonal blocks only, so the caller gives an order in
// which every diagonal block is regular when its turn comes.
//
// BlockLU is the immutable plan; a Factorization holds the numbers and is a plain value that can be copied.
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "solve/block_kernels.h"
#include "solve/order.h"

namespace sigmafmu {

struct Factorization {
  std::vector<double> values;
  std::vector<int> pivots;
};

class BlockLU {
 public:
  // `assigned`: blocks (i, j) of the graph, (j, i) implied, that the caller writes in full before each factorization;
  // to the others and to diagonal ones it may add, after clear(). `order`: of elimination.
  BlockLU(const BlockGraph& graph, const std::vector<std::pair<int, int>>& assigned, const std::vector<int>& order);

  int size() const { return size_; }
  int nodes() const { return static_cast<int>(sizes_.size()); }
  int offset(int node) const { return offset_[node]; }  // first row of a node
  double cost() const { return cost_; }                 // multiplications of factorize()
  Factorization make_factorization() const;

  // Where block (i, j) is, row-major, among the values of a factorization; -1 where there is none.
  int handle(int i, int j) const;
  // Block (i, j), sizes[i] x sizes[j]. It must be there.
  using Block = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
  Block block(Factorization& f, int i, int j) const { return block(f, handle(i, j), sizes_[i], sizes_[j]); }
  static Block block(Factorization& f, int handle, int rows, int columns) {
    return {f.values.data() + handle, rows, columns};
  }

  // Zeroes all blocks but the assigned ones.
  void clear(Factorization& f) const;
  // In place; false when a pivot vanishes or is not finite: the matrix is singular to working precision.
  [[nodiscard]] bool factorize(Factorization& f) const;
  // x := A^-1 x, size() entries.
  void solve(const Factorization& f, double* x) const;

 private:
  struct Neighbour {
    int first, size;            // row
    int lower, upper;           // offsets of blocks (neighbour, pivot) and (pivot, neighbour)
    kernels::Solve solve;       // of the block to the right of the pivot
    kernels::Product down, up;  // (neighbour, pivot) and (pivot, neighbour) times a vector
    kernels::Product product;   // any (., pivot) times (pivot, neighbour)
  };
  struct Step {
    int first, size, diagonal;  // first: row
    kernels::Factorize factorize;
    kernels::Solve solve;  // of a vector
    int later, end;        // in neighbours_: those eliminated after this node
    int update;            // in updates_: offset of block (neighbour a, neighbour b), a major
  };

  int allocate(int i, int j);

  int size_ = 0, assigned_count_ = 0, value_count_ = 0;
  double cost_;
  std::vector<int> sizes_, offset_;
  std::vector<std::vector<std::pair<int, int>>> rows_;  // of each node: columns in ascending order, with their handles
  std::vector<Step> steps_;
  std::vector<Neighbour> neighbours_;
  std::vector<int> updates_;
};

}  // namespace sigmafmu
