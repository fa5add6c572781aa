// A disk rolls on the plane of x and y of frame 1, whose axes are n_k in body 1, on the side of its normal n = n_z. The
// disk has its centre s_2, axis a and radius r in body 2, and touches the plane in its lowest point. In body 2, with
// s = |n - (a . n) a|, the sine of the angle between axis and normal,
//
//   c = s_2 + r d,   d = -(n - (a . n) a)/s,   t = a x d,
//   delta c = -(r/s) t (q_1 . phi_1 + q_2 . phi_2),   q_2 = t x n,   q_1 = -R12 q_2,
//
// where t points along the track. First comes Phi = n . (x_2 + R_2 c - x_1 - R_1 s_1), then two equations of
// velocities: what touches has none along x and y of frame 1. Each row k of B is that of AxialDistance for n_k and a
// point c that is fixed to body 2: as for the first row c moves across n. To Z_ik and, with f = sum_k lambda_k n_k, to
// K the movement of c adds
//
//   Z_ik: -(r/s) (n_k x w) . t q_i^T,   w = w_2 - w_1,   K_2j: -(r/s) (t x f) q_j^T,   K_1j: -(r/s) R12 (f x t) q_j^T.
//
// Notation as in primitives.h.
#pragma once

#include "multibody/constraints/primitives.h"

namespace sigmafmu {

struct RollingDisk {
  Matrix3d axes1;  // n_x, n_y, n_z
  Vector3d s1, s2, a2;
  double radius = 0;

  struct Contact {
    Vector3d c, t, n;  // in body 2
    double sine;
  };
  Contact contact(const FrameKinematics& b1, const FrameKinematics& b2) const;
  // What touches, in W [m].
  Vector3d touching_point(const FrameKinematics& b1, const FrameKinematics& b2) const;
  double gap(const FrameKinematics& b1, const FrameKinematics& b2) const;
  // Three rows each.
  void gradient(const FrameKinematics& b1, const FrameKinematics& b2, int row, const Rows& B1, const Rows& B2) const;
  void rate(const FrameKinematics& b1, const FrameKinematics& b2, int row, Rows Z1, Rows Z2) const;
  void stiffness(const FrameKinematics& b1, const FrameKinematics& b2, const double* lambda, const FramePairs& K) const;

 private:
  // Of n_k and the point of body 2 that touches.
  AxialDistance distance(int row, const Contact& at) const { return {axes1.col((row + 2) % 3), s1, at.c}; }
};

}  // namespace sigmafmu
