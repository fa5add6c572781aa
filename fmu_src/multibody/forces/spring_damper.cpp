#include "multibody/forces/spring_damper.h"

#include "multibody/constraints/primitives_inline.h"

namespace sigmafmu {

SpringDamper::SpringDamper(const SpringDamperDef& d, int index)
    : index_(index), points_{d.point1, d.point2}, stiffness_(d.stiffness), damping_(d.damping) {}

const std::vector<ForcePort>& SpringDamper::ports() const {
  static const std::vector<ForcePort> table = {
      {"position", 3, "Displacement", "Attachment point on the second body, in W",
       [](const Force& f, const Kinematics& k, const Inputs&, double* x) {
         Vector3d::Map(x) = static_cast<const SpringDamper&>(f).position(k);
       }},
      {"force", 3, "Force", "Force of spring and damper (actuator excluded) on the second body, in W",
       [](const Force& f, const Kinematics& k, const Inputs&, double* x) {
         Vector3d::Map(x) = static_cast<const SpringDamper&>(f).force(k);
       }},
      {"energy", 0, "Energy", "Elastic energy", energy_output},
      {"power", 0, "Power", "Power of the element on its bodies", power_output, true},
      {"actuatorForce", 3, "Force", "Actuator force on the attachment point of the second body, in W", nullptr},
  };
  return table;
}

void SpringDamper::set_values(const MultibodyDef& definition) {
  stiffness_ = definition.spring_dampers[index_].stiffness;
  damping_ = definition.spring_dampers[index_].damping;
}

Vector3d SpringDamper::force(const Kinematics& k) const {
  return -stiffness_.cwiseProduct(points_.gap(k[0], k[1])) - damping_.cwiseProduct(points_.gap_rate(k[0], k[1]));
}

double SpringDamper::energy(const Kinematics& k, const Inputs&) const {
  const Vector3d phi = points_.gap(k[0], k[1]);
  return 0.5 * phi.dot(stiffness_.cwiseProduct(phi));
}

void SpringDamper::add(const Kinematics& k, const Inputs& u, const FrameForces& r) const {
  points_.add_force(k[0], k[1], force(k) + Vector3d::Map(own(u)), r);
}

void SpringDamper::linearize(const Kinematics& k, const Inputs& u, const FramePairs& K, const FramePairs& C) const {
  points_.stiffness(k[0], k[1], -(force(k) + Vector3d::Map(own(u))), K);
  const double o[2] = {-1.0, 1.0};
  const Vector3d* s[2] = {&points_.s1, &points_.s2};
  Matrix3d A[2];
  for (int j = 0; j < 2; ++j) {
    if (K.has(j, j)) A[j] = lie::times_hat(k[j].R_WB, -o[j] * *s[j]);
  }
  for (int j = 0; j < 2; ++j) {
    if (!K.has(j, j)) continue;  // the ground
    const Matrix3d Y = lie::times_hat(k[j].R_WB, o[j] * s[j]->cross(k[j].w_WB_B));
    const Matrix3d DA = damping_.asDiagonal() * A[j];
    const Matrix3d KA_DY = stiffness_.asDiagonal() * A[j] + damping_.asDiagonal() * Y;
    const auto add = [&](int i, const Vector3d& diagonal, const Matrix3d& rotations, auto block) {
      block.template topLeftCorner<3, 3>().diagonal() += (o[i] * o[j]) * diagonal;
      block.template topRightCorner<3, 3>() += o[i] * rotations;
      block.template bottomLeftCorner<3, 3>() += A[i].transpose() * (o[j] * diagonal).asDiagonal();
      block.template bottomRightCorner<3, 3>().noalias() += A[i].transpose() * rotations;
    };
    for (int i = 0; i < 2; ++i) {
      if (!K.has(i, j)) continue;
      add(i, stiffness_, KA_DY, K(i, j));
      add(i, damping_, DA, C(i, j));
    }
  }
}

}  // namespace sigmafmu
