// A joint between two frames: a list of primitive equations, and the coordinates that they leave free.
#pragma once

#include <vector>

#include "multibody/constraints/constraint.h"
#include "multibody/constraints/primitives.h"
#include "multibody/constraints/rolling_disk.h"
#include "multibody/joint_coordinate.h"

namespace sigmafmu {

class Joint final : public Constraint {
 public:
  // `length` [m]: of a distance joint.
  explicit Joint(const JointDef& definition, double length = 0);

  JointType type() const { return type_; }
  const std::vector<JointCoordinate>& coordinates() const { return coordinates_; }

  int frame_count() const override { return 2; }
  void evaluate(const Inputs& u, const Kinematics& k, double* phi, double* phidot, const FrameRows& B) const override;
  void rates(const Inputs& u, const Kinematics& k, const FrameRows& Z, double* W) const override;
  void stiffness(const Inputs& u, const Kinematics& k, const double* lambda, const FramePairs& K) const override;

  // The equations of parallel axes hold for opposite directions as well; false for those.
  bool axes_agree(const Kinematics& k) const;

  // Of a rolling disk; else null.
  const RollingDisk* disk() const { return disks_.empty() ? nullptr : disks_.data(); }

  // Force [N] and torque [N m] on body 2 that the constraint exerts: about the point and in the axes that the
  // definition asks for, which are the origin of frame 2, or where a disk touches, and W where it does not.
  struct Reaction {
    Vector3d force, torque;
  };
  Reaction reaction(const Kinematics& k, const ConstRows& B2, const double* lambda) const;

 private:
  JointType type_;
  bool has_coincidence_ = false;
  bool on_ground_;  // frame 1, where that stands still
  PointCoincidence origins_;
  std::vector<AxialDistance> distances_;
  std::vector<PointDistance> rods_;
  std::vector<Thread> threads_;
  std::vector<PerpendicularAxes> perpendiculars_;
  std::vector<NoTwist> no_twists_;
  std::vector<RollingDisk> disks_;
  Frame frame1_, frame2_;
  std::vector<JointCoordinate> coordinates_;
  ReactionDef tells_;
};

}  // namespace sigmafmu
