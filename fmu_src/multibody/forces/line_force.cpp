#include "multibody/forces/line_force.h"

#include "multibody/constraints/primitives_inline.h"

namespace sigmafmu {

const std::vector<ForcePort>& LineForce::ports() const {
  static const std::vector<ForcePort> table = {
      {"length", 0, "Distance", "Distance of the two points",
       [](const Force& f, const Kinematics& k, const Inputs&, double* x) {
         *x = static_cast<const LineForce&>(f).line(k).length;
       }},
      {"rate", 0, "Velocity", "Rate of the length",
       [](const Force& f, const Kinematics& k, const Inputs&, double* x) {
         *x = static_cast<const LineForce&>(f).line(k).rate;
       }},
      {"force", 0, "Force", "Tension of spring and damper (actuator excluded), positive if it pulls",
       [](const Force& f, const Kinematics& k, const Inputs&, double* x) {
         const auto& self = static_cast<const LineForce&>(f);
         const Line l = self.line(k);
         *x = self.tension(l.length, l.rate).value;
       }},
      {"energy", 0, "Energy", "Elastic energy", energy_output},
      {"power", 0, "Power", "Power of the element on its bodies", power_output, true},
      {"actuatorForce", 0, "Force", "Tension of an actuator along the line, positive if it pulls", nullptr},
  };
  return table;
}

LineForce::Line LineForce::line(const Kinematics& k) const {
  Line l;
  const Vector3d x = points_.gap(k[0], k[1]);
  l.length = x.norm();
  l.inverse_length = l.length > 0 ? 1 / l.length : 0;
  l.e = l.inverse_length * x;
  l.xdot = points_.gap_rate(k[0], k[1]);
  l.rate = l.e.dot(l.xdot);
  return l;
}

double LineForce::energy(const Kinematics& k, const Inputs&) const { return stored(points_.gap(k[0], k[1]).norm()); }

void LineForce::add(const Kinematics& k, const Inputs& u, const FrameForces& r) const {
  const Line l = line(k);
  points_.add_force(k[0], k[1], -(tension(l.length, l.rate).value + *own(u)) * l.e, r);
}

void LineForce::linearize(const Kinematics& k, const Inputs& u, const FramePairs& K, const FramePairs& C) const {
  const Line l = line(k);
  const Tension N = tension(l.length, l.rate);
  const double sum = N.value + *own(u);
  const Matrix3d along = l.e * l.e.transpose();
  const Matrix3d across = l.inverse_length * (Matrix3d::Identity() - along);
  // -df/dx and -df/dx'.
  const Matrix3d by_x = N.by_length * along + N.by_rate * l.e * (across * l.xdot).transpose() + sum * across;
  const Matrix3d by_xdot = N.by_rate * along;
  points_.stiffness(k[0], k[1], sum * l.e, K);
  // B_i = [o_i I, A_i], Z_i = [0, Y_i].
  const double o[2] = {-1.0, 1.0};
  const Vector3d* s[2] = {&points_.s1, &points_.s2};
  const Matrix3d A[2] = {lie::times_hat(k[0].R_WB, *s[0]), lie::times_hat(k[1].R_WB, -*s[1])};
  for (int j = 0; j < 2; ++j) {
    if (!K.has(j, j)) continue;  // the ground
    const Matrix3d Y = lie::times_hat(k[j].R_WB, o[j] * s[j]->cross(k[j].w_WB_B));
    const Matrix3d K_turn = by_x * A[j] + by_xdot * Y, C_turn = by_xdot * A[j];
    const auto add = [&](int i, const Matrix3d& move, const Matrix3d& turn, auto block) {
      block.template topLeftCorner<3, 3>() += (o[i] * o[j]) * move;
      block.template topRightCorner<3, 3>() += o[i] * turn;
      block.template bottomLeftCorner<3, 3>().noalias() += o[j] * A[i].transpose() * move;
      block.template bottomRightCorner<3, 3>().noalias() += A[i].transpose() * turn;
    };
    for (int i = 0; i < 2; ++i) {
      if (!K.has(i, j)) continue;
      add(i, by_x, K_turn, K(i, j));
      add(i, by_xdot, C_turn, C(i, j));
    }
  }
}

}  // namespace sigmafmu
