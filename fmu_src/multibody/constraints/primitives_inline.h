// Definitions of primitives.h, for the files that call them: apart, for the sake of all those that only hold a joint.
#pragma once

#include <cmath>

#include "lie/isotropic_operator.h"
#include "multibody/constraints/primitives.h"

namespace sigmafmu {

inline Vector3d PointCoincidence::gap(const FrameKinematics& b1, const FrameKinematics& b2) const {
  return b2.p_WB + b2.R_WB * s2 - b1.p_WB - b1.R_WB * s1;
}

inline Vector3d PointCoincidence::gap_rate(const FrameKinematics& b1, const FrameKinematics& b2) const {
  return b2.v_WB + b2.R_WB * b2.w_WB_B.cross(s2) - b1.v_WB - b1.R_WB * b1.w_WB_B.cross(s1);
}

inline void PointCoincidence::add_force(const FrameKinematics& b1, const FrameKinematics& b2, const Vector3d& f,
                                        const FrameForces& r) const {
  if (r.has(0)) {
    r[0].head<3>() += f;
    r[0].tail<3>() += s1.cross(b1.R_WB.transpose() * f);
  }
  if (r.has(1)) {
    r[1].head<3>() -= f;
    r[1].tail<3>() -= s2.cross(b2.R_WB.transpose() * f);
  }
}

inline void PointCoincidence::gradient_1(const FrameKinematics& b1, int row, Rows B1) const {
  B1.block<3, 3>(row, 0) = -Matrix3d::Identity();
  B1.block<3, 3>(row, 3).noalias() = lie::times_hat(b1.R_WB, s1);
}

inline void PointCoincidence::gradient_2(const FrameKinematics& b2, int row, Rows B2) const {
  B2.block<3, 3>(row, 0) = Matrix3d::Identity();
  B2.block<3, 3>(row, 3).noalias() = lie::times_hat(b2.R_WB, -s2);
}

inline void PointCoincidence::rate_1(const FrameKinematics& b1, int row, Rows Z1) const {
  Z1.block<3, 3>(row, 0).setZero();
  Z1.block<3, 3>(row, 3).noalias() = lie::times_hat(b1.R_WB, b1.w_WB_B.cross(s1));
}

inline void PointCoincidence::rate_2(const FrameKinematics& b2, int row, Rows Z2) const {
  Z2.block<3, 3>(row, 0).setZero();
  Z2.block<3, 3>(row, 3).noalias() = lie::times_hat(b2.R_WB, s2.cross(b2.w_WB_B));
}

inline void PointCoincidence::stiffness(const FrameKinematics& b1, const FrameKinematics& b2, const Vector3d& lambda,
                                        const FramePairs& K) const {
  if (K.has(0, 0)) {
    K(0, 0).bottomRightCorner<3, 3>() -= lie::hat_times_hat(s1, b1.R_WB.transpose() * lambda);
  }
  if (K.has(1, 1)) {
    K(1, 1).bottomRightCorner<3, 3>() += lie::hat_times_hat(s2, b2.R_WB.transpose() * lambda);
  }
}

inline Vector3d AxialDistance::seen_from_1(const FrameKinematics& b1, const FrameKinematics& b2) const {
  return b1.R_WB.transpose() * (b2.p_WB + b2.R_WB * s2 - b1.p_WB);
}

inline double AxialDistance::gap(const FrameKinematics& b1, const FrameKinematics& b2) const {
  return n1.dot(seen_from_1(b1, b2) - s1);
}

inline void AxialDistance::gradient(const FrameKinematics& b1, const FrameKinematics& b2, int row, Rows B1,
                                    Rows B2) const {
  const Vector3d n = b1.R_WB * n1;
  B1.block<1, 3>(row, 0) = -n.transpose();
  B1.block<1, 3>(row, 3) = n1.cross(seen_from_1(b1, b2)).transpose();
  B2.block<1, 3>(row, 0) = n.transpose();
  B2.block<1, 3>(row, 3) = s2.cross(b2.R_WB.transpose() * n).transpose();
}

inline void AxialDistance::rate(const FrameKinematics& b1, const FrameKinematics& b2, int row, Rows Z1, Rows Z2) const {
  const Vector3d n = b1.R_WB * n1;
  const Vector3d ndot_1 = b1.w_WB_B.cross(n1);
  const Vector3d ndot = b1.R_WB * ndot_1;
  const Vector3d sdot_2 = b2.w_WB_B.cross(s2);
  const Vector3d relative_1 = b1.R_WB.transpose() * (b2.v_WB - b1.v_WB + b2.R_WB * sdot_2);
  Z1.block<1, 3>(row, 0) = -ndot.transpose();
  Z1.block<1, 3>(row, 3) = (ndot_1.cross(seen_from_1(b1, b2)) - relative_1.cross(n1)).transpose();
  Z2.block<1, 3>(row, 0) = ndot.transpose();
  Z2.block<1, 3>(row, 3) = (sdot_2.cross(b2.R_WB.transpose() * n) - (b2.R_WB.transpose() * ndot).cross(s2)).transpose();
}

inline void AxialDistance::stiffness(const FrameKinematics& b1, const FrameKinematics& b2, double lambda,
                                     const FramePairs& K) const {
  const Matrix3d turn = lambda * lie::times_hat(b1.R_WB, n1);  // -d(lambda n)/d phi_1
  if (K.has(0, 0)) {
    K(0, 0).topRightCorner<3, 3>() += turn;
    K(0, 0).bottomLeftCorner<3, 3>() += turn.transpose();
    K(0, 0).bottomRightCorner<3, 3>() += lambda * lie::hat_times_hat(n1, seen_from_1(b1, b2));
  }
  if (K.has(1, 1)) {
    K(1, 1).bottomRightCorner<3, 3>() += lambda * lie::hat_times_hat(s2, b2.R_WB.transpose() * (b1.R_WB * n1));
  }
  if (K.has(0, 1)) {
    const Matrix3d cross = lie::hat(s2) * (b2.R_WB.transpose() * turn);  // -K_21 rotation block
    K(1, 0).topRightCorner<3, 3>() -= turn;
    K(1, 0).bottomRightCorner<3, 3>() -= cross;
    K(0, 1).bottomLeftCorner<3, 3>() -= turn.transpose();
    K(0, 1).bottomRightCorner<3, 3>() -= cross.transpose();
  }
}

inline double PointDistance::gap(const FrameKinematics& b1, const FrameKinematics& b2) const {
  return 0.5 * (points.gap(b1, b2).squaredNorm() / length - length);
}

inline void PointDistance::gradient(const FrameKinematics& b1, const FrameKinematics& b2, int row, Rows B1,
                                    Rows B2) const {
  const Vector3d e = points.gap(b1, b2) / length;
  B1.block<1, 3>(row, 0) = -e.transpose();
  B1.block<1, 3>(row, 3) = -points.s1.cross(b1.R_WB.transpose() * e).transpose();
  B2.block<1, 3>(row, 0) = e.transpose();
  B2.block<1, 3>(row, 3) = points.s2.cross(b2.R_WB.transpose() * e).transpose();
}

inline void PointDistance::rate(const FrameKinematics& b1, const FrameKinematics& b2, int row, Rows Z1, Rows Z2) const {
  const Vector3d e = points.gap(b1, b2) / length;
  const Vector3d sdot_1 = b1.w_WB_B.cross(points.s1), sdot_2 = b2.w_WB_B.cross(points.s2);  // in their bodies
  const Vector3d edot = (b2.v_WB + b2.R_WB * sdot_2 - b1.v_WB - b1.R_WB * sdot_1) / length;
  Z1.block<1, 3>(row, 0) = -edot.transpose();
  Z1.block<1, 3>(row, 3) =
      -(points.s1.cross(b1.R_WB.transpose() * edot) + sdot_1.cross(b1.R_WB.transpose() * e)).transpose();
  Z2.block<1, 3>(row, 0) = edot.transpose();
  Z2.block<1, 3>(row, 3) =
      (points.s2.cross(b2.R_WB.transpose() * edot) + sdot_2.cross(b2.R_WB.transpose() * e)).transpose();
}

inline void PointDistance::stiffness(const FrameKinematics& b1, const FrameKinematics& b2, double lambda,
                                     const FramePairs& K) const {
  points.stiffness(b1, b2, lambda / length * points.gap(b1, b2), K);
  const Matrix3d turns[2] = {b1.R_WB * lie::hat(points.s1), b2.R_WB * lie::hat(-points.s2)};
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      if (!K.has(i, j)) continue;
      const double factor = lambda / length, o_i = i == 0 ? -1.0 : 1.0, o_j = j == 0 ? -1.0 : 1.0;
      auto block = K(i, j);
      block.diagonal().head<3>().array() += factor * o_i * o_j;
      block.topRightCorner<3, 3>() += factor * o_i * turns[j];
      block.bottomLeftCorner<3, 3>() += factor * o_j * turns[i].transpose();
      block.bottomRightCorner<3, 3>() += factor * (turns[i].transpose() * turns[j]);
    }
  }
}

inline Vector3d PerpendicularAxes::b_in_1(const FrameKinematics& k1, const FrameKinematics& k2) const {
  return k1.R_WB.transpose() * (k2.R_WB * b2);
}

inline Vector3d PerpendicularAxes::a_in_2(const FrameKinematics& k1, const FrameKinematics& k2) const {
  return k2.R_WB.transpose() * (k1.R_WB * a1);
}

inline double PerpendicularAxes::gap(const FrameKinematics& k1, const FrameKinematics& k2) const {
  return a1.dot(b_in_1(k1, k2));
}

inline void PerpendicularAxes::gradient(const FrameKinematics& k1, const FrameKinematics& k2, int row, Rows B1,
                                        Rows B2) const {
  B1.block<1, 3>(row, 0).setZero();
  B1.block<1, 3>(row, 3) = a1.cross(b_in_1(k1, k2)).transpose();
  B2.block<1, 3>(row, 0).setZero();
  B2.block<1, 3>(row, 3) = b2.cross(a_in_2(k1, k2)).transpose();
}

inline void PerpendicularAxes::rate(const FrameKinematics& k1, const FrameKinematics& k2, int row, Rows Z1,
                                    Rows Z2) const {
  const Vector3d adot = k1.w_WB_B.cross(a1);  // in body 1
  const Vector3d bdot = k2.w_WB_B.cross(b2);  // in body 2
  Z1.block<1, 3>(row, 0).setZero();
  Z1.block<1, 3>(row, 3) =
      (adot.cross(b_in_1(k1, k2)) - (k1.R_WB.transpose() * (k2.R_WB * bdot)).cross(a1)).transpose();
  Z2.block<1, 3>(row, 0).setZero();
  Z2.block<1, 3>(row, 3) =
      (bdot.cross(a_in_2(k1, k2)) - (k2.R_WB.transpose() * (k1.R_WB * adot)).cross(b2)).transpose();
}

inline void PerpendicularAxes::stiffness(const FrameKinematics& k1, const FrameKinematics& k2, double lambda,
                                         const FramePairs& K) const {
  if (K.has(0, 0)) {
    K(0, 0).bottomRightCorner<3, 3>() += lambda * lie::hat_times_hat(a1, b_in_1(k1, k2));
  }
  if (K.has(1, 1)) {
    K(1, 1).bottomRightCorner<3, 3>() += lambda * lie::hat_times_hat(b2, a_in_2(k1, k2));
  }
  if (K.has(0, 1)) {
    const Matrix3d R12 = k1.R_WB.transpose() * k2.R_WB;
    const Matrix3d cross = lambda * (lie::hat(a1) * lie::times_hat(R12, b2));
    K(0, 1).bottomRightCorner<3, 3>() -= cross;
    K(1, 0).bottomRightCorner<3, 3>() -= cross.transpose();
  }
}

namespace primitives {

// One row for each of two frames.
struct RowPair {
  double values[12] = {};
  Rows first{values, 1, kVelocitiesPerBody}, second{values + 6, 1, kVelocitiesPerBody};

  double rate(const FrameKinematics& k1, const FrameKinematics& k2) const {
    return first.row(0).head<3>().dot(k1.v_WB) + first.row(0).tail<3>().dot(k1.w_WB_B) +
           second.row(0).head<3>().dot(k2.v_WB) + second.row(0).tail<3>().dot(k2.w_WB_B);
  }
};
template <typename Equation>
struct GradientOf : RowPair {
  GradientOf(const Equation& e, const FrameKinematics& k1, const FrameKinematics& k2) {
    e.gradient(k1, k2, 0, first, second);
  }
};
template <typename Equation>
struct RateOf : RowPair {
  RateOf(const Equation& e, const FrameKinematics& k1, const FrameKinematics& k2) { e.rate(k1, k2, 0, first, second); }
};

// K += factor a^T b.
inline void add_product(double factor, const RowPair& a, const RowPair& b, const FramePairs& K) {
  const Rows* rows[] = {&a.first, &a.second};
  const Rows* columns[] = {&b.first, &b.second};
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      if (K.has(i, j)) K(i, j).noalias() += (factor * rows[i]->row(0).transpose()) * columns[j]->row(0);
    }
  }
}

}  // namespace primitives

inline Thread::Values Thread::values(const FrameKinematics& k1, const FrameKinematics& k2) const {
  const double t = along.gap(k1, k2) / lead, c = cosine.gap(k1, k2), d = sine.gap(k1, k2);
  const double sin = std::sin(t), cos = std::cos(t), across = c * sin - d * cos;
  return {lead * across, c * cos + d * sin, lead * sin, -lead * cos, -across / lead, cos, sin};
}

inline double Thread::gap(const FrameKinematics& k1, const FrameKinematics& k2) const { return values(k1, k2).phi; }

inline bool Thread::turns_agree(const FrameKinematics& k1, const FrameKinematics& k2) const {
  return values(k1, k2).s > 0;
}

inline void Thread::gradient(const FrameKinematics& k1, const FrameKinematics& k2, int row, Rows B1, Rows B2) const {
  using primitives::GradientOf;
  const Values F = values(k1, k2);
  const GradientOf s(along, k1, k2);
  const GradientOf c(cosine, k1, k2), d(sine, k1, k2);
  B1.row(row) = F.s * s.first + F.c * c.first + F.d * d.first;
  B2.row(row) = F.s * s.second + F.c * c.second + F.d * d.second;
}

inline void Thread::rate(const FrameKinematics& k1, const FrameKinematics& k2, int row, Rows Z1, Rows Z2) const {
  using primitives::GradientOf;
  using primitives::RateOf;
  const Values F = values(k1, k2);
  const GradientOf s(along, k1, k2);
  const GradientOf c(cosine, k1, k2), d(sine, k1, k2);
  const RateOf s_rate(along, k1, k2);
  const RateOf c_rate(cosine, k1, k2), d_rate(sine, k1, k2);
  const double sdot = s.rate(k1, k2);
  const double bend = F.ss * sdot + F.sc * c.rate(k1, k2) + F.sd * d.rate(k1, k2);
  Z1.row(row) = F.s * s_rate.first + F.c * c_rate.first + F.d * d_rate.first + bend * s.first +
                sdot * (F.sc * c.first + F.sd * d.first);
  Z2.row(row) = F.s * s_rate.second + F.c * c_rate.second + F.d * d_rate.second + bend * s.second +
                sdot * (F.sc * c.second + F.sd * d.second);
}

inline void Thread::stiffness(const FrameKinematics& k1, const FrameKinematics& k2, double lambda,
                              const FramePairs& K) const {
  using primitives::add_product;
  using primitives::GradientOf;
  const Values F = values(k1, k2);
  const GradientOf s(along, k1, k2);
  const GradientOf c(cosine, k1, k2), d(sine, k1, k2);
  along.stiffness(k1, k2, lambda * F.s, K);
  cosine.stiffness(k1, k2, lambda * F.c, K);
  sine.stiffness(k1, k2, lambda * F.d, K);
  add_product(lambda * F.ss, s, s, K);
  add_product(lambda * F.sc, s, c, K);
  add_product(lambda * F.sc, c, s, K);
  add_product(lambda * F.sd, s, d, K);
  add_product(lambda * F.sd, d, s, K);
}

inline double NoTwist::gap(const FrameKinematics& k1, const FrameKinematics& k2) const {
  return 0.5 * (x1_y2.gap(k1, k2) - y1_x2.gap(k1, k2));
}

inline void NoTwist::gradient(const FrameKinematics& k1, const FrameKinematics& k2, int row, Rows B1, Rows B2) const {
  const primitives::GradientOf a(x1_y2, k1, k2), b(y1_x2, k1, k2);
  B1.row(row) = 0.5 * (a.first - b.first);
  B2.row(row) = 0.5 * (a.second - b.second);
}

inline void NoTwist::rate(const FrameKinematics& k1, const FrameKinematics& k2, int row, Rows Z1, Rows Z2) const {
  const primitives::RateOf a(x1_y2, k1, k2), b(y1_x2, k1, k2);
  Z1.row(row) = 0.5 * (a.first - b.first);
  Z2.row(row) = 0.5 * (a.second - b.second);
}

inline void NoTwist::stiffness(const FrameKinematics& k1, const FrameKinematics& k2, double lambda,
                               const FramePairs& K) const {
  x1_y2.stiffness(k1, k2, 0.5 * lambda, K);
  y1_x2.stiffness(k1, k2, -0.5 * lambda, K);
}

}  // namespace sigmafmu
