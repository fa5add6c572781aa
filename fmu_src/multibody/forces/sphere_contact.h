// Two spheres, the centre of body 1's in the origin of frame 1: delta = r_1 + r_2 - |d|, n = d / |d|,
// dn/dd = (I - n n^T) / |d|.
#pragma once

#include "multibody/forces/contact_force.h"

namespace sigmafmu {

class SphereContact final : public ContactForce {
 public:
  SphereContact(const SphereContactDef& d, int index)
      : ContactForce({d.point1, Matrix3d::Identity(), d.node1}, d.point2, d.node2, d.radius2),
        radii_(d.radius1 + d.radius2),
        effective_radius_(d.radius1 * d.radius2 / (d.radius1 + d.radius2)),
        index_(index) {}

  void set_values(const MultibodyDef& d) override { law_.set(d.sphere_contacts[index_].surface, effective_radius_); }

 private:
  Touch touch(const Vector3d& d) const override {
    const double distance = d.norm();
    const Vector3d n = distance > 0 ? Vector3d(d / distance) : Vector3d::UnitZ();
    const double inverse = distance > 0 ? 1 / distance : 0;
    return {radii_ - distance, n, inverse * (Matrix3d::Identity() - n * n.transpose())};
  }

  double radii_, effective_radius_;
  int index_;  // in MultibodyDef::sphere_contacts
};

}  // namespace sigmafmu
