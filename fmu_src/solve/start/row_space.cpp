#include "solve/start/row_space.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace sigmafmu {

using Eigen::VectorXd;

RowSpace::RowSpace(const Eigen::SparseMatrix<double>& transposed, double zero)
    : columns_(transposed.rows()), zero_(zero) {
  constexpr double kRounding = 4 * std::numeric_limits<double>::epsilon();  // what is left where parts cancel
  std::vector<double> x(columns_, 0.0);
  std::vector<int> support, pivot(columns_, -1);  // pivot: the reflection whose first column it is
  std::vector<char> in_support(columns_, 0);
  std::vector<std::vector<int>> reflections_of(columns_);  // those that change a column, in their order
  std::vector<int> queued;                                 // the last row for which a reflection was waiting
  std::priority_queue<int, std::vector<int>, std::greater<>> waiting;

  for (int row = 0; row < transposed.cols(); ++row) {
    const auto reach = [&](int column, int after) {
      if (in_support[column]) return;
      in_support[column] = 1;
      support.push_back(column);
      const auto& all = reflections_of[column];
      for (auto k = std::upper_bound(all.begin(), all.end(), after); k != all.end(); ++k) {
        if (queued[*k] != row) waiting.push(*k);
        queued[*k] = row;
      }
    };
    for (Eigen::SparseMatrix<double>::InnerIterator entry(transposed, row); entry; ++entry) {
      x[entry.row()] = entry.value();
      reach(static_cast<int>(entry.row()), -1);
    }
    while (!waiting.empty()) {
      const int k = waiting.top();
      waiting.pop();
      const Reflection& H = reflections_[k];
      const double along = H.along(x);
      if (std::abs(along) * H.length < kRounding) continue;  // else rounding would spread over all rows
      for (std::size_t i = 0; i < H.columns.size(); ++i) {
        x[H.columns[i]] -= along * H.v[i];
        reach(H.columns[i], k);
      }
    }

    std::vector<std::pair<int, double>> entries;
    Reflection H;
    double square = 0;
    for (int column : support) {
      if (pivot[column] >= 0) {
        if (x[column] != 0) entries.emplace_back(pivot[column], x[column]);
      } else if (std::abs(x[column]) > kRounding) {
        H.columns.push_back(column);
        H.v.push_back(x[column]);
        square += x[column] * x[column];
      }
      x[column] = 0;
      in_support[column] = 0;
    }
    support.clear();
    const double part = std::sqrt(square);
    if (!(part > zero)) {
      dependences_.push_back({row, part, std::move(entries)});
      continue;
    }
    smallest_part_ = std::min(smallest_part_, part);
    const auto smaller = [](double a, double b) { return std::abs(a) < std::abs(b); };
    const auto largest = std::max_element(H.v.begin(), H.v.end(), smaller) - H.v.begin();
    std::swap(H.v[0], H.v[largest]);
    std::swap(H.columns[0], H.columns[largest]);
    const double diagonal = std::copysign(part, -H.v[0]);
    H.v[0] -= diagonal;
    H.scale = 1 / (part * std::abs(H.v[0]));
    H.length = std::sqrt(2 / H.scale);
    const int k = rank();
    entries.emplace_back(k, diagonal);
    pivot[H.columns[0]] = k;
    for (int column : H.columns) reflections_of[column].push_back(k);
    independent_.push_back({row, std::move(entries)});
    reflections_.push_back(std::move(H));
    queued.push_back(-1);
  }
}

std::vector<RowSpace::Dependence> RowSpace::dependences() const {
  std::vector<Dependence> result = dependences_;
  VectorXd rest = VectorXd::Zero(rank());
  std::priority_queue<int> left;
  std::vector<char> is_left(rank(), 0);
  const auto add = [&](int k, double value) {
    rest[k] += value;
    if (is_left[k] == 0) left.push(k);
    is_left[k] = 1;
  };
  for (Dependence& dependence : result) {
    for (const auto& [k, value] : dependence.weights) add(k, value);
    dependence.weights.clear();
    while (!left.empty()) {
      const int k = left.top();
      left.pop();
      is_left[k] = 0;
      const auto& [row, entries] = independent_[k];
      const double share = std::exchange(rest[k], 0.0) / entries.back().second;
      if (std::abs(share) < zero_) continue;
      for (std::size_t i = 0; i + 1 < entries.size(); ++i) add(entries[i].first, -share * entries[i].second);
      dependence.weights.emplace_back(row, share);
    }
  }
  return result;
}

VectorXd RowSpace::solve(const VectorXd& r) const {
  VectorXd y(rank()), x = VectorXd::Zero(columns_);
  for (int k = 0; k < rank(); ++k) {
    const auto& [row, entries] = independent_[k];
    double sum = -r[row];
    for (std::size_t i = 0; i + 1 < entries.size(); ++i) sum -= entries[i].second * y[entries[i].first];
    y[k] = sum / entries.back().second;
    x[reflections_[k].columns[0]] = y[k];
  }
  for (int k = rank() - 1; k >= 0; --k) {
    const Reflection& H = reflections_[k];
    const double along = H.along(x);
    for (std::size_t i = 0; i < H.columns.size(); ++i) x[H.columns[i]] -= along * H.v[i];
  }
  return x;
}

}  // namespace sigmafmu
