// The scalar or vector equations of which every joint (and spring-damper) is made.
//
// Notation, bodies i = 1, 2: x_i = p_WB, R_i = R_WB, w_i = w_WB_B, s_i a point and n_i, a_i axes in body axes,
// R12 = R_1^T R_2. Motions: delta x_i in W, delta R_i = R_i hat(phi_i). For an equation Phi:
//   Phi' = sum_i B_i v_i,   Z_i = d(Phi')/d(motion of i) at fixed velocities,   Phi'' = B vdot + Z v,
//   K_ij = d(B_i^T lambda)/d(motion of j).
// Rows are written into the joint's blocks from `row` on; K is added.
#pragma once

#include "multibody/kinematics.h"

namespace sigmafmu {

// Phi = x_2 + R_2 s_2 - x_1 - R_1 s_1 in W (3 rows).
struct PointCoincidence {
  Vector3d s1, s2;

  // [m]
  Vector3d gap(const FrameKinematics& b1, const FrameKinematics& b2) const;
  // Phi' [m/s]
  Vector3d gap_rate(const FrameKinematics& b1, const FrameKinematics& b2) const;
  // r -= B^T f: f [N] in W acts on body 2, its opposite on body 1.
  void add_force(const FrameKinematics& b1, const FrameKinematics& b2, const Vector3d& f, const FrameForces& r) const;
  // B_2 = [I, -R_2 hat(s_2)], B_1 = [-I, R_1 hat(s_1)].
  void gradient_1(const FrameKinematics& b1, int row, Rows B1) const;
  void gradient_2(const FrameKinematics& b2, int row, Rows B2) const;
  // Z_2 = [0, -R_2 hat(w_2 x s_2)], Z_1 = [0, R_1 hat(w_1 x s_1)].
  void rate_1(const FrameKinematics& b1, int row, Rows Z1) const;
  void rate_2(const FrameKinematics& b2, int row, Rows Z2) const;
  // K_22 = [0 0; 0 hat(s_2) hat(R_2^T lambda)], K_11 the same with the opposite sign; lambda in W.
  void stiffness(const FrameKinematics& b1, const FrameKinematics& b2, const Vector3d& lambda,
                 const FramePairs& K) const;
};

// Phi = n . (x_2 + R_2 s_2 - x_1 - R_1 s_1), n = R_1 n_1: distance along an axis of body 1 (1 row).
struct AxialDistance {
  Vector3d n1, s1, s2;

  // u = R_1^T (x_2 + R_2 s_2 - x_1): point 2 seen from body 1.
  Vector3d seen_from_1(const FrameKinematics& b1, const FrameKinematics& b2) const;
  // [m]
  double gap(const FrameKinematics& b1, const FrameKinematics& b2) const;
  // B_2 = [n^T, (s_2 x R_2^T n)^T], B_1 = [-n^T, (n_1 x u)^T].
  void gradient(const FrameKinematics& b1, const FrameKinematics& b2, int row, Rows B1, Rows B2) const;
  void rate(const FrameKinematics& b1, const FrameKinematics& b2, int row, Rows Z1, Rows Z2) const;
  void stiffness(const FrameKinematics& b1, const FrameKinematics& b2, double lambda, const FramePairs& K) const;
};

// Phi = (d . d - L^2)/(2 L), d = x_2 + R_2 s_2 - x_1 - R_1 s_1: the distance of two points (1 row) [m]. A polynomial,
// whose multiplier is the force [N] that draws the points together. With PointCoincidence's B, Z and K and e = d/L:
struct PointDistance {
  PointCoincidence points;
  double length = 0;  // L > 0

  double gap(const FrameKinematics& b1, const FrameKinematics& b2) const;
  // e^T B.
  void gradient(const FrameKinematics& b1, const FrameKinematics& b2, int row, Rows B1, Rows B2) const;
  // Phi' = e . d', so e^T Z + (d'/L)^T B.
  void rate(const FrameKinematics& b1, const FrameKinematics& b2, int row, Rows Z1, Rows Z2) const;
  // That for the force lambda e, and lambda/L B_i^T B_j.
  void stiffness(const FrameKinematics& b1, const FrameKinematics& b2, double lambda, const FramePairs& K) const;
};

// Phi = a . b, a = R_1 a_1, b = R_2 b_2: two axes stay perpendicular (1 row, rotations only).
struct PerpendicularAxes {
  Vector3d a1, b2;

  // b in body 1, a in body 2.
  Vector3d b_in_1(const FrameKinematics& k1, const FrameKinematics& k2) const;
  Vector3d a_in_2(const FrameKinematics& k1, const FrameKinematics& k2) const;
  double gap(const FrameKinematics& k1, const FrameKinematics& k2) const;
  // B_1 = [0, (a_1 x b)^T] in body 1, B_2 = [0, (b_2 x a)^T] in body 2.
  void gradient(const FrameKinematics& k1, const FrameKinematics& k2, int row, Rows B1, Rows B2) const;
  void rate(const FrameKinematics& k1, const FrameKinematics& k2, int row, Rows Z1, Rows Z2) const;
  // K_11 = hat(a_1) hat(b), K_22 = hat(b_2) hat(a), K_12 = -hat(a_1) R12 hat(b_2) = K_21^T, times lambda.
  void stiffness(const FrameKinematics& k1, const FrameKinematics& k2, double lambda, const FramePairs& K) const;
};

}  // namespace sigmafmu
