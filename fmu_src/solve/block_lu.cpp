#include "solve/block_lu.h"

#include <algorithm>

namespace sigmafmu {

BlockLU::BlockLU(const std::vector<int>& sizes, const std::vector<std::pair<int, int>>& assigned,
                 const std::vector<std::pair<int, int>>& added, const std::vector<int>& stage)
    : nodes_(static_cast<int>(sizes.size())), sizes_(sizes), table_(sizes.size() * sizes.size(), -1) {
  for (int size : sizes_) {
    offset_.push_back(size_);
    size_ += size;
  }
  auto allocate = [&](int i, int j) {
    int& entry = table_[i * nodes_ + j];
    if (entry < 0) {
      entry = value_count_;
      value_count_ += sizes_[i] * sizes_[j];
    }
    return entry;
  };
  for (auto [i, j] : assigned) {
    allocate(i, j);
    allocate(j, i);
  }
  assigned_count_ = value_count_;
  for (auto [i, j] : added) {
    allocate(i, j);
    allocate(j, i);
  }
  for (int i = 0; i < nodes_; ++i) allocate(i, i);

  std::vector<char> done(nodes_, 0);
  for (int count = 0; count < nodes_; ++count) {
    int best = -1, best_degree = 0;
    for (int i = 0; i < nodes_; ++i) {
      if (done[i]) continue;
      int degree = 0;
      for (int j = 0; j < nodes_; ++j) {
        if (!done[j] && j != i && table_[i * nodes_ + j] >= 0) degree += sizes_[j];
      }
      if (best < 0 || stage[i] < stage[best] || (stage[i] == stage[best] && degree < best_degree)) {
        best = i;
        best_degree = degree;
      }
    }
    done[best] = 1;
    const int n = sizes_[best];
    Step step{best, n, table_[best * nodes_ + best], kernels::factorize_for(n), kernels::pair_for(n, 1).solve, {}, {}};
    for (int j = 0; j < nodes_; ++j) {
      if (done[j] || table_[best * nodes_ + j] < 0) continue;
      const auto right = kernels::pair_for(n, sizes_[j]);
      step.later.push_back({j, sizes_[j], table_[j * nodes_ + best], table_[best * nodes_ + j], right.solve,
                            kernels::pair_for(n, 1).forward, kernels::pair_for(sizes_[j], 1).forward, right.forward});
    }
    for (const Neighbour& a : step.later) {
      for (const Neighbour& b : step.later) step.update.push_back(allocate(a.node, b.node));
    }
    steps_.push_back(std::move(step));
  }
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
    int* pivots = f.pivots.data() + offset_[step.node];
    if (!step.factorize(step.size, diagonal, pivots)) return false;
    for (const Neighbour& b : step.later) b.solve(step.size, b.size, diagonal, pivots, values + b.upper);
    const int* update = step.update.data();
    for (const Neighbour& a : step.later) {
      for (const Neighbour& b : step.later) {
        b.product(a.size, step.size, b.size, values + a.lower, values + b.upper, values + *update++);
      }
    }
  }
  return true;
}

void BlockLU::solve(const Factorization& f, double* x) const {
  const double* values = f.values.data();
  for (const Step& step : steps_) {
    double* xk = x + offset_[step.node];
    step.solve(step.size, 1, values + step.diagonal, f.pivots.data() + offset_[step.node], xk);
    for (const Neighbour& a : step.later) a.down(a.size, step.size, 1, values + a.lower, xk, x + offset_[a.node]);
  }
  for (auto step = steps_.rbegin(); step != steps_.rend(); ++step) {
    double* xk = x + offset_[step->node];
    for (const Neighbour& a : step->later) a.up(step->size, a.size, 1, values + a.upper, x + offset_[a.node], xk);
  }
}

}  // namespace sigmafmu
