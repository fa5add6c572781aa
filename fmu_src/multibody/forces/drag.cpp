#include "multibody/forces/drag.h"

#include "lie/isotropic_operator.h"

namespace sigmafmu {
namespace {

Vector3d drag(const Vector3d& coefficient, const Vector3d& u) { return -u.norm() * coefficient.cwiseProduct(u); }

Matrix3d drag_derivative(const Vector3d& coefficient, const Vector3d& u) {
  const double speed = u.norm();
  Matrix3d A = (-speed * coefficient).asDiagonal();
  if (speed > 0) A -= coefficient.cwiseProduct(u) * (u / speed).transpose();
  return A;
}

}  // namespace

const std::vector<ForcePort>& Drag::ports() const {
  static const std::vector<ForcePort> table = {
      {"force", 3, "Force", "Force of the medium at the point, in W",
       [](const Force& f, const Kinematics& k, const Inputs&, double* x) {
         const auto& self = static_cast<const Drag&>(f);
         Vector3d::Map(x) = k[0].R_WB * drag(self.coefficient_, self.velocity(k[0]));
       }},
      {"power", 0, "Power", "Power of the element on its body", power_output},
  };
  return table;
}

void Drag::add(const Kinematics& k, const Inputs&, const FrameForces& r) const {
  const Vector3d f = drag(coefficient_, velocity(k[0]));
  r[0].head<3>() -= k[0].R_WB * f;
  r[0].tail<3>() -= point_.cross(f) + drag(rotational_, k[0].w_WB_B);
}

void Drag::linearize(const Kinematics& k, const Inputs&, const FramePairs& K, const FramePairs& C) const {
  using lie::hat;
  const Matrix3d R = k[0].R_WB, s = hat(point_);
  const Vector3d u = velocity(k[0]);
  const Matrix3d by_u = drag_derivative(coefficient_, u);
  const Matrix3d by_turn = by_u * hat(carried(k[0])), by_w = -by_u * s;
  K(0, 0).topRightCorner<3, 3>() -= R * (by_turn - hat(drag(coefficient_, u)));
  K(0, 0).bottomRightCorner<3, 3>() -= s * by_turn;
  C(0, 0).topLeftCorner<3, 3>() -= R * by_u * R.transpose();
  C(0, 0).topRightCorner<3, 3>() -= R * by_w;
  C(0, 0).bottomLeftCorner<3, 3>() -= s * by_u * R.transpose();
  C(0, 0).bottomRightCorner<3, 3>() -= s * by_w + drag_derivative(rotational_, k[0].w_WB_B);
}

}  // namespace sigmafmu
