#include "multibody/point_motion.h"

#include "lie/so3.h"

namespace sigmafmu {
namespace {

// Moves on from a frame to the point s [m] with axes A, which has the rates given, all in the axes of the frame.
struct Step {
  Vector3d s = Vector3d::Zero(), s_rate = Vector3d::Zero(), s_rate2 = Vector3d::Zero();
  Matrix3d A = Matrix3d::Identity();
  Vector3d n = Vector3d::Zero(), n_rate = Vector3d::Zero();  // in the axes A
};

PointMotion after(const PointMotion& m, const Step& step) {
  PointMotion result;
  const Vector3d s = m.R * step.s, s_rate = m.R * step.s_rate;
  result.R = m.R * step.A;
  const Vector3d n = result.R * step.n;
  result.p = m.p + s;
  result.v = m.v + m.w.cross(s) + s_rate;
  result.vdot = m.vdot + m.wdot.cross(s) + m.w.cross(m.w.cross(s) + 2 * s_rate) + m.R * step.s_rate2;
  result.w = m.w + n;
  result.wdot = m.wdot + m.w.cross(n) + result.R * step.n_rate;
  return result;
}

}  // namespace

PointMotion point_motion(const System& system, const Evaluation& e, const VectorXd& vdot, int body,
                         const Frame& frame) {
  PointMotion m;
  if (body != kGround) {
    const FrameKinematics& k = system.kinematics(e, body);
    const double* rates = vdot.data() + kVelocitiesPerBody * body;
    m = {k.p_WB, k.R_WB, k.v_WB, k.R_WB * k.w_WB_B, Vector3d::Map(rates), k.R_WB * Vector3d::Map(rates + 3)};
  }
  if (frame.node != kFloatingFrame) {
    const int f = system.flexible_index(body);
    const FlexibleBody& flexible = system.flexible(f);
    const FlexibleEvaluation& at = e.flexible[f];
    const auto Phi = flexible.shape(frame.node), Psi = flexible.rotation(frame.node);
    const auto zeta_rate2 = vdot.segment(system.modal_velocity(f), flexible.modes());
    const Vector3d theta = Psi.lazyProduct(at.zeta), theta_rate = Psi.lazyProduct(at.zetadot);
    Step step;
    step.s = flexible.position(frame.node, at);
    step.s_rate = Phi.lazyProduct(at.zetadot);
    step.s_rate2 = Phi.lazyProduct(zeta_rate2);
    step.A = lie::exp(theta).toRotationMatrix();
    step.n = lie::tangent_times(theta, theta_rate);
    step.n_rate = lie::tangent_times(theta, Psi.lazyProduct(zeta_rate2)) +
                  lie::tangent_derivative(theta, theta_rate) * theta_rate;
    m = after(m, step);
  }
  Step step;
  step.s = frame.origin;
  step.A = frame.axes;
  return after(m, step);
}

PointMotion seen_from(const PointMotion& r, const PointMotion& point) {
  PointMotion m;
  m.p = point.p - r.p;
  m.R = r.R.transpose() * point.R;
  m.v = point.v - r.v - r.w.cross(m.p);
  m.w = point.w - r.w;
  m.vdot = point.vdot - r.vdot - r.wdot.cross(m.p) - r.w.cross(r.w.cross(m.p) + 2 * m.v);
  m.wdot = point.wdot - r.wdot - r.w.cross(m.w);
  return m;
}

}  // namespace sigmafmu
