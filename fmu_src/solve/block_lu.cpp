#include "solve/block_lu.h"

#include <algorithm>

namespace sigmafmu {

BlockLU::BlockLU(const BlockGraph& graph, const std::vector<std::pair<int, int>>& assigned,
                 const std::vector<int>& order)
    : sizes_(graph.sizes), rows_(graph.sizes.size()) {
  for (int size : sizes_) {
    offset_.push_back(size_);
    size_ += size;
  }
  const auto pattern = factor_pattern(graph, order);
  cost_ = factorization_cost(sizes_, pattern);
  for (int k : order) {
    rows_[k].emplace_back(k, -1);
    for (int j : pattern[k]) {
      rows_[k].emplace_back(j, -1);
      rows_[j].emplace_back(k, -1);
    }
  }
  for (auto& row : rows_) std::sort(row.begin(), row.end());
  for (auto [i, j] : assigned) {
    allocate(i, j);
    allocate(j, i);
  }
  assigned_count_ = value_count_;

  for (int k : order) {
    const int n = sizes_[k], later = static_cast<int>(neighbours_.size());
    for (int j : pattern[k]) {
      const auto right = kernels::pair_for(n, sizes_[j]);
      neighbours_.push_back({offset_[j], sizes_[j], allocate(j, k), allocate(k, j), right.solve,
                             kernels::pair_for(n, 1).forward, kernels::pair_for(sizes_[j], 1).forward, right.forward});
    }
    steps_.push_back({offset_[k], n, allocate(k, k), kernels::factorize_for(n), kernels::pair_for(n, 1).solve, later,
                      static_cast<int>(neighbours_.size()), static_cast<int>(updates_.size())});
    for (int a : pattern[k]) {
      for (int b : pattern[k]) updates_.push_back(allocate(a, b));
    }
  }
}

int BlockLU::handle(int i, int j) const {
  const auto& row = rows_[i];
  const auto place = std::lower_bound(row.begin(), row.end(), std::pair{j, -1});
  return place != row.end() && place->first == j ? place->second : -1;
}

// The handle of block (i, j), which has room from now on.
int BlockLU::allocate(int i, int j) {
  int& handle = std::lower_bound(rows_[i].begin(), rows_[i].end(), std::pair{j, -1})->second;
  if (handle < 0) {
    handle = value_count_;
    value_count_ += sizes_[i] * sizes_[j];
  }
  return handle;
}

Factorization BlockLU::make_factorization() const {
  return {std::vector<double>(value_count_, 0.0), std::vector<int>(size_, 0)};
}

void BlockLU::clear(Factorization& f) const { std::fill(f.values.begin() + assigned_count_, f.values.end(), 0.0); }

// Block elimination: U_kj = A_kk^-1 A_kj, A_ij -= A_ik U_kj; A_ik stays as it is.
bool BlockLU::factorize(Factorization& f) const {
  double* values = f.values.data();
  for (const Step& step : steps_) {
    double* diagonal = values + step.diagonal;
    int* pivots = f.pivots.data() + step.first;
    if (!step.factorize(step.size, diagonal, pivots)) return false;
    const Neighbour *later = neighbours_.data() + step.later, *end = neighbours_.data() + step.end;
    for (const Neighbour* b = later; b != end; ++b) b->solve(step.size, b->size, diagonal, pivots, values + b->upper);
    const int* update = updates_.data() + step.update;
    for (const Neighbour* a = later; a != end; ++a) {
      for (const Neighbour* b = later; b != end; ++b) {
        b->product(a->size, step.size, b->size, values + a->lower, values + b->upper, values + *update++);
      }
    }
  }
  return true;
}

void BlockLU::solve(const Factorization& f, double* x) const {
  const double* values = f.values.data();
  const int* pivots = f.pivots.data();
  const Neighbour* neighbours = neighbours_.data();
  for (const Step& step : steps_) {
    double* xk = x + step.first;
    step.solve(step.size, 1, values + step.diagonal, pivots + step.first, xk);
    for (const Neighbour *a = neighbours + step.later, *end = neighbours + step.end; a != end; ++a) {
      a->down(a->size, step.size, 1, values + a->lower, xk, x + a->first);
    }
  }
  for (auto step = steps_.rbegin(); step != steps_.rend(); ++step) {
    double* xk = x + step->first;
    for (const Neighbour *a = neighbours + step->later, *end = neighbours + step->end; a != end; ++a) {
      a->up(step->size, a->size, 1, values + a->upper, x + a->first, xk);
    }
  }
}

}  // namespace sigmafmu
