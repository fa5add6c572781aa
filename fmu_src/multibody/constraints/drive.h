// A drive prescribes a joint's coordinate c as a function x(t), which comes with the inputs, plus a function of time
// y(t) that it knows:
//
//   Phi = c - x - y,   Phi' = B v - x' - y',   W = d(Phi')/dt = -x'' - y'',
//
// with B = d(c')/dv of JointCoordinate. An angle is compared up to whole turns. The force or torque along the
// coordinate, on body 2, is -lambda; its power is -lambda (x' + y').
#pragma once

#include "multibody/constraints/constraint.h"
#include "multibody/cubic_table.h"
#include "multibody/joint_coordinate.h"

namespace sigmafmu {

class Drive final : public Constraint {
 public:
  // `index`: which of the drives, in Inputs.
  Drive(const JointCoordinate& coordinate, int index, CubicTable table);

  int frame_count() const override { return 2; }
  void evaluate(const Inputs& u, const Kinematics& k, double* phi, double* phidot, const FrameRows& B) const override;
  void rates(const Inputs& u, const Kinematics& k, const FrameRows& Z, double* W) const override;
  void stiffness(const Inputs& u, const Kinematics& k, const double* lambda, const FramePairs& K) const override;

 private:
  JointCoordinate coordinate_;
  int index_;
  CubicTable table_;
};

}  // namespace sigmafmu
