// A force f(c, c') [N] or torque [N m] along a joint's coordinate c, on the second body. With B = d(c')/dv and Z =
// d(c')/d(motion) its share of the residual is -B^T f, and
//
//   K -= B^T (f_c B + f_c' Z) + d(B^T f)/d(motion) at constant f,   C -= f_c' B^T B.
//
// Angles are counted near Inputs::turned.
#pragma once

#include "multibody/forces/force.h"
#include "multibody/joint_coordinate.h"

namespace sigmafmu {

class CoordinateForce : public Force {
 public:
  struct Law {
    double force, by_value, by_rate;  // f, f_c, f_c'
  };

  int frame_count() const override { return 2; }
  void add(const Kinematics& k, const Inputs& u, const FrameForces& r) const override;
  void linearize(const Kinematics& k, const Inputs& u, const FramePairs& K, const FramePairs& C) const override;
  double energy(const Kinematics& k, const Inputs& u) const override { return energy_at(value(k, u)); }

  double force(const Kinematics& k, const Inputs& u) const { return law(k, u).force; }

 protected:
  // `c`: which of the coordinates of all joints; `index`: in the list of definitions.
  CoordinateForce(const JointCoordinate& coordinate, int c, int index)
      : coordinate_(coordinate), c_(c), index_(index) {}

  virtual Law law(double value, double rate) const = 0;
  virtual double energy_at(double) const { return 0; }

  bool is_angle() const { return coordinate_.is_angle(); }
  int index() const { return index_; }
  Stiffest stiffest_of(double stiffness) const { return is_angle() ? Stiffest{0, stiffness} : Stiffest{stiffness, 0}; }
  static void output(const Force& f, const Kinematics& k, const Inputs& u, double* x) {
    *x = static_cast<const CoordinateForce&>(f).force(k, u);
  }

 private:
  double value(const Kinematics& k, const Inputs& u) const { return coordinate_.value_near(k, u.turned[c_]); }
  Law law(const Kinematics& k, const Inputs& u) const { return law(value(k, u), coordinate_.rate(k)); }

  JointCoordinate coordinate_;
  int c_, index_;
};

}  // namespace sigmafmu
