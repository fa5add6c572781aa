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

SpringDamper::Points SpringDamper::points(const Kinematics& k) const {
  const FrameKinematics &k1 = k[0], &k2 = k[1];
  Points p;
  p.phi = points_.gap(k1, k2);
  p.A[0].noalias() = k1.R_WB * lie::hat(points_.s1);
  p.A[1].noalias() = k2.R_WB * lie::hat(-points_.s2);
  p.phidot = k2.v_WB + p.A[1] * k2.w_WB_B - k1.v_WB + p.A[0] * k1.w_WB_B;
  return p;
}

Vector3d SpringDamper::force(const Points& p) const {
  return -stiffness_.cwiseProduct(p.phi) - damping_.cwiseProduct(p.phidot);
}

Vector3d SpringDamper::force(const Kinematics& k) const { return force(points(k)); }

double SpringDamper::energy(const Kinematics& k, const Inputs&) const {
  const Vector3d phi = points_.gap(k[0], k[1]);
  return 0.5 * phi.dot(stiffness_.cwiseProduct(phi));
}

void SpringDamper::add(const Kinematics& k, const Inputs& u, const FrameForces& r) const {
  const Points p = points(k);
  const Vector3d f = force(p) + Vector3d::Map(own(u));
  if (r.has(0)) {
    r[0].head<3>() += f;
    r[0].tail<3>().noalias() -= p.A[0].transpose() * f;
  }
  if (r.has(1)) {
    r[1].head<3>() -= f;
    r[1].tail<3>().noalias() -= p.A[1].transpose() * f;
  }
}

void SpringDamper::linearize(const Kinematics& k, const Inputs& u, const FramePairs& K, const FramePairs& C) const {
  const Points p = points(k);
  points_.stiffness(k[0], k[1], -(force(p) + Vector3d::Map(own(u))), K);
  const Matrix3d Y[2] = {k[0].R_WB * lie::hat(k[0].w_WB_B.cross(points_.s1)),
                         k[1].R_WB * lie::hat(points_.s2.cross(k[1].w_WB_B))};
  for (int j = 0; j < 2; ++j) {
    if (!K.has(j, j)) continue;  // the ground
    const Matrix3d DA = damping_.asDiagonal() * p.A[j];
    const Matrix3d KA_DY = stiffness_.asDiagonal() * p.A[j] + damping_.asDiagonal() * Y[j];
    const auto add = [&](int i, const Vector3d& diagonal, const Matrix3d& rotations, auto block) {
      const double o_i = i == 0 ? -1.0 : 1.0, o_j = j == 0 ? -1.0 : 1.0;
      block.template topLeftCorner<3, 3>().diagonal() += (o_i * o_j) * diagonal;
      block.template topRightCorner<3, 3>() += o_i * rotations;
      block.template bottomLeftCorner<3, 3>() += p.A[i].transpose() * (o_j * diagonal).asDiagonal();
      block.template bottomRightCorner<3, 3>().noalias() += p.A[i].transpose() * rotations;
    };
    for (int i = 0; i < 2; ++i) {
      if (!K.has(i, j)) continue;
      add(i, stiffness_, KA_DY, K(i, j));
      add(i, damping_, DA, C(i, j));
    }
  }
}

}  // namespace sigmafmu
