// A frame of the ground that moves as six functions of time say: displacement d in W, rotation vector psi in its axes
// where psi = 0. With the tangent operator T of SO(3),
//
//   p = p_0 + d,   v = d',   v' = d'',   R = R_0 exp(hat(psi)),   w = T psi',   w' = T psi'' + (dT/dpsi psi') psi'.
#pragma once

#include <array>

#include "model/definition.h"
#include "multibody/cubic_table.h"
#include "multibody/input_signal.h"
#include "multibody/kinematics.h"

namespace sigmafmu {

inline constexpr int kPrescribedPerMotion = 6;

class MovingFrame {
 public:
  // `first`: of its six numbers in Inputs::x, to which its tables are added.
  MovingFrame(const MotionDef& definition, int first);

  FrameKinematics kinematics(const Inputs& u) const;
  // (v', w').
  Vector6d acceleration(const Inputs& u) const;

 private:
  struct Motion {
    Vector6d x, xdot, xddot;
  };
  Motion motion(const Inputs& u) const;

  Vector3d position_;
  Matrix3d axes_;
  std::array<CubicTable, kPrescribedPerMotion> tables_;
  int first_;
};

}  // namespace sigmafmu
