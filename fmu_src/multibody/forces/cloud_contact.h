// Spheres of radius r about the points p_k of body 2 on the plane z = 0 of frame 1: with the normal n = e_3,
//
//   r_k = Q p_k,   delta_k = r - e_3^T (d + r_k),   a_k = r_k - r n,   u_k = d' + w x a_k,
//   W = sum_k (F_k, a_k x F_k),
//
// and, since dr_k = da_k = -hat(r_k) dphi,
//
//   dF_k = dF/ddelta e_3^T (hat(r_k) dphi - dd) + dF/du (d(d') - hat(a_k) dw - hat(w) hat(r_k) dphi),
//   d(a_k x F_k) = hat(a_k) dF_k + hat(F_k) hat(r_k) dphi.
#pragma once

#include "multibody/forces/contact_law.h"
#include "multibody/forces/frame_pair_force.h"

namespace sigmafmu {

class CloudContact final : public FramePairForce {
 public:
  CloudContact(const CloudContactDef& d, int index)
      : FramePairForce(d.frame1, {Vector3d::Zero(), Matrix3d::Identity(), d.node2}),
        index_(index),
        radius_(d.radius),
        points_(d.points2) {}

  const std::vector<ForcePort>& ports() const override;
  void set_values(const MultibodyDef& d) override { law_.set(d.cloud_contacts[index_].surface, radius_); }

 private:
  double depth(const RelativeMotion& x, const Vector3d& r) const { return radius_ - x.d[2] - r[2]; }
  Vector3d arm(const Vector3d& r) const { return r - radius_ * Vector3d::UnitZ(); }
  Vector6d wrench(const RelativeMotion& x, const double* u) const override;
  void derivatives(const RelativeMotion& x, const double* u, Matrix6d& by_motion, Matrix6d& by_velocity) const override;
  double stored(const RelativeMotion& x) const override;

  int index_;  // in MultibodyDef::cloud_contacts
  double radius_;
  std::vector<Vector3d> points_;
  ContactLaw law_;
};

}  // namespace sigmafmu
