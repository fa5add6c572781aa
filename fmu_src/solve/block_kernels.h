// Dense kernels for the blocks of BlockLU, all row-major without gaps.
//
// Rows are contiguous, so every inner loop runs along a row and vectorizes. Blocks are as small as bodies and joints:
// for these sizes the loops are unrolled; kernels_for() picks them once, other sizes share a general version.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace sigmafmu::kernels {

// x . y. N = n as a constant, or 0.
template <int N>
double dot(int n, const double* x, const double* y) {
  if constexpr (N > 0) {
    using Vector = Eigen::Map<const Eigen::Matrix<double, N, 1>>;
    return Vector(x).dot(Vector(y));
  } else {
    double sum = 0;
    for (int i = 0; i < n; ++i) sum += x[i] * y[i];
    return sum;
  }
}

// C (m x n) -= A (m x k) B (k x n). N, K: n, k as constants, or 0.
template <int K, int N>
void subtract_product(int m, int k, int n, const double* A, const double* B, double* C) {
  if constexpr (K > 0 && N > 0) {
    for (int i = 0; i < m; ++i, A += K, C += N) {
      double sum[N];
      for (int j = 0; j < N; ++j) sum[j] = C[j];
      for (int l = 0; l < K; ++l) {
        if (N > 1 && A[l] == 0) continue;  // rows of joints have many zeros
        for (int j = 0; j < N; ++j) sum[j] -= A[l] * B[l * N + j];
      }
      for (int j = 0; j < N; ++j) C[j] = sum[j];
    }
  } else {
    for (int i = 0; i < m; ++i) {
      for (int l = 0; l < k; ++l) {
        for (int j = 0; j < n; ++j) C[i * n + j] -= A[i * k + l] * B[l * n + j];
      }
    }
  }
}

// Column k of the LU factorization below. N = n as a constant, or 0.
//
// A pivot vanishes if it is rounding of its own column, whose size the column of U keeps: multipliers of light bodies
// and of heavy ones, forces and motions may differ by any factor in a block.
template <int N>
inline bool eliminate(int n, int k, double* A, int* pivots) {
  if constexpr (N > 0) n = N;
  const double rounding = 16 * n * std::numeric_limits<double>::epsilon();
  double* row_k = A + k * n;
  int p = k;
  double largest = std::abs(row_k[k]), above = 0;
  for (int i = 0; i < k; ++i) above = std::max(above, std::abs(A[i * n + k]));
  for (int i = k + 1; i < n; ++i) {
    const double x = std::abs(A[i * n + k]);
    if (x > largest) largest = x, p = i;
  }
  pivots[k] = p;
  if (!(largest > rounding * std::max(above, largest))) return false;  // also catches NaN and infinity
  if (p != k) {
    for (int j = 0; j < n; ++j) std::swap(row_k[j], A[p * n + j]);
  }
  const double inverse = 1.0 / row_k[k];
  row_k[k] = inverse;
  for (int i = k + 1; i < n; ++i) {
    double* row_i = A + i * n;
    if (row_i[k] == 0) continue;  // translations and rotations of a body often do not mix
    const double l = row_i[k] * inverse;
    row_i[k] = l;
    for (int j = k + 1; j < n; ++j) row_i[j] -= l * row_k[j];
  }
  return true;
}

template <int N, int... K>
inline bool eliminate_all(double* A, int* pivots, std::integer_sequence<int, K...>) {
  return (... && eliminate<N>(N, K, A, pivots));  // constant k: every loop is unrolled
}

// LU of an n x n block in place with row pivoting: unit lower L, the diagonal of U stored inverted. False when a pivot
// vanishes or is not finite.
template <int N>
bool factorize(int n, double* A, int* pivots) {
  if constexpr (N > 0) n = N;
  if constexpr (N > 0) {
    return eliminate_all<N>(A, pivots, std::make_integer_sequence<int, N>());
  } else {
    for (int k = 0; k < n; ++k) {
      if (!eliminate<0>(n, k, A, pivots)) return false;
    }
    return true;
  }
}

// X (n x m) := A^-1 X. M = m as a constant, or 0.
template <int N, int M>
void solve(int n, int m, const double* LU, const int* pivots, double* X) {
  if constexpr (N > 0) n = N;
  if constexpr (M > 0) m = M;
  for (int k = 0; k < n; ++k) {
    if (pivots[k] == k) continue;
    for (int j = 0; j < m; ++j) std::swap(X[k * m + j], X[pivots[k] * m + j]);
  }
  // Row i minus rows [first, last) of X with the factors of row i of LU, then times `scale`.
  const auto reduce = [=](int i, int first, int last, double scale) {
    if constexpr (M > 0) {
      double row[M];
      for (int j = 0; j < M; ++j) row[j] = X[i * M + j];
      for (int k = first; k < last; ++k) {
        const double factor = LU[i * n + k];
        if (M > 1 && factor == 0) continue;
        for (int j = 0; j < M; ++j) row[j] -= factor * X[k * M + j];
      }
      for (int j = 0; j < M; ++j) X[i * M + j] = row[j] * scale;
    } else {
      for (int k = first; k < last; ++k) {
        for (int j = 0; j < m; ++j) X[i * m + j] -= LU[i * n + k] * X[k * m + j];
      }
      for (int j = 0; j < m; ++j) X[i * m + j] *= scale;
    }
  };
  for (int i = 1; i < n; ++i) reduce(i, 0, i, 1.0);
  for (int i = n - 1; i >= 0; --i) reduce(i, i + 1, n, LU[i * n + i]);
}

using Product = void (*)(int m, int k, int n, const double* A, const double* B, double* C);
using Factorize = bool (*)(int n, double* A, int* pivots);
using Solve = void (*)(int n, int m, const double* LU, const int* pivots, double* X);

// Kernels of an n x n pivot block and a block of m columns beside it.
struct Pair {
  Solve solve;      // (n x n)^-1 (n x m)
  Product forward;  // (any x n) (n x m)
};

template <int N>
Pair pair_for(int m) {
  switch (m) {
    case 1:
      return {solve<N, 1>, subtract_product<N, 1>};
    case 2:
      return {solve<N, 2>, subtract_product<N, 2>};
    case 3:
      return {solve<N, 3>, subtract_product<N, 3>};
    case 4:
      return {solve<N, 4>, subtract_product<N, 4>};
    case 5:
      return {solve<N, 5>, subtract_product<N, 5>};
    case 6:
      return {solve<N, 6>, subtract_product<N, 6>};
    default:
      return {solve<0, 0>, subtract_product<0, 0>};
  }
}

// Rigid bodies have 6 velocities, constraints 1 to 6 equations.
inline Pair pair_for(int n, int m) {
  switch (n) {
    case 1:
      return pair_for<1>(m);
    case 2:
      return pair_for<2>(m);
    case 3:
      return pair_for<3>(m);
    case 4:
      return pair_for<4>(m);
    case 5:
      return pair_for<5>(m);
    case 6:
      return pair_for<6>(m);
    default:
      return {solve<0, 0>, subtract_product<0, 0>};
  }
}

inline Factorize factorize_for(int n) {
  switch (n) {
    case 1:
      return factorize<1>;
    case 2:
      return factorize<2>;
    case 3:
      return factorize<3>;
    case 4:
      return factorize<4>;
    case 5:
      return factorize<5>;
    case 6:
      return factorize<6>;
    default:
      return factorize<0>;
  }
}

}  // namespace sigmafmu::kernels
