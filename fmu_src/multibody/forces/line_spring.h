// A linear spring and damper along a line: N = k (L - L_0) + d L'.
#pragma once

#include "multibody/forces/line_force.h"

namespace sigmafmu {

class LineSpring final : public LineForce {
 public:
  LineSpring(const LineSpringDef& d, int index) : LineForce(d.point1, d.point2), index_(index) {}

  void set_values(const MultibodyDef& definition) override {
    const LineSpringDef& d = definition.line_springs[index_];
    stiffness_ = d.stiffness;
    damping_ = d.damping;
    free_length_ = d.free_length;
  }
  Stiffest stiffest() const override { return {stiffness_, 0}; }

 private:
  Tension tension(double length, double rate) const override {
    return {stiffness_ * (length - free_length_) + damping_ * rate, stiffness_, damping_};
  }
  double stored(double length) const override {
    const double x = length - free_length_;
    return 0.5 * stiffness_ * x * x;
  }

  int index_;  // in MultibodyDef::line_springs
  double stiffness_ = 0, damping_ = 0, free_length_ = 0;
};

}  // namespace sigmafmu
