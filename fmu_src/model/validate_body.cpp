#include <utility>

#include "model/dense.h"
#include "model/validation.h"

namespace sigmafmu::validation {
namespace {

// A link without mass that is fixed to a neighbour, as robot descriptions have them, is a frame of that neighbour.
std::string advice(const MultibodyDef& d, const RigidBodyDef& b) {
  for (const JointDef& joint : d.joints) {
    if (joint.type != JointType::fixed) continue;
    for (auto [one, other] : {std::pair(joint.body1, joint.body2), std::pair(joint.body2, joint.body1)}) {
      if (one == kGround || &d.bodies[one] != &b) continue;
      const References of(d);
      return "; " + joint.name + " fixes it to " + of.name_of(other) + ": leave it out and attach to " +
             of.name_of(other) + " what it carries";
    }
  }
  return "";
}

void validate_rigid(const MultibodyDef& d, const RigidBodyDef& b) {
  if (b.mass == 0) fail(b.name, ".mass is 0 kg; it must be positive and finite", advice(d, b), ".");
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
  // One may be that of a thin rod: nothing about its axis.
  if (!(principal[0] >= -1e-12 * principal[2]) || !(principal[1] > 1e-12 * principal[2])) {
    fail(b.name, ".inertia has the principal moments ", moments(),
         "; they must be positive, or one of them zero (a thin rod)", principal[2] == 0 ? advice(d, b) : "", ".");
  }
  // A thin rod or a lamina is on the boundary of what is possible: allow for the rounding of its data.
  if (principal[2] > (principal[0] + principal[1]) * (1 + 1e-9)) {
    fail(b.name, ".inertia has the principal moments ", moments(),
         "; none may exceed the sum of the other two (triangle inequality).");
  }
}

}  // namespace

void validate_body(const MultibodyDef& d, const RigidBodyDef& b) {
  if (!b.modal) validate_rigid(d, b);
  if (!(b.initial_quaternion.norm() > 1e-6) || !b.initial_quaternion.allFinite()) {
    fail(b.name, ".initialQuaternion has the length ", b.initial_quaternion.norm(),
         "; it must be finite and at least 1e-6 (it is normalized).");
  }
  require_finite(b.name + ".initialPosition", b.initial_position, "m");
  require_finite(b.name + ".initialVelocity", b.initial_velocity, "m/s");
  require_finite(b.name + ".initialAngularVelocity", b.initial_angular_velocity, "rad/s");
}

}  // namespace sigmafmu::validation
