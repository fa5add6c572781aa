// A joint: a list of primitive equations between two bodies, and the free coordinate it measures.
#pragma once

#include <vector>

#include "model/definition.h"
#include "multibody/joints/primitives.h"

namespace sigmafmu {

// Everything a joint knows of itself at (q, v): m equations by the velocities of bodies 1 and 2.
struct JointEvaluation {
  JointVector phi;     // Phi, m rows [m or 1]
  JointVector phidot;  // Phi' [m/s or 1/s]
  JointRows B[2];      // constraint gradient
  JointRows Z[2];      // d(Phi')/d(motion), valid after Joint::rate
};

class Joint {
 public:
  explicit Joint(const JointDef& definition);

  int equations() const { return equations_; }
  int length_equations() const { return equations_ - static_cast<int>(perpendiculars_.size()); }  // the first ones [m]
  int body1() const { return body1_; }
  int body2() const { return body2_; }
  JointType type() const { return type_; }
  bool couples_rotations() const { return !perpendiculars_.empty() || !distances_.empty(); }
  // One input: motor torque [N m] about the revolute axis, actuator force [N] along the prismatic axis.
  bool has_motor() const { return type_ == JointType::revolute || type_ == JointType::prismatic; }

  JointEvaluation make_evaluation() const;
  // Phi, B and Phi'.
  void constraint(const BodyKinematics& k1, const BodyKinematics& k2, JointEvaluation& e) const;
  // Z.
  void rate(const BodyKinematics& k1, const BodyKinematics& k2, JointEvaluation& e) const;
  // K += d(B^T lambda)/d(motion) - d(motor force)/d(motion); lambda has m entries.
  void stiffness(const BodyKinematics& k1, const BodyKinematics& k2, const double* lambda, double motor,
                 const PairBlocks& K) const;
  // Subtracts the motor's generalized forces (r = M vdot + g + B^T lambda has them on its left side).
  void add_motor(const BodyKinematics& k1, const BodyKinematics& k2, double motor, double* r1, double* r2) const;

  // The equations of parallel axes hold for opposite directions as well; false for those.
  bool axes_agree(const BodyKinematics& k1, const BodyKinematics& k2) const;

  // Revolute: angle [rad] in (-pi, pi] from x1 to x2 about z. Prismatic: displacement [m] along z.
  double coordinate(const BodyKinematics& k1, const BodyKinematics& k2) const;
  // Its rate [rad/s or m/s].
  double coordinate_rate(const BodyKinematics& k1, const BodyKinematics& k2) const;

  // Force [N] and torque [N m] about the joint's origin on body 2 that the constraint exerts, in W.
  struct Reaction {
    Vector3d force, torque;
  };
  Reaction reaction(const BodyKinematics& k2, const JointEvaluation& e, const double* lambda) const;

 private:
  JointType type_;
  int body1_, body2_;
  int equations_ = 0;
  bool has_coincidence_ = false;
  PointCoincidence origins_;
  std::vector<AxialDistance> distances_;
  std::vector<PerpendicularAxes> perpendiculars_;
  Frame frame1_, frame2_;
};

}  // namespace sigmafmu
