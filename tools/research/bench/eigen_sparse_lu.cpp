// Times Eigen's SparseLU on one matrix: analyzed once, then factorized and solved again and again.
//
// Standard input: size, nonzeros and repeats as 32-bit integers; the matrix in compressed columns, starts and rows as
// 32-bit integers and values as doubles; the right side. Standard output: the fastest factorization and solution in
// seconds, on a line, then the solution as doubles.
#include <Eigen/Sparse>
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <vector>

namespace {

template <typename T>
bool read(std::vector<T>& values) {
  return std::fread(values.data(), sizeof(T), values.size(), stdin) == values.size();
}

}  // namespace

int main() {
  std::vector<std::int32_t> sizes(3);
  if (!read(sizes)) return 1;
  const int n = sizes[0], nonzeros = sizes[1], repeats = sizes[2];
  std::vector<std::int32_t> starts(static_cast<std::size_t>(n) + 1), rows(static_cast<std::size_t>(nonzeros));
  std::vector<double> values(rows.size()), right_side(static_cast<std::size_t>(n));
  if (!read(starts) || !read(rows) || !read(values) || !read(right_side)) return 1;
  using Matrix = Eigen::SparseMatrix<double>;
  Matrix A(n, n);
  A.resizeNonZeros(nonzeros);
  std::copy(starts.begin(), starts.end(), A.outerIndexPtr());
  std::copy(rows.begin(), rows.end(), A.innerIndexPtr());
  std::copy(values.begin(), values.end(), A.valuePtr());
  const Eigen::VectorXd b = Eigen::VectorXd::Map(right_side.data(), n);

  Eigen::SparseLU<Matrix> lu;
  lu.analyzePattern(A);
  using Clock = std::chrono::steady_clock;
  const auto seconds = [](Clock::duration d) { return std::chrono::duration<double>(d).count(); };
  double factorizing = std::numeric_limits<double>::infinity(), solving = factorizing;
  Eigen::VectorXd x;
  for (int k = 0; k < repeats; ++k) {
    const Clock::time_point t0 = Clock::now();
    lu.factorize(A);
    const Clock::time_point t1 = Clock::now();
    if (lu.info() != Eigen::Success) return 2;
    x = lu.solve(b);
    factorizing = std::min(factorizing, seconds(t1 - t0));
    solving = std::min(solving, seconds(Clock::now() - t1));
  }
  std::printf("%.9g %.9g\n", factorizing, solving);
  return std::fwrite(x.data(), sizeof(double), static_cast<std::size_t>(n), stdout) == static_cast<std::size_t>(n) ? 0
                                                                                                                   : 1;
}
