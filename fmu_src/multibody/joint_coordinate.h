// A coordinate that a joint leaves free: an angle about an axis of its frames, or a displacement along one of frame 1.
// Motors, springs and whatever else acts along a coordinate need no more of a joint.
//
// Frames 1 and 2 are those of the joint, n is the axis, f and s are the axes that follow it in frame 1 or 2 (x, y after
// z; y, z after x). Displacement: of origin 2 from origin 1 along n_1. Angles are about
//
//   n_1 = n_2, from f_1 to f_2;   or n_1 alone, to an axis b of frame 2 that is perpendicular to it; or n_2 alone.
//
// Each has the rate n . (w_2 - w_1), which is the derivative of the angle in every motion from a position in which the
// joint is closed.
#pragma once

#include "model/definition.h"
#include "multibody/constraints/primitives.h"

namespace sigmafmu {

class JointCoordinate {
 public:
  using Kind = CoordinateKind;

  JointCoordinate(const CoordinateType& type, const Frame& frame1, const Frame& frame2);

  Kind kind() const { return type_.kind; }
  bool is_angle() const { return kind() == Kind::angle; }
  // Whether d(B^T f)/d(motion) has blocks between the frames.
  bool couples_frames() const { return !is_angle() || type_.of != Of::both_frames; }
  // [rad] in (-pi, pi] or [m].
  double value(const Kinematics& k) const;
  // The same with the turns that bring it nearest to a value.
  double value_near(const Kinematics& k, double near) const;
  // B v [rad/s] or [m/s].
  double rate(const Kinematics& k) const;
  // c'' = B vdot + Z v [rad/s2] or [m/s2], with the accelerations of both frames as their velocities are.
  double acceleration(const Kinematics& k, const Vector6d& vdot1, const Vector6d& vdot2) const;
  // Rows d(c'')/d(motion) and d(c'')/dv.
  void acceleration_derivatives(const Kinematics& k, const Vector6d& vdot1, const Vector6d& vdot2,
                                const FrameRows& by_motion, const FrameRows& by_velocity) const;
  // r -= B^T f for a torque [N m] or force [N] f along the coordinate, B = d(rate)/dv.
  void add_force(const Kinematics& k, double f, const FrameForces& r) const;
  // K -= d(B^T f)/d(motion) at constant f.
  void stiffness(const Kinematics& k, double f, const FramePairs& K) const;
  // B, one row.
  void gradient(const Kinematics& k, const FrameRows& B) const;
  // Z = d(rate)/d(motion) at fixed velocities, one row.
  void rates(const Kinematics& k, const FrameRows& Z) const;

 private:
  using Of = CoordinateType::AxisOf;

  // The axis in the bodies.
  Vector3d axis_in_1(const Kinematics& k) const;
  Vector3d axis_in_2(const Kinematics& k) const;

  CoordinateType type_;
  AxialDistance along_;
  Vector3d n1_, n2_;
  // The angle is atan2(s . b, f . b).
  Vector3d b_, f_, s_;
};

}  // namespace sigmafmu
