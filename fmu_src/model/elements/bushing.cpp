#include "model/elements/bushing.h"

#include <cmath>

#include "model/dense.h"
#include "model/validation.h"

namespace sigmafmu {
namespace {

using Matrix6d = BushingDef::Matrix6d;

void check_coupling(const std::string& name, const Matrix6d& A) {
  using validation::fail;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      const auto entry = [&] { return text(name, "[", i + 1, ", ", j + 1, "] is ", A(i, j)); };
      if (!std::isfinite(A(i, j))) fail(entry(), "; it must be finite.");
      if (i == j && A(i, j) != 0) fail(entry(), "; the diagonal must be zero.");
      if (A(i, j) != A(j, i)) fail(entry(), " but [", j + 1, ", ", i + 1, "] is ", A(j, i), "; it must be symmetric.");
    }
  }
}

// Directions without a diagonal have no coupling; the others are scaled to a diagonal of ones, since the entries have
// different units.
void check_semidefinite(const std::string& name, Matrix6d A) {
  constexpr double kRounding = 1e-9;
  for (int i = 0; i < 6; ++i) {
    if (A(i, i) == 0 && !A.row(i).isZero(0)) {
      validation::fail(name, " couples direction ", i + 1, ", which has none of its own; it must be positive",
                       " semidefinite.");
    }
  }
  Eigen::Matrix<double, 6, 1> scale;
  for (int i = 0; i < 6; ++i) scale[i] = A(i, i) > 0 ? 1 / std::sqrt(A(i, i)) : 0.0;
  const Matrix6d scaled = scale.asDiagonal() * A * scale.asDiagonal();
  const double lowest = eigenvalues(Eigen::MatrixXd(scaled))[0];
  if (lowest < -kRounding) {
    validation::fail(name, " has, scaled to a diagonal of ones, the eigenvalue ", lowest,
                     "; it must be positive semidefinite.");
  }
}

}  // namespace

void BushingDef::check_values() const {
  check_frames();
  check_coupling(name + ".stiffnessCoupling", stiffness_coupling);
  check_coupling(name + ".dampingCoupling", damping_coupling);
  check_semidefinite("The stiffness of " + name, stiffness_matrix());
  check_semidefinite("The damping of " + name, damping_matrix());
}

}  // namespace sigmafmu
