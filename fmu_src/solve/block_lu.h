// LU factorization of a matrix of small dense blocks with a structurally symmetric pattern.
//
// The order of elimination and all fill-in are settled once, in the constructor; factorize and solve walk a fixed
// list of blocks and never allocate. Rows are pivoted within diagonal blocks only, so the caller gives an order in
// which every diagonal block is regular when its turn comes (bodies before the joints that hold them).
//
// BlockLU is the immutable plan; a Factorization holds the numbers and is a plain value that can be copied.
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "solve/block_kernels.h"

namespace sigmafmu {

struct Factorization {
  std::vector<double> values;
  std::vector<int> pivots;
};

class BlockLU {
 public:
  // `sizes`: rows of each node; `assigned`: blocks (i, j) that the caller writes in full before each factorization,
  // (j, i) implied; `added`: blocks that the caller adds to; nodes are eliminated by least fill within each group of equal
  // `stage`, lower stages first.
  BlockLU(const std::vector<int>& sizes, const std::vector<std::pair<int, int>>& assigned,
          const std::vector<std::pair<int, int>>& added, const std::vector<int>& stage);

  int size() const { return size_; }
  int offset(int node) const { return offset_[node]; }  // first row of a node
  Factorization make_factorization() const;

  // Block (i, j), sizes[i] x sizes[j]. It must be in the pattern.
  using Block = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
  Block block(Factorization& f, int i, int j) const {
    return {f.values.data() + table_[i * nodes_ + j], sizes_[i], sizes_[j]};
  }

  // Where block (i, j), row-major, is in Factorization::values; -1: it is zero.
  int handle(int i, int j) const { return table_[i * nodes_ + j]; }

  // Zeroes all blocks but the assigned ones.
  void clear(Factorization& f) const;
  // In place; false when a pivot vanishes or is not finite: the matrix is singular to working precision.
  [[nodiscard]] bool factorize(Factorization& f) const;
  // x := A^-1 x, size() entries.
  void solve(const Factorization& f, double* x) const;

 private:
  struct Neighbour {
    int node, size;
    int lower, upper;           // offsets of blocks (neighbour, pivot) and (pivot, neighbour)
    kernels::Solve solve;       // of the block to the right of the pivot
    kernels::Product down, up;  // (neighbour, pivot) and (pivot, neighbour) times a vector
    kernels::Product product;   // any (., pivot) times (pivot, neighbour)
  };
  struct Step {
    int node, size, diagonal;
    kernels::Factorize factorize;
    kernels::Solve solve;          // of a vector
    std::vector<Neighbour> later;  // neighbours eliminated after this node
    std::vector<int> update;       // offset of block (later[a], later[b]) at a * later.size() + b
  };

  int nodes_, size_ = 0, assigned_count_ = 0, value_count_ = 0;
  std::vector<int> sizes_, offset_;
  std::vector<int> table_;  // nodes x nodes: offset of each block in `values`, assigned ones first; -1: zero
  std::vector<Step> steps_;
};

}  // namespace sigmafmu
