// Coordinates coupled by polynomials:
//
//   Phi = sum_i p_i(x_i) - y,   Phi' = sum_i p_i' x_i',   B_i = p_i' b_i,   Z_i = p_i' z_i + p_i'' x_i' b_i,
//
// with b and z of JointCoordinate and a constant y that comes with the inputs. The force or torque along coordinate i,
// on the second body of its joint, is -p_i' lambda; together they do no work.
#pragma once

#include <vector>

#include "model/elements/coupling.h"
#include "multibody/constraints/constraint.h"
#include "multibody/joint_coordinate.h"

namespace sigmafmu {

class Coupling final : public Constraint {
 public:
  struct Term {
    JointCoordinate coordinate;
    int index;  // of the coordinates of all joints
    std::vector<double> polynomial;
  };
  // Frames 2 i and 2 i + 1 are those of term i. `index`: of y in Inputs::x.
  Coupling(std::vector<Term> terms, int index);

  int frame_count() const override { return 2 * static_cast<int>(terms_.size()); }
  void evaluate(const Inputs& u, const Kinematics& k, double* phi, double* phidot, const FrameRows& B) const override;
  void rates(const Inputs& u, const Kinematics& k, const FrameRows& Z, double* W) const override;
  void stiffness(const Inputs& u, const Kinematics& k, const double* lambda, const FramePairs& K) const override;

  // p_i'.
  double slope(const Inputs& u, const Kinematics& k, int i) const;
  const std::vector<Term>& terms() const { return terms_; }
  // p(x), p'(x), p''(x).
  struct Value {
    double p, slope, curvature;
  };
  static Value value(const std::vector<double>& polynomial, double x);

 private:
  Value value(const Inputs& u, const Kinematics& k, int i) const;

  std::vector<Term> terms_;
  int index_;
};

}  // namespace sigmafmu
