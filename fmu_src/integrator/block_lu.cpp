#include "integrator/block_lu.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sigmafmu {
namespace {

// All kernels: column-major, leading dimension = number of rows.

// C (m x n) -= A (m x K) B (K x n).
template <int K>
void subtract_product(int m, int n, const double* A, const double* B, double* C) {
  for (int j = 0; j < n; ++j) {
    const double* b = B + j * K;
    double* c = C + j * m;
    for (int i = 0; i < m; ++i) {
      double sum = A[i] * b[0];
      for (int l = 1; l < K; ++l) sum += A[i + l * m] * b[l];
      c[i] -= sum;
    }
  }
}

void subtract_product(int m, int n, int k, const double* A, const double* B, double* C) {
  switch (k) {  // the sizes of rigid bodies and of joints get unrolled loops
    case 3:
      return subtract_product<3>(m, n, A, B, C);
    case 6:
      return subtract_product<6>(m, n, A, B, C);
    default:
      for (int j = 0; j < n; ++j) {
        for (int l = 0; l < k; ++l) {
          const double b = B[l + j * k];
          for (int i = 0; i < m; ++i) C[i + j * m] -= A[i + l * m] * b;
        }
      }
  }
}

// Row-pivoted LU of an n x n block in place: unit lower L, upper U, diagonal stored inverted.
bool factorize_block(int n, double* A, int* pivots) {
  double largest = 0;
  for (int i = 0; i < n * n; ++i) largest = std::max(largest, std::abs(A[i]));
  const double tiny = 16 * n * std::numeric_limits<double>::epsilon() * largest;
  for (int k = 0; k < n; ++k) {
    int p = k;
    for (int i = k + 1; i < n; ++i) {
      if (std::abs(A[i + k * n]) > std::abs(A[p + k * n])) p = i;
    }
    pivots[k] = p;
    if (!(std::abs(A[p + k * n]) > tiny)) return false;  // also catches NaN
    if (p != k) {
      for (int j = 0; j < n; ++j) std::swap(A[k + j * n], A[p + j * n]);
    }
    const double inverse = 1.0 / A[k + k * n];
    A[k + k * n] = inverse;
    for (int i = k + 1; i < n; ++i) A[i + k * n] *= inverse;
    for (int j = k + 1; j < n; ++j) {
      const double u = A[k + j * n];
      for (int i = k + 1; i < n; ++i) A[i + j * n] -= A[i + k * n] * u;
    }
  }
  return std::isfinite(largest);
}

// X (n x m) := L^-1 P X.
void solve_lower(int n, int m, const double* LU, const int* pivots, double* X) {
  for (int j = 0; j < m; ++j) {
    double* x = X + j * n;
    for (int k = 0; k < n; ++k) std::swap(x[k], x[pivots[k]]);
    for (int k = 0; k < n; ++k) {
      const double xk = x[k];
      for (int i = k + 1; i < n; ++i) x[i] -= LU[i + k * n] * xk;
    }
  }
}

// X (m x n) := X U^-1.
void solve_upper_from_right(int m, int n, const double* LU, double* X) {
  for (int k = 0; k < n; ++k) {
    double* xk = X + k * m;
    const double inverse = LU[k + k * n];
    for (int i = 0; i < m; ++i) xk[i] *= inverse;
    for (int j = k + 1; j < n; ++j) {
      const double u = LU[k + j * n];
      double* xj = X + j * m;
      for (int i = 0; i < m; ++i) xj[i] -= xk[i] * u;
    }
  }
}

// x := U^-1 x.
void solve_upper(int n, const double* LU, double* x) {
  for (int k = n - 1; k >= 0; --k) {
    x[k] *= LU[k + k * n];
    for (int i = 0; i < k; ++i) x[i] -= LU[i + k * n] * x[k];
  }
}

}  // namespace

BlockLU::BlockLU(const std::vector<int>& sizes, const std::vector<std::pair<int, int>>& edges,
                 const std::vector<int>& stage)
    : nodes_(static_cast<int>(sizes.size())), sizes_(sizes), table_(sizes.size() * sizes.size(), -1) {
  for (int size : sizes_) {
    offset_.push_back(size_);
    size_ += size;
  }
  std::vector<char> nonzero(nodes_ * nodes_, 0);
  for (int i = 0; i < nodes_; ++i) nonzero[i * nodes_ + i] = 1;
  for (auto [i, j] : edges) nonzero[i * nodes_ + j] = nonzero[j * nodes_ + i] = 1;

  std::vector<char> done(nodes_, 0);
  for (int count = 0; count < nodes_; ++count) {
    int best = -1, best_degree = 0;
    for (int i = 0; i < nodes_; ++i) {
      if (done[i]) continue;
      int degree = 0;
      for (int j = 0; j < nodes_; ++j) {
        if (!done[j] && j != i && nonzero[i * nodes_ + j]) degree += sizes_[j];
      }
      if (best < 0 || stage[i] < stage[best] || (stage[i] == stage[best] && degree < best_degree)) {
        best = i;
        best_degree = degree;
      }
    }
    Step step{best, sizes_[best], 0, {}, {}};
    done[best] = 1;
    for (int j = 0; j < nodes_; ++j) {
      if (!done[j] && nonzero[best * nodes_ + j]) step.later.push_back({j, sizes_[j], 0, 0});
    }
    for (const Neighbour& a : step.later) {
      for (const Neighbour& b : step.later) nonzero[a.node * nodes_ + b.node] = 1;
    }
    steps_.push_back(std::move(step));
  }

  auto allocate = [&](int i, int j) {
    int& entry = table_[i * nodes_ + j];
    if (entry < 0) {
      entry = value_count_;
      value_count_ += sizes_[i] * sizes_[j];
    }
    return entry;
  };
  for (Step& step : steps_) {
    step.diagonal = allocate(step.node, step.node);
    for (Neighbour& a : step.later) {
      a.lower = allocate(a.node, step.node);
      a.upper = allocate(step.node, a.node);
    }
  }
  for (Step& step : steps_) {
    for (const Neighbour& a : step.later) {
      for (const Neighbour& b : step.later) step.update.push_back(block_offset(a.node, b.node));
    }
  }
}

Factorization BlockLU::make_factorization() const {
  return {std::vector<double>(value_count_, 0.0), std::vector<int>(size_, 0)};
}

BlockLU::Block BlockLU::block(Factorization& f, int i, int j) const {
  return {f.values.data() + block_offset(i, j), sizes_[i], sizes_[j]};
}

void BlockLU::set_zero(Factorization& f) const { std::fill(f.values.begin(), f.values.end(), 0.0); }

bool BlockLU::factorize(Factorization& f) const {
  double* values = f.values.data();
  for (const Step& step : steps_) {
    double* diagonal = values + step.diagonal;
    const int* pivots = f.pivots.data() + offset_[step.node];
    if (!factorize_block(step.size, diagonal, f.pivots.data() + offset_[step.node])) return false;
    for (const Neighbour& a : step.later) {
      solve_lower(step.size, a.size, diagonal, pivots, values + a.upper);
      solve_upper_from_right(a.size, step.size, diagonal, values + a.lower);
    }
    const int* update = step.update.data();
    for (const Neighbour& a : step.later) {
      for (const Neighbour& b : step.later) {
        subtract_product(a.size, b.size, step.size, values + a.lower, values + b.upper, values + *update++);
      }
    }
  }
  return true;
}

void BlockLU::solve(const Factorization& f, double* x) const {
  const double* values = f.values.data();
  for (const Step& step : steps_) {
    double* xk = x + offset_[step.node];
    solve_lower(step.size, 1, values + step.diagonal, f.pivots.data() + offset_[step.node], xk);
    for (const Neighbour& a : step.later) {
      subtract_product(a.size, 1, step.size, values + a.lower, xk, x + offset_[a.node]);
    }
  }
  for (auto step = steps_.rbegin(); step != steps_.rend(); ++step) {
    double* xk = x + offset_[step->node];
    for (const Neighbour& a : step->later) {
      subtract_product(step->size, 1, a.size, values + a.upper, x + offset_[a.node], xk);
    }
    solve_upper(step->size, values + step->diagonal, xk);
  }
}

}  // namespace sigmafmu
