#include "model/dense.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace sigmafmu {

using Eigen::MatrixXd;

MatrixXd product(const MatrixXd& A, const MatrixXd& B) { return A * B; }
MatrixXd transposed_product(const MatrixXd& A, const MatrixXd& B) { return A.transpose() * B; }

Eigen::Matrix3d inverse(const Eigen::Matrix3d& A) { return A.inverse(); }
Eigen::Matrix<double, 6, 6> inverse(const Eigen::Matrix<double, 6, 6>& A) { return A.inverse(); }

double largest_eigenvalue(const MatrixXd& A, const MatrixXd& B) {
  const Eigen::LLT<MatrixXd> llt(B);  // B = L L^T: the eigenvalues of L^-1 A L^-T
  MatrixXd C = A.selfadjointView<Eigen::Lower>();
  llt.matrixL().solveInPlace<Eigen::OnTheLeft>(C);
  llt.matrixU().solveInPlace<Eigen::OnTheRight>(C);
  return eigenvalues(C).maxCoeff();
}

MatrixXd schur_complement(const Eigen::Matrix<double, 6, 6>& A, const MatrixXd& C, const MatrixXd& B) {
  return B - C * A.llt().solve(C.transpose());
}

}  // namespace sigmafmu
