#include <Eigen/Eigenvalues>

#include "model/dense.h"

namespace sigmafmu {

using Eigen::Matrix3d;
using Eigen::MatrixXd;

Eigen::VectorXd eigenvalues(const MatrixXd& A) {
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

Eigen::Vector3d eigenvalues(const Matrix3d& A) {
  return Eigen::SelfAdjointEigenSolver<Matrix3d>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

PrincipalAxes principal_axes(const Matrix3d& A) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace sigmafmu
