#include "integrator/least_squares.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace sigmafmu {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

LeastSquares::LeastSquares(const MatrixXd& A, double zero) {
  const double first_pivot = std::sqrt(A.colwise().squaredNorm().maxCoeff());
  decomposition_.setThreshold(first_pivot > zero ? zero / first_pivot : 1.0);
  decomposition_.compute(A);
}

VectorXd LeastSquares::solve(const VectorXd& r) const { return -decomposition_.solve(r); }

MatrixXd LeastSquares::beyond(const MatrixXd& B) const {
  MatrixXd turned = B;
  turned.applyOnTheLeft(decomposition_.householderQ().adjoint());
  return turned.bottomRows(B.rows() - decomposition_.rank());
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
