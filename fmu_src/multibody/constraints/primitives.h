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

// Phi = l sin(s/l - phi) with the distance s along an axis n_1 and the angle phi from x_1 to x_2 about it: s = l phi on
// a thread of lead l [m/rad] (1 row) [m]. With c = cos(phi) = x_1 . x_2, d = sin(phi) = y_1 . x_2 and t = s/l
//
//   Phi = l (c sin t - d cos t),   F_s = c cos t + d sin t,   F_c = l sin t,   F_d = -l cos t,
//   F_ss = (d cos t - c sin t)/l,  F_sc = cos t,   F_sd = sin t,
//   B = F_s B_s + F_c B_c + F_d B_d,
//   Z = F_s Z_s + F_c Z_c + F_d Z_d + (F_ss s' + F_sc c' + F_sd d') B_s + s' (F_sc B_c + F_sd B_d),
//
// and K likewise. No turn of the thread is told from another, so nothing has to be counted.
struct Thread {
  AxialDistance along;
  PerpendicularAxes cosine, sine;
  double lead = 0;

  double gap(const FrameKinematics& k1, const FrameKinematics& k2) const;
  void gradient(const FrameKinematics& k1, const FrameKinematics& k2, int row, Rows B1, Rows B2) const;
  void rate(const FrameKinematics& k1, const FrameKinematics& k2, int row, Rows Z1, Rows Z2) const;
  void stiffness(const FrameKinematics& k1, const FrameKinematics& k2, double lambda, const FramePairs& K) const;
  // Half a turn from the thread Phi is zero as well; false there.
  bool turns_agree(const FrameKinematics& k1, const FrameKinematics& k2) const;

 private:
  struct Values {
    double phi, s, c, d, ss, sc, sd;  // Phi, F_s, F_c, ...
  };
  Values values(const FrameKinematics& k1, const FrameKinematics& k2) const;
};

// Phi = (x_1 . y_2 - y_1 . x_2)/2: frame 2 comes from frame 1 by a turn about an axis of the plane of x_1 and y_1,
// without twist (1 row, rotations only). Then both axes z turn equally fast: (w_2 - w_1) . (z_1 + z_2) = 0.
struct NoTwist {
  PerpendicularAxes x1_y2, y1_x2;

  double gap(const FrameKinematics& k1, const FrameKinematics& k2) const;
  void gradient(const FrameKinematics& k1, const FrameKinematics& k2, int row, Rows B1, Rows B2) const;
  void rate(const FrameKinematics& k1, const FrameKinematics& k2, int row, Rows Z1, Rows Z2) const;
  void stiffness(const FrameKinematics& k1, const FrameKinematics& k2, double lambda, const FramePairs& K) const;
};

}  // namespace sigmafmu
