#include "model/definition.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <tuple>

#include "model/dense.h"
#include "multibody/bodies/flexible_body.h"
#include "multibody/bodies/rigid_body_inline.h"
#include "text/text.h"

namespace sigmafmu {
namespace {

template <typename... Parts>
[[noreturn]] void fail(const Parts&... parts) {
  sigmafmu::fail<std::invalid_argument>(parts...);
}

void require_finite(const std::string& name, const Vector3d& x, const char* unit) {
  for (int i = 0; i < 3; ++i) {
    if (!std::isfinite(x[i])) fail(name, "[", i + 1, "] is ", x[i], " ", unit, "; it must be finite.");
  }
}

bool is_rotation(const Matrix3d& R) {
  return (R.transpose() * R - Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-12 && R.determinant() > 0;
}

void validate_rigid(const RigidBodyDef& b) {
  if (!(b.mass > 0) || !std::isfinite(b.mass)) {
    fail(b.name, ".mass is ", b.mass, " kg; it must be positive and finite.");
  }
  const Matrix3d J = inertia_matrix(b);
  const Vector3d principal = eigenvalues(J);
  const auto moments = [&] {
    std::ostringstream list = text_stream(6);
    list << principal[0] << ", " << principal[1] << ", " << principal[2] << " kg.m2";
    return list.str();
  };
  if (!(principal[0] > 0)) {
    fail(b.name, ".inertia has the principal moments ", moments(), "; all must be positive.");
  }
  // A thin rod or a lamina is on the boundary of what is possible: allow for the rounding of its data.
  if (principal[2] > (principal[0] + principal[1]) * (1 + 1e-9)) {
    fail(b.name, ".inertia has the principal moments ", moments(),
         "; none may exceed the sum of the other two (triangle inequality).");
  }
}

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

void validate_modal(const std::string& body, const ModalDef& m) {
  const std::string name = body + ".modal";
  const int n = m.node_count(), f = m.mode_count();
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

  const MatrixXd M = FlexibleBody(m).undeformed_mass_matrix();
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

void validate_body(const RigidBodyDef& b) {
  if (b.modal) {
    validate_modal(b.name, *b.modal);
  } else {
    validate_rigid(b);
  }
  if (!(b.initial_quaternion.norm() > 1e-6) || !b.initial_quaternion.allFinite()) {
    fail(b.name, ".initialQuaternion has the length ", b.initial_quaternion.norm(),
         "; it must be finite and at least 1e-6 (it is normalized).");
  }
  require_finite(b.name + ".initialPosition", b.initial_position, "m");
  require_finite(b.name + ".initialVelocity", b.initial_velocity, "m/s");
  require_finite(b.name + ".initialAngularVelocity", b.initial_angular_velocity, "rad/s");
}

}  // namespace

Matrix3d axes_with_z(const Vector3d& z) {
  const Vector3d e3 = z.normalized();
  Vector3d::Index smallest;
  e3.cwiseAbs().minCoeff(&smallest);
  Matrix3d axes;
  axes.col(0) = Vector3d::Unit(smallest).cross(e3).normalized();
  axes.col(1) = e3.cross(axes.col(0));
  axes.col(2) = e3;
  return axes;
}

double mass(const RigidBodyDef& body) {
  if (!body.modal) return body.mass;
  return body.modal->mass_matrix.size() > 0 ? body.modal->mass_matrix.sum() : body.modal->masses.sum();
}

int MultibodyDef::add(RigidBodyDef body) {
  bodies.push_back(std::move(body));
  return static_cast<int>(bodies.size()) - 1;
}
int MultibodyDef::add(JointDef joint) {
  joints.push_back(std::move(joint));
  return static_cast<int>(joints.size()) - 1;
}
int MultibodyDef::add(SpringDamperDef spring_damper) {
  spring_dampers.push_back(std::move(spring_damper));
  return static_cast<int>(spring_dampers.size()) - 1;
}
int MultibodyDef::add(LoadDef load) {
  loads.push_back(std::move(load));
  return static_cast<int>(loads.size()) - 1;
}

double size(const MultibodyDef& d) {
  double largest = 0;
  const auto add = [&](int body, const Vector3d& point, int node) {
    if (body == kGround) return;
    const Vector3d origin = node == kFloatingFrame ? Vector3d::Zero() : Vector3d(d.bodies[body].modal->nodes.row(node));
    largest = std::max(largest, (origin + point).norm());
  };
  for (const RigidBodyDef& b : d.bodies) {
    largest = std::max(largest,
                       b.modal ? b.modal->nodes.rowwise().norm().maxCoeff() : std::sqrt(b.inertia.maxCoeff() / b.mass));
  }
  for (const JointDef& j : d.joints) {
    add(j.body1, j.frame1.origin, j.frame1.node);
    add(j.body2, j.frame2.origin, j.frame2.node);
  }
  for (const SpringDamperDef& s : d.spring_dampers) {
    add(s.body1, s.point1, s.node1);
    add(s.body2, s.point2, s.node2);
  }
  return largest;
}

void validate(const MultibodyDef& d) {
  const int n = static_cast<int>(d.bodies.size());
  if (n == 0) fail("The mechanism has no bodies; it must have at least one.");
  const auto check_pair = [&](const std::string& name, int body1, int body2) {
    for (int body : {body1, body2}) {
      if (body < kGround || body >= n) {
        fail(name, " refers to body ", body, "; allowed are -1 (ground) to ", n - 1, ".");
      }
    }
    if (body1 == body2) fail(name, " connects body ", body1, " with itself; it must connect two bodies.");
  };
  const auto check_node = [&](const std::string& name, int body, int node) {
    if (node == kFloatingFrame) return;
    if (body == kGround || !d.bodies[body].modal) {
      const std::string where = body == kGround ? "the ground" : d.bodies[body].name;
      fail(name, " attaches to node ", node, " of ", where, ", which is not flexible; allowed is -1 (no node).");
    }
    const int nodes = d.bodies[body].modal->node_count();
    if (node < 0 || node >= nodes) {
      fail(name, " attaches to node ", node, " of ", d.bodies[body].name, "; allowed are -1 (floating frame) to ",
           nodes - 1, ".");
    }
  };
  require_finite("gravity", d.gravity, "m/s2");
  for (const RigidBodyDef& b : d.bodies) validate_body(b);
  for (const JointDef& j : d.joints) {
    check_pair(j.name, j.body1, j.body2);
    check_node(j.name, j.body1, j.frame1.node);
    check_node(j.name, j.body2, j.frame2.node);
    if (!is_rotation(j.frame1.axes) || !is_rotation(j.frame2.axes)) {
      fail(j.name, " has frame axes that are not orthonormal and right-handed.");
    }
    require_finite(j.name + ".frame1.origin", j.frame1.origin, "m");
    require_finite(j.name + ".frame2.origin", j.frame2.origin, "m");
  }
  for (const SpringDamperDef& s : d.spring_dampers) {
    check_pair(s.name, s.body1, s.body2);
    check_node(s.name, s.body1, s.node1);
    check_node(s.name, s.body2, s.node2);
    require_finite(s.name + ".point1", s.point1, "m");
    require_finite(s.name + ".point2", s.point2, "m");
    require_finite(s.name + ".stiffness", s.stiffness, "N/m");
    require_finite(s.name + ".damping", s.damping, "N.s/m");
    for (int i = 0; i < 3; ++i) {
      if (s.stiffness[i] < 0) {
        fail(s.name, ".stiffness[", i + 1, "] is ", s.stiffness[i], " N/m; it must not be negative.");
      }
      if (s.damping[i] < 0) {
        fail(s.name, ".damping[", i + 1, "] is ", s.damping[i], " N.s/m; it must not be negative.");
      }
    }
  }
  for (const LoadDef& load : d.loads) {
    if (load.body < 0 || load.body >= n) {
      fail(load.name, " acts on body ", load.body, "; allowed are 0 to ", n - 1, ".");
    }
    require_finite(load.name + ".force", load.force, "N");
    require_finite(load.name + ".torque", load.torque, "N.m");
  }
}

}  // namespace sigmafmu
