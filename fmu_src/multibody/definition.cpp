#include "multibody/definition.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "multibody/bodies/rigid_body.h"

namespace sigmafmu {
namespace {

template <typename... Parts>
[[noreturn]] void fail(const Parts&... parts) {
  std::ostringstream message;
  message.precision(17);
  (message << ... << parts);
  throw std::invalid_argument(message.str());
}

void require_finite(const std::string& name, const Vector3d& x, const char* unit) {
  for (int i = 0; i < 3; ++i) {
    if (!std::isfinite(x[i])) fail(name, "[", i + 1, "] is ", x[i], " ", unit, "; it must be finite.");
  }
}

bool is_rotation(const Matrix3d& R) {
  return (R.transpose() * R - Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-12 && R.determinant() > 0;
}

void validate_body(const RigidBodyDef& b) {
  if (!(b.mass > 0) || !std::isfinite(b.mass)) {
    fail(b.name, ".mass is ", b.mass, " kg; it must be positive and finite.");
  }
  const Matrix3d J = inertia_matrix(b);
  const Vector3d principal = Eigen::SelfAdjointEigenSolver<Matrix3d>(J, Eigen::EigenvaluesOnly).eigenvalues();
  const auto moments = [&] {
    std::ostringstream text;
    text << principal[0] << ", " << principal[1] << ", " << principal[2] << " kg.m2";
    return text.str();
  };
  if (!(principal[0] > 0)) {
    fail(b.name, ".inertia has the principal moments ", moments(), "; all must be positive.");
  }
  // A thin rod or a lamina is on the boundary of what is possible: allow for the rounding of its data.
  if (principal[2] > (principal[0] + principal[1]) * (1 + 1e-9)) {
    fail(b.name, ".inertia has the principal moments ", moments(),
         "; none may exceed the sum of the other two (triangle inequality).");
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
  require_finite("gravity", d.gravity, "m/s2");
  for (const RigidBodyDef& b : d.bodies) validate_body(b);
  for (const JointDef& j : d.joints) {
    check_pair(j.name, j.body1, j.body2);
    if (!is_rotation(j.frame1.axes) || !is_rotation(j.frame2.axes)) {
      fail(j.name, " has frame axes that are not orthonormal and right-handed.");
    }
    require_finite(j.name + ".frame1.origin", j.frame1.origin, "m");
    require_finite(j.name + ".frame2.origin", j.frame2.origin, "m");
  }
  for (const SpringDamperDef& s : d.spring_dampers) {
    check_pair(s.name, s.body1, s.body2);
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
