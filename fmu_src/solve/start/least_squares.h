// Small dense linear algebra that decides about rank; in one place, since it takes long to compile.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace sigmafmu {

// Minimizes |A x + r|, with the shortest x of all that do.
class LeastSquares {
 public:
  // What is smaller than `zero` in A, once its larger parts are eliminated, decides nothing.
  LeastSquares(const Eigen::MatrixXd& A, double zero);
  ~LeastSquares();

  Eigen::VectorXd solve(const Eigen::VectorXd& r) const;
  // Combinations of equations that x cannot change, orthogonal and of length 1: those of other coefficients B.
  Eigen::MatrixXd beyond(const Eigen::MatrixXd& B) const;

 private:
  struct Decomposition;
  std::unique_ptr<Decomposition> decomposition_;
};

// Solves A[0] y[0] + A[1] y[1] + ... = -r, as nearly as it can be, with the shortest last y, then the shortest last but
// one, and so on.
void solve_in_turn(const Eigen::MatrixXd* A, int count, const Eigen::VectorXd& r, double zero, Eigen::VectorXd* y);

// x with H x = b; H is symmetric and positive definite.
Eigen::VectorXd solve_definite(const Eigen::MatrixXd& H, const Eigen::VectorXd& b);

// Coordinates y = U x in which a mass matrix M = U^T U is the identity.
class MassScaling {
 public:
  explicit MassScaling(const Eigen::MatrixXd& M);
  Eigen::MatrixXd scaled(const Eigen::MatrixXd& A) const;  // A U^-1
  Eigen::VectorXd unscaled(const Eigen::VectorXd& y) const;

 private:
  Eigen::MatrixXd U_;
};

Eigen::MatrixXd pick(const Eigen::MatrixXd& A, const std::vector<int>& rows, const std::vector<int>& columns);
Eigen::MatrixXd pick_columns(const Eigen::MatrixXd& A, const std::vector<int>& columns);

}  // namespace sigmafmu
