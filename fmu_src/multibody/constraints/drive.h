// A drive prescribes a joint's coordinate c as a function x(t) that comes with the inputs:
//
//   Phi = c - x(t),   Phi' = B v - x',   W = d(Phi')/dt = -x'',
//
// with B = d(c')/dv of JointCoordinate. An angle is compared with x(t) up to whole turns. The force or torque along the
// coordinate, on body 2, is -lambda; its power is -lambda x'.
#pragma once

#include "multibody/constraints/constraint.h"
#include "multibody/joint_coordinate.h"

namespace sigmafmu {

class Drive final : public Constraint {
 public:
  // `index`: which of the drives, in Inputs.
  Drive(const JointCoordinate& coordinate, int index);

  int frame_count() const override { return 2; }
  void evaluate(const Inputs& u, const Kinematics& k, double* phi, double* phidot, const FrameRows& B) const override;
  void rates(const Inputs& u, const Kinematics& k, const FrameRows& Z, double* W) const override;
  void stiffness(const Kinematics& k, const double* lambda, const FramePairs& K) const override;

 private:
  JointCoordinate coordinate_;
  int index_;
};

}  // namespace sigmafmu
