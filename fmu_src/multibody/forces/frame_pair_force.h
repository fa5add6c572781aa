// A force F and a torque T that depend on how frame 2 lies and moves, seen from frame 1. In the axes E_1 = R_1 A_1 of
// frame 1, with the origins o_i = p_i + R_i s_i:
//
//   d = E_1^T (o_2 - o_1),   Q = E_1^T E_2,   (d', w) = sum_i G_i v_i,   dQ/dt = hat(w) Q,
//
// and the motions of (d, Q) are the same G_i times the motions of the bodies. F acts at o_2 on body 2, with T; the
// opposite acts on body 1 at the same place. So (F, T) does the power F^T d' + T^T w, and forces and moments of both
// bodies add up to nothing. With a = R_1^T (o_2 - p_1), R12 = R_1^T R_2 and what is in the axes of body 1 instead of
// frame 1 (f = A_1 F, t = A_1 T),
//
//   G_1 = A_1^T [ -R_1^T  hat(a) ]    G_2 = A_1^T [ R_1^T  -R12 hat(s_2) ]
//               [  0     -I      ]                [ 0       R12          ]
//   Z_1 = A_1^T [ hat(w_1) R_1^T  hat(m) - hat(w_1) hat(a) ]
//               [ 0               hat(R12 w_2)             ]
//   Z_2 = A_1^T [ -hat(w_1) R_1^T  hat(w_1) R12 hat(s_2) - R12 hat(y) ]
//               [ 0                -R12 hat(w_2)                      ]
//
// where y = w_2 x s_2 and m = R_1^T (v_2 - v_1) + R12 y. For W = (F, T), dW/d(d, Q) and dW/d(d', w) of an element,
//
//   K_ij -= G_i^T (dW/d(d, Q) G_j + dW/d(d', w) Z_j) + d(G_i^T W)/d(motion of j) at constant W,
//   C_ij -= G_i^T dW/d(d', w) G_j.
#pragma once

#include "multibody/forces/force.h"

namespace sigmafmu {

// All in the axes of frame 1.
struct RelativeMotion {
  Vector3d d;            // [m]
  Matrix3d Q;            // maps the axes of frame 2 to those of frame 1
  Vector3d velocity, w;  // d' and w [m/s, rad/s]
};

class FramePairForce : public Force {
 public:
  int frame_count() const override { return 2; }
  void add(const Kinematics& k, const Inputs& u, const FrameForces& r) const override;
  void linearize(const Kinematics& k, const Inputs& u, const FramePairs& K, const FramePairs& C) const override;
  double energy(const Kinematics& k, const Inputs&) const override { return stored(relative(k)); }

 protected:
  FramePairForce(const Frame& frame1, const Frame& frame2) : frame1_(frame1), frame2_(frame2) {}

  RelativeMotion relative(const Kinematics& k) const;
  // E_1, which maps the axes of frame 1 to W.
  Matrix3d axes(const Kinematics& k) const { return k[0].R_WB * frame1_.axes; }

  // (F, T); `u` are its own inputs.
  virtual Vector6d wrench(const RelativeMotion& x, const double* u) const = 0;
  virtual void derivatives(const RelativeMotion& x, const double* u, Matrix6d& by_motion,
                           Matrix6d& by_velocity) const = 0;
  virtual double stored(const RelativeMotion&) const { return 0; }

 private:
  Frame frame1_, frame2_;
};

}  // namespace sigmafmu
