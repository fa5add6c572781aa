#include "model/dense.h"
#include "model/validation.h"

namespace sigmafmu::validation {
namespace {

void validate_rigid(const RigidBodyDef& b) {
  if (!(b.mass > 0) || !std::isfinite(b.mass)) {
    fail(b.name, ".mass is ", b.mass, " kg; it must be positive and finite.");
  }
  const char* elements[] = {"xx", "yy", "zz", "xy", "xz", "yz"};
  for (int i = 0; i < 6; ++i) {
    const double x = i < 3 ? b.inertia[i] : b.inertia_products[i - 3];
    if (!std::isfinite(x)) fail(b.name, ".inertia.", elements[i], " is ", x, " kg.m2; it must be finite.");
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

}  // namespace

void validate_body(const RigidBodyDef& b) {
  if (!b.modal) validate_rigid(b);
  if (!(b.initial_quaternion.norm() > 1e-6) || !b.initial_quaternion.allFinite()) {
    fail(b.name, ".initialQuaternion has the length ", b.initial_quaternion.norm(),
         "; it must be finite and at least 1e-6 (it is normalized).");
  }
  require_finite(b.name + ".initialPosition", b.initial_position, "m");
  require_finite(b.name + ".initialVelocity", b.initial_velocity, "m/s");
  require_finite(b.name + ".initialAngularVelocity", b.initial_angular_velocity, "rad/s");
}

}  // namespace sigmafmu::validation
