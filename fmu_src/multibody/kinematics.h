// Kinematic state of one body, and the matrix types every element shares.
#pragma once

#include <Eigen/Core>

namespace sigmafmu {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// Positions (p_WB, quat_WB) and velocities v = (v_WB, w_WB_B) of a body's frame; modal ones of flexible bodies are
// apart.
inline constexpr int kPositionsPerBody = 7;
inline constexpr int kVelocitiesPerBody = 6;

struct BodyKinematics {
  Vector3d p_WB = Vector3d::Zero();      // [m]
  Matrix3d R_WB = Matrix3d::Identity();  // maps B to W
  Vector3d v_WB = Vector3d::Zero();      // in W [m/s]
  Vector3d w_WB_B = Vector3d::Zero();    // in B [rad/s]
};

// Up to six rows (equations of one joint) by the six velocities of one body; never on the heap.
using JointRows = Eigen::Matrix<double, Eigen::Dynamic, kVelocitiesPerBody, Eigen::RowMajor, 6, kVelocitiesPerBody>;
using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1>;

// d(generalized force on body i)/d(motion of body j), i, j in {1, 2}; null where body i or j is the ground.
struct PairBlocks {
  Matrix6d* block[2][2];
};

}  // namespace sigmafmu
