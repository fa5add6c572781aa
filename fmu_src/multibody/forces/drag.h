// Quadratic drag at the point s of a body. In its axes, with u = R^T (v_WB - flow) + w x s,
//
//   f = -|u| C u,   t = -|w| D w,   df/du = -(|u| C + C u u^T / |u|),   dt/dw = -(|w| D + D w w^T / |w|),
//
// and (R f, s x f + t) on (v_WB, w_WB_B), where du = R^T dv - hat(s) dw + hat(R^T (v_WB - flow)) dphi and d(R f)/dphi =
// -R hat(f). Continuous with its derivatives; the second ones jump where u = 0.
#pragma once

#include "multibody/forces/force.h"

namespace sigmafmu {

class Drag final : public Force {
 public:
  Drag(const DragDef& d, int index) : index_(index), point_(d.point) {}

  int frame_count() const override { return 1; }
  const std::vector<ForcePort>& ports() const override;
  void set_values(const MultibodyDef& d) override {
    coefficient_ = d.drags[index_].coefficient;
    rotational_ = d.drags[index_].rotational;
    flow_ = d.drags[index_].flow;
  }
  void add(const Kinematics& k, const Inputs& u, const FrameForces& r) const override;
  void linearize(const Kinematics& k, const Inputs& u, const FramePairs& K, const FramePairs& C) const override;

 private:
  Vector3d carried(const FrameKinematics& k) const { return k.R_WB.transpose() * (k.v_WB - flow_); }
  Vector3d velocity(const FrameKinematics& k) const { return carried(k) + k.w_WB_B.cross(point_); }

  int index_;  // in MultibodyDef::drags
  Vector3d point_, coefficient_, rotational_, flow_;
};

}  // namespace sigmafmu
