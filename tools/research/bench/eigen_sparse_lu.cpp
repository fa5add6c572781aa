// Times Eigen's SparseLU on one matrix: analyzed once, then factorized and solved again and again.
//
// Standard input: rows, nonzeros and repeats as 64-bit integers; rows, columns (64-bit integers) and values (doubles)
// of the entries; the right side. Standard output: the fastest factorization and solution in seconds, on a line, then
// the solution as doubles.
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
  std::vector<std::int64_t> sizes(3);
  if (!read(sizes)) return 1;
  const auto n = static_cast<Eigen::Index>(sizes[0]);
  const auto entries = static_cast<std::size_t>(sizes[1]);
  std::vector<std::int64_t> rows(entries), columns(entries);
  std::vector<double> values(entries), right_side(static_cast<std::size_t>(n));
  if (!read(rows) || !read(columns) || !read(values) || !read(right_side)) return 1;
  std::vector<Eigen::Triplet<double>> triplets;
  for (std::size_t k = 0; k < entries; ++k) {
    triplets.emplace_back(static_cast<int>(rows[k]), static_cast<int>(columns[k]), values[k]);
  }
  Eigen::SparseMatrix<double> A(n, n);
  A.setFromTriplets(triplets.begin(), triplets.end());
  const Eigen::VectorXd b = Eigen::VectorXd::Map(right_side.data(), n);

  Eigen::SparseLU<Eigen::SparseMatrix<double>> lu;
  lu.analyzePattern(A);
  using Clock = std::chrono::steady_clock;
  const auto seconds = [](Clock::duration d) { return std::chrono::duration<double>(d).count(); };
  double factorizing = std::numeric_limits<double>::infinity(), solving = factorizing;
  Eigen::VectorXd x;
  for (std::int64_t k = 0; k < sizes[2]; ++k) {
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
