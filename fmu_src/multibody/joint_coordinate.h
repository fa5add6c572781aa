// A coordinate that a joint leaves free: an angle about the z axis of its frames, or a displacement along it. Motors,
// springs and whatever else acts along a coordinate need no more of a joint.
//
// Frames 1 and 2 are those of the joint. Angle: from x1 to x2 about z, where z1 = z2. Displacement: of origin 2 from
// origin 1 along z1.
#pragma once

#include "model/definition.h"
#include "multibody/constraints/primitives.h"

namespace sigmafmu {

class JointCoordinate {
 public:
  using Kind = CoordinateKind;

  JointCoordinate(Kind kind, const Frame& frame1, const Frame& frame2)
      : kind_(kind), frame1_(frame1), frame2_(frame2), along_{frame1.axes.col(2), frame1.origin, frame2.origin} {}

  Kind kind() const { return kind_; }
  bool is_angle() const { return kind_ == Kind::angle; }
  // [rad] in (-pi, pi] or [m].
  double value(const Kinematics& k) const;
  // The same with the turns that bring it nearest to a value.
  double value_near(const Kinematics& k, double near) const;
  // B v [rad/s] or [m/s].
  double rate(const Kinematics& k) const;
  // r -= B^T f for a torque [N m] or force [N] f along the coordinate, B = d(rate)/dv.
  void add_force(const Kinematics& k, double f, const FrameForces& r) const;
  // K -= d(B^T f)/d(motion) at constant f.
  void stiffness(const Kinematics& k, double f, const FramePairs& K) const;
  // B, one row.
  void gradient(const Kinematics& k, const FrameRows& B) const;
  // Z = d(rate)/d(motion) at fixed velocities, one row.
  void rates(const Kinematics& k, const FrameRows& Z) const;

 private:
  Kind kind_;
  Frame frame1_, frame2_;
  AxialDistance along_;
};

}  // namespace sigmafmu
