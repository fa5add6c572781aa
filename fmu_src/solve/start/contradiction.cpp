#include "solve/start/contradiction.h"

#include <cmath>

#include "solve/start/least_squares.h"

namespace sigmafmu {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kSignificant = 1e-6;  // of what is left, against r

// r + A x at the x that makes it smallest, for the claims that are listened to; 0 in other rows.
VectorXd left_over(const MatrixXd& A, const VectorXd& r, const std::vector<Claim>& claims,
                   const std::vector<bool>& heard, double rank) {
  std::vector<bool> fixed(A.cols(), false);
  std::vector<int> rows, columns;
  for (std::size_t i = 0; i < claims.size(); ++i) {
    if (!heard[i]) continue;
    rows.insert(rows.end(), claims[i].rows.begin(), claims[i].rows.end());
    for (int k : claims[i].columns) fixed[k] = true;
  }
  for (int k = 0; k < A.cols(); ++k) {
    if (!fixed[k]) columns.push_back(k);
  }
  VectorXd gaps(static_cast<Eigen::Index>(rows.size())), result = VectorXd::Zero(r.size());
  for (std::size_t i = 0; i < rows.size(); ++i) gaps[static_cast<Eigen::Index>(i)] = r[rows[i]];
  if (!rows.empty() && !columns.empty()) {
    const MatrixXd part = pick(A, rows, columns);
    gaps += part * LeastSquares(part, rank * part.cwiseAbs().maxCoeff()).solve(gaps);
  }
  for (std::size_t i = 0; i < rows.size(); ++i) result[rows[i]] = gaps[static_cast<Eigen::Index>(i)];
  return result;
}

}  // namespace

Contradiction find_contradiction(const MatrixXd& A, const VectorXd& r, const std::vector<Claim>& claims,
                                 std::size_t values) {
  std::vector<bool> heard(claims.size(), true);
  const double significant = kSignificant * r.lpNorm<Eigen::Infinity>();
  // A loses rank where the least is left, and nobody comes closer to that point than the root of rounding.
  double rank = 1e-10;
  VectorXd left = left_over(A, r, claims, heard, rank);
  while (left.lpNorm<Eigen::Infinity>() < 0.5 * r.lpNorm<Eigen::Infinity>() && rank < 0.1) {
    left = left_over(A, r, claims, heard, rank *= 10);
  }
  std::size_t values_heard = values;
  for (std::size_t i = claims.size(); i-- > 0;) {
    if (i < values && values_heard == 1) continue;
    heard[i] = false;
    const VectorXd without = left_over(A, r, claims, heard, rank);
    heard[i] = !(without.lpNorm<Eigen::Infinity>() > significant);
    if (heard[i]) continue;
    left = without;
    if (i < values) --values_heard;
  }
  Contradiction result;
  for (std::size_t i = 0; i < claims.size(); ++i) {
    if (heard[i]) result.claims.push_back(static_cast<int>(i));
  }
  // What is left is shared by the equations in proportion to the combination of them that cannot be met.
  Eigen::Index row;
  const double share = left.cwiseAbs().maxCoeff(&row);
  result.row = static_cast<int>(row);
  result.gap = left.squaredNorm() / share;
  return result;
}

}  // namespace sigmafmu
