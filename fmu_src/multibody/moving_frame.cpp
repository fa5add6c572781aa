#include "multibody/moving_frame.h"

#include "lie/so3.h"

namespace sigmafmu {

MovingFrame::MovingFrame(const MotionDef& d, int first) : position_(d.position), axes_(d.axes), first_(first) {
  for (std::size_t i = 0; i < tables_.size(); ++i) {
    if (d.tables[i]) tables_[i] = CubicTable(d.tables[i]->times, d.tables[i]->values, 0);
  }
}

MovingFrame::Motion MovingFrame::motion(const Inputs& u) const {
  Motion m;
  for (int i = 0; i < kPrescribedPerMotion; ++i) {
    const CubicTable::Value y = tables_[i](u.time);
    m.x[i] = u.x[first_ + i] + y.x;
    m.xdot[i] = u.xdot[first_ + i] + y.xdot;
    m.xddot[i] = u.xddot[first_ + i] + y.xddot;
  }
  return m;
}

FrameKinematics MovingFrame::kinematics(const Inputs& u) const {
  const Motion m = motion(u);
  const Vector3d psi = m.x.tail<3>();
  FrameKinematics k;
  k.p_WB = position_ + m.x.head<3>();
  k.R_WB = axes_ * lie::exp(psi).toRotationMatrix();
  k.v_WB = m.xdot.head<3>();
  k.w_WB_B = lie::tangent_times(psi, m.xdot.tail<3>());
  return k;
}

Vector6d MovingFrame::acceleration(const Inputs& u) const {
  const Motion m = motion(u);
  const Vector3d psi = m.x.tail<3>(), rate = m.xdot.tail<3>();
  Vector6d a;
  a.head<3>() = m.xddot.head<3>();
  a.tail<3>() = lie::tangent_times(psi, m.xddot.tail<3>()) + lie::tangent_derivative(psi, rate) * rate;
  return a;
}

}  // namespace sigmafmu
