// A tension along the line between two points, a function N(L, L') of its length and rate, with an actuator:
//
//   x = p_2 - p_1,   L = |x|,   e = x / L,   L' = e^T x',   f = -(N + N_actuator) e acts on body 2, -f on body 1.
//
// The points move with x' = sum_i B_i v_i, B_i and Z_i as in spring_damper.h. With
//
//   df/dx = -(dN/dL e e^T + dN/dL' e x'^T (I - e e^T) / L + (N + N_actuator) (I - e e^T) / L),
//   df/dx' = -dN/dL' e e^T,
//   K_ij -= B_i^T (df/dx B_j + df/dx' Z_j) + d(B_i^T f)/d(motion of j) at constant f,   C_ij -= B_i^T df/dx' B_j.
//
// Points that coincide have no direction: there is no force then.
#pragma once

#include "multibody/constraints/primitives.h"
#include "multibody/forces/force.h"

namespace sigmafmu {

class LineForce : public Force {
 public:
  int frame_count() const override { return 2; }
  const std::vector<ForcePort>& ports() const override;
  void add(const Kinematics& k, const Inputs& u, const FrameForces& r) const override;
  void linearize(const Kinematics& k, const Inputs& u, const FramePairs& K, const FramePairs& C) const override;
  double energy(const Kinematics& k, const Inputs& u) const override;

 protected:
  LineForce(const Vector3d& point1, const Vector3d& point2) : points_{point1, point2} {}

  struct Line {
    Vector3d e, xdot;
    double length = 0, rate = 0, inverse_length = 0;  // [m, m/s, 1/m]
  };
  // N, positive if it pulls, with its derivatives.
  struct Tension {
    double value, by_length, by_rate;  // [N, N/m, N s/m]
  };
  virtual Tension tension(double length, double rate) const = 0;
  // Potential energy [J].
  virtual double stored(double length) const = 0;

 private:
  Line line(const Kinematics& k) const;

  PointCoincidence points_;
};

}  // namespace sigmafmu
