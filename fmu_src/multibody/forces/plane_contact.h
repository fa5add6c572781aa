// A sphere of body 2 on the plane z = 0 of frame 1: delta = r - d_z, n = e_3.
#pragma once

#include "multibody/forces/contact_force.h"

namespace sigmafmu {

class PlaneContact final : public ContactForce {
 public:
  PlaneContact(const PlaneContactDef& d, int index)
      : ContactForce(d.frame1, d.point2, d.node2, d.radius), radius_(d.radius), index_(index) {}

  void set_values(const MultibodyDef& d) override { law_.set(d.plane_contacts[index_].surface, radius_); }

 private:
  Touch touch(const Vector3d& d) const override { return {radius_ - d[2], Vector3d::UnitZ(), Matrix3d::Zero()}; }

  double radius_;
  int index_;  // in MultibodyDef::plane_contacts
};

}  // namespace sigmafmu
