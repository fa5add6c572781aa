// Spring and damper about the z axes of two frames, which may be inclined to each other. Q = R_z(c) times the shortest
// turn that inclines the axes, so that with z = Q e_3, the second axis seen from frame 1,
//
//   c = atan2(Q_21 - Q_12, Q_11 + Q_22),   c' = b^T w,   b = (e_3 + z) / (1 + e_3^T z),
//
// and the torque is T = tau b on body 2, tau = -k (c - c_rest) - d c' + T_actuator: along the middle of both axes, as a
// homokinetic coupling turns, and the same seen from either body. dz = -hat(z) dphi makes
//
//   db/dphi = -(I - b e_3^T) hat(z) / (1 + e_3^T z),
//   dT/dphi = b (-k b - d (db/dphi)^T w)^T + tau db/dphi,   dT/dw = -d b b^T.
//
// c jumps by a turn where it is pi: springs that are wound up further belong on a joint's coordinate, which counts
// turns. Axes in opposite directions have no twist.
#pragma once

#include "multibody/forces/frame_pair_force.h"

namespace sigmafmu {

class TorsionSpring final : public FramePairForce {
 public:
  TorsionSpring(const TorsionSpringDef& d, int index) : FramePairForce(d.frame1, d.frame2), index_(index) {}

  const std::vector<ForcePort>& ports() const override;
  void set_values(const MultibodyDef& definition) override;
  Stiffest stiffest() const override { return {0, stiffness_}; }

 private:
  struct Twist {
    double angle, rate;  // c, c' [rad, rad/s]
    Vector3d b, z;
  };
  static Twist twist(const RelativeMotion& x);
  double torque(const Twist& t) const { return -stiffness_ * (t.angle - rest_) - damping_ * t.rate; }

  Vector6d wrench(const RelativeMotion& x, const double* u) const override;
  void derivatives(const RelativeMotion& x, const double* u, Matrix6d& by_motion, Matrix6d& by_velocity) const override;
  double stored(const RelativeMotion& x) const override;

  int index_;  // in MultibodyDef::torsion_springs
  double stiffness_ = 0, damping_ = 0, rest_ = 0;
};

}  // namespace sigmafmu
