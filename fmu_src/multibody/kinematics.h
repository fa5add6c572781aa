// What elements see: the kinematics of frames, and where their rows and blocks for these frames go.
//
// Motions of a frame: delta p_WB in W, delta R_WB = R_WB hat(phi). Velocities (v_WB, w_WB_B) and motions have six
// entries, forces (force in W, torque in B) too.
#pragma once

#include <Eigen/Core>

namespace sigmafmu {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Matrix6Xd = Eigen::Matrix<double, 6, Eigen::Dynamic>;

// Positions (p_WB, quat_WB) and velocities (v_WB, w_WB_B) of a body's frame; modal ones of flexible bodies are apart.
inline constexpr int kPositionsPerBody = 7;
inline constexpr int kVelocitiesPerBody = 6;

struct FrameKinematics {
  Vector3d p_WB = Vector3d::Zero();      // [m]
  Matrix3d R_WB = Matrix3d::Identity();  // maps B to W
  Vector3d v_WB = Vector3d::Zero();      // in W [m/s]
  Vector3d w_WB_B = Vector3d::Zero();    // in B [rad/s]
};

// Of the frames of one element, by their number in it.
class Kinematics {
 public:
  Kinematics(const FrameKinematics* all, const int* frames) : all_(all), frames_(frames) {}
  const FrameKinematics& operator[](int i) const { return all_[frames_[i]]; }
  // Those from one on.
  Kinematics from(int first) const { return {all_, frames_ + first}; }

 private:
  const FrameKinematics* all_;
  const int* frames_;
};

// Equations by the six velocities of a frame.
using Rows = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>>;
using ConstRows = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>>;

// The rows of one element, frame by frame.
class FrameRows {
 public:
  FrameRows(double* values, int rows) : values_(values), rows_(rows) {}
  Rows operator[](int i) const { return {values_ + 6 * rows_ * i, rows_, 6}; }
  FrameRows from(int first) const { return {values_ + 6 * rows_ * first, rows_}; }
  int rows() const { return rows_; }

 private:
  double* values_;
  int rows_;
};

// Generalized forces on the frames of one element, as the residual r = M vdot + g + B^T lambda has them: what acts on a
// body is subtracted. There are none on the ground.
class FrameForces {
 public:
  FrameForces(double* values, const int* offset) : values_(values), offset_(offset) {}
  bool has(int i) const { return offset_[i] >= 0; }
  FrameForces from(int first) const { return {values_, offset_ + first}; }
  Eigen::Map<Vector6d> operator[](int i) const { return Eigen::Map<Vector6d>(values_ + offset_[i]); }

 private:
  double* values_;
  const int* offset_;
};

// Blocks d(force of r on frame i)/d(motion or velocity of frame j) of one element. There is none where i or j is the
// ground or where the element said that it does not couple i and j.
class FramePairs {
 public:
  using Block = Eigen::Map<Matrix6d, Eigen::Aligned16>;

  FramePairs(double* values, const int* offset, int frames) : values_(values), offset_(offset), frames_(frames) {}
  bool has(int i, int j) const { return offset_[i * frames_ + j] >= 0; }
  Block operator()(int i, int j) const { return Block(values_ + offset_[i * frames_ + j]); }
  int frames() const { return frames_; }
  FramePairs from(int first) const { return {values_, offset_ + first * frames_ + first, frames_}; }

 private:
  double* values_;
  const int* offset_;
  int frames_;
};

}  // namespace sigmafmu
