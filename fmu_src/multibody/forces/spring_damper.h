// Spring-damper between two points: force on body 2 in W, f = -K Phi - D Phi' + f_actuator, the opposite on body 1,
// with Phi = p_2 - p_1 (PointCoincidence) and diagonal K, D. The points move with Phi' = sum_i B_i v_i,
//
//   B_i = [o_i I, A_i],   o = (-1, 1),   A_1 = R_1 hat(s_1),   A_2 = -R_2 hat(s_2),   Z_i = [0, Y_i].
//
// Its share of the residual is -B_i^T f, and
//
//   K_ij += B_i^T (K B_j + D Z_j) - d(B_i^T f)/d(motion of j) at constant f,   C_ij += B_i^T D B_j.
#pragma once

#include "multibody/constraints/primitives.h"
#include "multibody/forces/force.h"

namespace sigmafmu {

class SpringDamper final : public Force {
 public:
  SpringDamper(const SpringDamperDef& definition, int index);

  int frame_count() const override { return 2; }
  const std::vector<ForcePort>& ports() const override;
  void set_values(const MultibodyDef& definition) override;
  void add(const Kinematics& k, const Inputs& u, const FrameForces& r) const override;
  void linearize(const Kinematics& k, const Inputs& u, const FramePairs& K, const FramePairs& C) const override;
  double energy(const Kinematics& k, const Inputs& u) const override;
  Stiffest stiffest() const override { return {stiffness_.maxCoeff(), 0}; }

  // Of spring and damper, without the actuator, on body 2 in W [N].
  Vector3d force(const Kinematics& k) const;
  // Where it acts on body 2, in W [m].
  Vector3d position(const Kinematics& k) const { return k[1].p_WB + k[1].R_WB * points_.s2; }

 private:
  int index_;  // in MultibodyDef::spring_dampers
  PointCoincidence points_;
  Vector3d stiffness_, damping_;  // diagonals of K [N/m] and D [N s/m]
};

}  // namespace sigmafmu
