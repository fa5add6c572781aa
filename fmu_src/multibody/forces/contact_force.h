// What contacts of round bodies share. From frame 1 they see the centre of body 2's sphere at d; the point of contact
// on it is at -r n from there and moves with u = d' + w x c, c = -r n. The force F at this point is the wrench
//
//   W = H^T F,   H = [I, -hat(c)],   (u = H (d', w)),
//
// on the centre, and with delta(d) and n(d) of an element
//
//   dW/dd = H^T (dF/ddelta ddelta/dd + dF/dn dn/dd + dF/du du/dd) + [0; r hat(F) dn/dd],   du/dd = -r hat(w) dn/dd,
//   dW/d(d', w) = H^T dF/du H.
#pragma once

#include "multibody/forces/contact_law.h"
#include "multibody/forces/frame_pair_force.h"

namespace sigmafmu {

class ContactForce : public FramePairForce {
 public:
  const std::vector<ForcePort>& ports() const override;

 protected:
  ContactForce(const Frame& frame1, const Vector3d& centre2, int node2, double radius)
      : FramePairForce(frame1, {centre2, Matrix3d::Identity(), node2}), radius_(radius) {}

  struct Touch {
    double delta;  // penetration [m], negative: the gap
    Vector3d n;    // towards body 2
    Matrix3d n_by_d;
  };
  virtual Touch touch(const Vector3d& d) const = 0;
  ContactLaw law_;

 private:
  Vector3d velocity(const RelativeMotion& x, const Vector3d& n) const { return x.velocity - radius_ * x.w.cross(n); }
  Vector6d wrench(const RelativeMotion& x, const double* u) const override;
  void derivatives(const RelativeMotion& x, const double* u, Matrix6d& by_motion, Matrix6d& by_velocity) const override;
  double stored(const RelativeMotion& x) const override { return law_.energy(touch(x.d).delta); }

  double radius_;  // r
};

}  // namespace sigmafmu
