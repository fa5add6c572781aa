#include "solve/start/least_squares.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <cmath>
#include <vector>

namespace sigmafmu {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct LeastSquares::Decomposition : Eigen::CompleteOrthogonalDecomposition<MatrixXd> {};

LeastSquares::LeastSquares(const MatrixXd& A, double zero) : decomposition_(std::make_unique<Decomposition>()) {
  const double first_pivot = std::sqrt(A.colwise().squaredNorm().maxCoeff());
  decomposition_->setThreshold(first_pivot > zero ? zero / first_pivot : 1.0);
  decomposition_->compute(A);
}
LeastSquares::~LeastSquares() = default;

VectorXd LeastSquares::solve(const VectorXd& r) const { return -decomposition_->solve(r); }

MatrixXd LeastSquares::beyond(const MatrixXd& B) const {
  MatrixXd turned = B;
  turned.applyOnTheLeft(decomposition_->householderQ().adjoint());
  return turned.bottomRows(B.rows() - decomposition_->rank());
}

void solve_in_turn(const MatrixXd* A, int count, const VectorXd& r, double zero, VectorXd* y) {
  if (count == 0) return;
  if (A[0].size() == 0 || A[0].cwiseAbs().maxCoeff() < zero) {
    y[0].setZero(A[0].cols());
    solve_in_turn(A + 1, count - 1, r, zero, y + 1);
    return;
  }
  const LeastSquares first(A[0], zero);
  std::vector<MatrixXd> others;
  for (int i = 1; i < count; ++i) others.push_back(first.beyond(A[i]));
  solve_in_turn(others.data(), count - 1, first.beyond(r), zero, y + 1);
  VectorXd rest = r;
  for (int i = 1; i < count; ++i) rest += A[i] * y[i];
  y[0] = first.solve(rest);
}

VectorXd solve_definite(const MatrixXd& H, const VectorXd& b) { return H.llt().solve(b); }

MassScaling::MassScaling(const MatrixXd& M) : U_(M.llt().matrixU()) {}

MatrixXd MassScaling::scaled(const MatrixXd& A) const {
  return U_.triangularView<Eigen::Upper>().solve<Eigen::OnTheRight>(A);
}

VectorXd MassScaling::unscaled(const VectorXd& y) const { return U_.triangularView<Eigen::Upper>().solve(y); }

MatrixXd pick(const MatrixXd& A, const std::vector<int>& rows, const std::vector<int>& columns) {
  MatrixXd result(static_cast<Index>(rows.size()), static_cast<Index>(columns.size()));
  for (Index j = 0; j < result.cols(); ++j) {
    for (Index i = 0; i < result.rows(); ++i) result(i, j) = A(rows[i], columns[j]);
  }
  return result;
}

MatrixXd pick_columns(const MatrixXd& A, const std::vector<int>& columns) {
  MatrixXd result(A.rows(), static_cast<Index>(columns.size()));
  for (Index j = 0; j < result.cols(); ++j) result.col(j) = A.col(columns[j]);
  return result;
}

}  // namespace sigmafmu
