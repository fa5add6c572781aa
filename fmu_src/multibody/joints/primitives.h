// The three scalar or vector equations of which every joint (and spring-damper) is made.
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
  Vector3d gap(const BodyKinematics& b1, const BodyKinematics& b2) const {
    return b2.p_WB + b2.R_WB * s2 - b1.p_WB - b1.R_WB * s1;
  }
  // B_2 = [I, -R_2 hat(s_2)], B_1 = [-I, R_1 hat(s_1)].
  void gradient_1(const BodyKinematics& b1, int row, JointRows& B1) const {
    B1.block<3, 3>(row, 0) = -Matrix3d::Identity();
    B1.block<3, 3>(row, 3).noalias() = b1.R_WB * lie::hat(s1);
  }
  void gradient_2(const BodyKinematics& b2, int row, JointRows& B2) const {
    B2.block<3, 3>(row, 0) = Matrix3d::Identity();
    B2.block<3, 3>(row, 3).noalias() = b2.R_WB * lie::hat(-s2);
  }
  // Z_2 = [0, -R_2 hat(w_2 x s_2)], Z_1 = [0, R_1 hat(w_1 x s_1)].
  void rate_1(const BodyKinematics& b1, int row, JointRows& Z1) const {
    Z1.block<3, 3>(row, 0).setZero();
    Z1.block<3, 3>(row, 3).noalias() = b1.R_WB * lie::hat(b1.w_WB_B.cross(s1));
  }
  void rate_2(const BodyKinematics& b2, int row, JointRows& Z2) const {
    Z2.block<3, 3>(row, 0).setZero();
    Z2.block<3, 3>(row, 3).noalias() = b2.R_WB * lie::hat(s2.cross(b2.w_WB_B));
  }
  // K_22 = [0 0; 0 hat(s_2) hat(R_2^T lambda)], K_11 the same with the opposite sign; lambda in W.
  void stiffness(const BodyKinematics& b1, const BodyKinematics& b2, const Vector3d& lambda,
                 const PairBlocks& K) const {
    if (K.block[0][0]) {
      K.block[0][0]->bottomRightCorner<3, 3>().noalias() -= lie::hat(s1) * lie::hat(b1.R_WB.transpose() * lambda);
    }
    if (K.block[1][1]) {
      K.block[1][1]->bottomRightCorner<3, 3>().noalias() += lie::hat(s2) * lie::hat(b2.R_WB.transpose() * lambda);
    }
  }
};

// Phi = n . (x_2 + R_2 s_2 - x_1 - R_1 s_1), n = R_1 n_1: distance along an axis of body 1 (1 row).
struct AxialDistance {
  Vector3d n1, s1, s2;

  // u = R_1^T (x_2 + R_2 s_2 - x_1): point 2 seen from body 1.
  Vector3d seen_from_1(const BodyKinematics& b1, const BodyKinematics& b2) const {
    return b1.R_WB.transpose() * (b2.p_WB + b2.R_WB * s2 - b1.p_WB);
  }
  // [m]
  double gap(const BodyKinematics& b1, const BodyKinematics& b2) const { return n1.dot(seen_from_1(b1, b2) - s1); }
  // B_2 = [n^T, (s_2 x R_2^T n)^T], B_1 = [-n^T, (n_1 x u)^T].
  void gradient(const BodyKinematics& b1, const BodyKinematics& b2, int row, JointRows& B1, JointRows& B2) const {
    const Vector3d n = b1.R_WB * n1;
    B1.block<1, 3>(row, 0) = -n.transpose();
    B1.block<1, 3>(row, 3) = n1.cross(seen_from_1(b1, b2)).transpose();
    B2.block<1, 3>(row, 0) = n.transpose();
    B2.block<1, 3>(row, 3) = s2.cross(b2.R_WB.transpose() * n).transpose();
  }
  void rate(const BodyKinematics& b1, const BodyKinematics& b2, int row, JointRows& Z1, JointRows& Z2) const {
    const Vector3d n = b1.R_WB * n1;
    const Vector3d ndot_1 = b1.w_WB_B.cross(n1);
    const Vector3d ndot = b1.R_WB * ndot_1;
    const Vector3d sdot_2 = b2.w_WB_B.cross(s2);
    const Vector3d relative_1 = b1.R_WB.transpose() * (b2.v_WB - b1.v_WB + b2.R_WB * sdot_2);
    Z1.block<1, 3>(row, 0) = -ndot.transpose();
    Z1.block<1, 3>(row, 3) = (ndot_1.cross(seen_from_1(b1, b2)) - relative_1.cross(n1)).transpose();
    Z2.block<1, 3>(row, 0) = ndot.transpose();
    Z2.block<1, 3>(row, 3) =
        (sdot_2.cross(b2.R_WB.transpose() * n) - (b2.R_WB.transpose() * ndot).cross(s2)).transpose();
  }
  void stiffness(const BodyKinematics& b1, const BodyKinematics& b2, double lambda, const PairBlocks& K) const {
    const Matrix3d turn = lambda * (b1.R_WB * lie::hat(n1));  // -d(lambda n)/d phi_1
    if (K.block[0][0]) {
      K.block[0][0]->topRightCorner<3, 3>() += turn;
      K.block[0][0]->bottomLeftCorner<3, 3>() += turn.transpose();
      K.block[0][0]->bottomRightCorner<3, 3>() += lambda * (lie::hat(n1) * lie::hat(seen_from_1(b1, b2)));
    }
    if (K.block[1][1]) {
      K.block[1][1]->bottomRightCorner<3, 3>() +=
          lambda * (lie::hat(s2) * lie::hat(b2.R_WB.transpose() * (b1.R_WB * n1)));
    }
    if (K.block[0][1]) {
      const Matrix3d cross = lie::hat(s2) * (b2.R_WB.transpose() * turn);  // -K_21 rotation block
      K.block[1][0]->topRightCorner<3, 3>() -= turn;
      K.block[1][0]->bottomRightCorner<3, 3>() -= cross;
      K.block[0][1]->bottomLeftCorner<3, 3>() -= turn.transpose();
      K.block[0][1]->bottomRightCorner<3, 3>() -= cross.transpose();
    }
  }
};

// Phi = a . b, a = R_1 a_1, b = R_2 b_2: two axes stay perpendicular (1 row, rotations only).
struct PerpendicularAxes {
  Vector3d a1, b2;

  // b in body 1, a in body 2.
  Vector3d b_in_1(const BodyKinematics& k1, const BodyKinematics& k2) const {
    return k1.R_WB.transpose() * (k2.R_WB * b2);
  }
  Vector3d a_in_2(const BodyKinematics& k1, const BodyKinematics& k2) const {
    return k2.R_WB.transpose() * (k1.R_WB * a1);
  }
  double gap(const BodyKinematics& k1, const BodyKinematics& k2) const { return a1.dot(b_in_1(k1, k2)); }
  // B_1 = [0, (a_1 x b)^T] in body 1, B_2 = [0, (b_2 x a)^T] in body 2.
  void gradient(const BodyKinematics& k1, const BodyKinematics& k2, int row, JointRows& B1, JointRows& B2) const {
    B1.block<1, 3>(row, 0).setZero();
    B1.block<1, 3>(row, 3) = a1.cross(b_in_1(k1, k2)).transpose();
    B2.block<1, 3>(row, 0).setZero();
    B2.block<1, 3>(row, 3) = b2.cross(a_in_2(k1, k2)).transpose();
  }
  void rate(const BodyKinematics& k1, const BodyKinematics& k2, int row, JointRows& Z1, JointRows& Z2) const {
    const Vector3d adot = k1.w_WB_B.cross(a1);  // in body 1
    const Vector3d bdot = k2.w_WB_B.cross(b2);  // in body 2
    Z1.block<1, 3>(row, 0).setZero();
    Z1.block<1, 3>(row, 3) =
        (adot.cross(b_in_1(k1, k2)) - (k1.R_WB.transpose() * (k2.R_WB * bdot)).cross(a1)).transpose();
    Z2.block<1, 3>(row, 0).setZero();
    Z2.block<1, 3>(row, 3) =
        (bdot.cross(a_in_2(k1, k2)) - (k2.R_WB.transpose() * (k1.R_WB * adot)).cross(b2)).transpose();
  }
  // K_11 = hat(a_1) hat(b), K_22 = hat(b_2) hat(a), K_12 = -hat(a_1) R12 hat(b_2) = K_21^T, times lambda.
  void stiffness(const BodyKinematics& k1, const BodyKinematics& k2, double lambda, const PairBlocks& K) const {
    if (K.block[0][0]) {
      K.block[0][0]->bottomRightCorner<3, 3>() += lambda * (lie::hat(a1) * lie::hat(b_in_1(k1, k2)));
    }
    if (K.block[1][1]) {
      K.block[1][1]->bottomRightCorner<3, 3>() += lambda * (lie::hat(b2) * lie::hat(a_in_2(k1, k2)));
    }
    if (K.block[0][1]) {
      const Matrix3d R12 = k1.R_WB.transpose() * k2.R_WB;
      const Matrix3d cross = lambda * (lie::hat(a1) * (R12 * lie::hat(b2)));
      K.block[0][1]->bottomRightCorner<3, 3>() -= cross;
      K.block[1][0]->bottomRightCorner<3, 3>() -= cross.transpose();
    }
  }
};

}  // namespace sigmafmu
