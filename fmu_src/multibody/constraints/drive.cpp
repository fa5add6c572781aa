#include "multibody/constraints/drive.h"

#include <cmath>
#include <utility>

namespace sigmafmu {
namespace {

constexpr double kTwoPi = 6.28318530717958647692;

double rate(const Rows& B, const FrameKinematics& k) {
  return B.row(0).head<3>().dot(k.v_WB) + B.row(0).tail<3>().dot(k.w_WB_B);
}

}  // namespace

Drive::Drive(const JointCoordinate& coordinate, int index, CubicTable table)
    : coordinate_(coordinate), index_(index), table_(std::move(table)) {
  equations_ = 1;
  length_equations_ = coordinate.is_angle() ? 0 : 1;
  couples_frames_ = coordinate.couples_frames();
}

void Drive::evaluate(const Inputs& u, const Kinematics& k, double* phi, double* phidot, const FrameRows& B) const {
  coordinate_.gradient(k, B);
  const CubicTable::Value y = table_(u.time);
  const double gap = coordinate_.value(k) - u.x[index_] - y.x;
  *phi = coordinate_.is_angle() ? std::remainder(gap, kTwoPi) : gap;
  *phidot = rate(B[0], k[0]) + rate(B[1], k[1]) - u.xdot[index_] - y.xdot;
}

void Drive::rates(const Inputs& u, const Kinematics& k, const FrameRows& Z, double* W) const {
  coordinate_.rates(k, Z);
  *W = -u.xddot[index_] - table_(u.time).xddot;
}

void Drive::stiffness(const Inputs&, const Kinematics& k, const double* lambda, const FramePairs& K) const {
  coordinate_.stiffness(k, -*lambda, K);
}

}  // namespace sigmafmu
