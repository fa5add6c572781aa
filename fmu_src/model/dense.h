// Linear algebra of matrices that have no fixed size, or where time does not matter. In files of its own, since Eigen's
// solvers and products take seconds and hundreds of megabytes to compile.
#pragma once

#include <Eigen/Core>

namespace sigmafmu {

Eigen::MatrixXd product(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);
Eigen::MatrixXd transposed_product(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);  // A^T B

Eigen::Matrix3d inverse(const Eigen::Matrix3d& A);
Eigen::Matrix<double, 6, 6> inverse(const Eigen::Matrix<double, 6, 6>& A);

// Eigenvalues of a symmetric matrix in ascending order.
Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& A);
Eigen::Vector3d eigenvalues(const Eigen::Matrix3d& A);

struct PrincipalAxes {
  Eigen::Vector3d values;  // in ascending order
  Eigen::Matrix3d axes;    // in columns, of either handedness
};
PrincipalAxes principal_axes(const Eigen::Matrix3d& A);

// The largest x with det(A - x B) = 0; B is positive definite.
double largest_eigenvalue(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

// B - C A^-1 C^T; A is positive definite.
Eigen::MatrixXd schur_complement(const Eigen::Matrix<double, 6, 6>& A, const Eigen::MatrixXd& C,
                                 const Eigen::MatrixXd& B);

}  // namespace sigmafmu
