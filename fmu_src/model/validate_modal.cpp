#include <algorithm>
#include <tuple>

#include "model/dense.h"
#include "model/modal_constants.h"
#include "model/validation.h"

namespace sigmafmu::validation {
namespace {

void require_size(const std::string& name, const MatrixXd& A, Eigen::Index rows, Eigen::Index columns,
                  const char* reason) {
  if (A.rows() != rows || A.cols() != columns) {
    fail(name, " is ", A.rows(), " x ", A.cols(), "; it must be ", rows, " x ", columns, " (", reason, ").");
  }
}

void require_finite_entries(const std::string& name, const MatrixXd& A) {
  for (Eigen::Index j = 0; j < A.cols(); ++j) {
    for (Eigen::Index i = 0; i < A.rows(); ++i) {
      if (!std::isfinite(A(i, j))) fail(name, "[", i + 1, ", ", j + 1, "] is ", A(i, j), "; it must be finite.");
    }
  }
}

// Smallest eigenvalue; data may carry their own rounding.
constexpr double kDataRounding = 1e-9;

void require_semidefinite(const std::string& name, const MatrixXd& A) {
  if (A.size() == 0) return;
  const double largest = A.cwiseAbs().maxCoeff();
  Eigen::Index i, j;
  const double skew = (A - A.transpose()).cwiseAbs().maxCoeff(&i, &j);
  if (skew > kDataRounding * largest) {
    fail(name, " has ", A(i, j), " at [", i + 1, ", ", j + 1, "] and ", A(j, i), " at [", j + 1, ", ", i + 1,
         "]; it must be symmetric.");
  }
  const double lowest = eigenvalues(A)[0];
  if (lowest < -kDataRounding * largest) {
    fail(name, " has the eigenvalue ", lowest, "; it must be positive semidefinite.");
  }
}

// Smallest eigenvalue of a mass matrix whose coordinates are scaled so that each of them alone has mass 1.
double scaled_definiteness(const MatrixXd& M) {
  const VectorXd diagonal = M.diagonal();
  if (!(diagonal.minCoeff() > 0)) return 0.0;
  const VectorXd scale = diagonal.cwiseSqrt().cwiseInverse();
  const MatrixXd scaled = scale.asDiagonal() * M * scale.asDiagonal();
  return eigenvalues(scaled)[0];
}

}  // namespace

void validate_modal_file(const std::string& body, const ModalDef& m) {
  if (m.file.empty()) return;
  if (m.file.find_first_of("/\\:") != std::string::npos || m.file == "." || m.file == "..") {
    fail(body, ".modal.file is ", m.file, "; it must be the name of a file in the folder of the resources.");
  }
  if (m.modes < 0) fail(body, ".modal.modes is ", m.modes, "; it must not be negative.");
}

void validate_modal(const std::string& body, const ModalDef& m) {
  const std::string name = body + ".modal";
  const int n = m.node_count(), f = m.mode_count();
  validate_modal_file(body, m);
  if (m.awaits_file()) fail(name, " lacks its data; ", m.file, " must be read before the mechanism is used.");
  if (!m.file.empty() && f != m.modes) {
    fail(name, ".modes is ", m.modes, ", and its data have ", f, " modes; the two must be the same.");
  }
  if (n == 0) fail(name, ".nodes has no rows; there must be at least one node.");
  require_size(name + ".nodes", m.nodes, n, 3, "one row per node");
  require_size(name + ".shapes", m.shapes, 3 * n, f, "three rows per node, one column per mode");
  if (m.rotations.size() > 0) {
    require_size(name + ".rotations", m.rotations, 3 * n, f, "three rows per node, one column per mode");
  }
  require_size(name + ".stiffness", m.stiffness, f, f, "modes by modes");
  if (m.damping.size() > 0) require_size(name + ".damping", m.damping, f, f, "modes by modes");
  for (const auto& [values, what] :
       {std::pair{&m.initial_coordinates, ".initialCoordinates"}, std::pair{&m.initial_rates, ".initialRates"}}) {
    if (values->size() > 0) require_size(name + what, *values, f, 1, "one per mode");
    require_finite_entries(name + what, *values);
  }
  require_finite_entries(name + ".nodes", m.nodes);
  require_finite_entries(name + ".shapes", m.shapes);
  require_finite_entries(name + ".rotations", m.rotations);
  require_finite_entries(name + ".stiffness", m.stiffness);
  require_finite_entries(name + ".damping", m.damping);
  require_finite_entries(name + ".masses", m.masses);
  require_finite_entries(name + ".massMatrix", m.mass_matrix);

  if (m.masses.size() > 0 && m.mass_matrix.size() > 0) {
    fail(name, " has masses and a massMatrix; it must have one of them.");
  }
  if (m.mass_matrix.size() > 0) {
    require_size(name + ".massMatrix", m.mass_matrix, n, n, "nodes by nodes");
    require_semidefinite(name + ".massMatrix", m.mass_matrix);
  } else {
    require_size(name + ".masses", m.masses, n, 1, "one per node");
    for (int i = 0; i < n; ++i) {
      if (m.masses[i] < 0) fail(name, ".masses[", i + 1, "] is ", m.masses[i], " kg; it must not be negative.");
    }
  }
  require_semidefinite(name + ".stiffness", m.stiffness);
  require_semidefinite(name + ".damping", m.damping);
  for (const auto& [value, what, unit] : {std::tuple{m.mass_damping, ".massDamping", " 1/s"},
                                          std::tuple{m.stiffness_damping, ".stiffnessDamping", " s"}}) {
    if (!(value >= 0) || !std::isfinite(value)) {
      fail(name, what, " is ", value, unit, "; it must be finite and not negative.");
    }
  }

  const MatrixXd M = undeformed_mass_matrix(modal_constants(m));
  constexpr double kIndependent = 1e-12;
  if (!(M(0, 0) > 0)) fail(name, " has the mass ", M(0, 0), " kg; it must be positive.");
  if (!(scaled_definiteness(M.topLeftCorner(6, 6)) > kIndependent)) {
    fail(name, " has all its mass on one line; the nodes must have moments of inertia about every axis.");
  }
  if (f == 0) return;
  if (!(scaled_definiteness(M.bottomRightCorner(f, f)) > kIndependent)) {
    fail(name, ".shapes gives a singular modal mass matrix; the modes must be independent and move mass.");
  }
  if (!(scaled_definiteness(M) > kIndependent)) {
    fail(name, ".shapes contains a rigid motion; the modes must be independent of the motions of the floating frame.");
  }
}

}  // namespace sigmafmu::validation
