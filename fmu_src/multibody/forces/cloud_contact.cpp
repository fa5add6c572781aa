#include "multibody/forces/cloud_contact.h"

#include <algorithm>
#include <limits>

#include "lie/isotropic_operator.h"

namespace sigmafmu {

const std::vector<ForcePort>& CloudContact::ports() const {
  static const std::vector<ForcePort> table = {
      {"gap", 0, "Gap", "Distance of the nearest sphere from the plane, negative where it penetrates",
       [](const Force& f, const Kinematics& k, const Inputs&, double* x) {
         const auto& self = static_cast<const CloudContact&>(f);
         const RelativeMotion m = self.relative(k);
         *x = std::numeric_limits<double>::infinity();
         for (const Vector3d& p : self.points_) *x = std::min(*x, -self.depth(m, m.Q * p));
       }},
      {"normalForce", 0, "Force", "Sum of the normal forces",
       [](const Force& f, const Kinematics& k, const Inputs&, double* x) {
         const auto& self = static_cast<const CloudContact&>(f);
         *x = self.wrench(self.relative(k), nullptr)[2];
       }},
      {"force", 3, "Force", "Force of contact and friction on the second body, in W",
       [](const Force& f, const Kinematics& k, const Inputs&, double* x) {
         const auto& self = static_cast<const CloudContact&>(f);
         Vector3d::Map(x) = self.axes(k) * self.wrench(self.relative(k), nullptr).head<3>();
       }},
      {"energy", 0, "Energy", "Elastic energy", energy_output},
      {"power", 0, "Power", "Power of the element on its bodies", power_output},
  };
  return table;
}

double CloudContact::stored(const RelativeMotion& x) const {
  double energy = 0;
  for (const Vector3d& p : points_) energy += law_.energy(depth(x, x.Q * p));
  return energy;
}

Vector6d CloudContact::wrench(const RelativeMotion& x, const double*) const {
  Vector6d W = Vector6d::Zero();
  for (const Vector3d& p : points_) {
    const Vector3d r = x.Q * p, a = arm(r);
    const Vector3d F = law_.force(depth(x, r), Vector3d::UnitZ(), x.velocity + x.w.cross(a));
    W.head<3>() += F;
    W.tail<3>() += a.cross(F);
  }
  return W;
}

void CloudContact::derivatives(const RelativeMotion& x, const double*, Matrix6d& by_motion,
                               Matrix6d& by_velocity) const {
  using lie::hat;
  by_motion.setZero();
  by_velocity.setZero();
  const Vector3d n = Vector3d::UnitZ();
  for (const Vector3d& p : points_) {
    const Vector3d r = x.Q * p, a = arm(r), u = x.velocity + x.w.cross(a);
    const double delta = depth(x, r);
    if (delta <= 0) continue;
    const ContactLaw::Derivatives F = law_.derivatives(delta, n, u);
    const Matrix3d hat_r = hat(r), hat_a = hat(a);
    const Matrix3d by_d = -F.by_delta * n.transpose();
    const Matrix3d by_turn = -by_d * hat_r - F.by_u * hat(x.w) * hat_r;
    const Matrix3d by_w = -F.by_u * hat_a;
    by_motion.topLeftCorner<3, 3>() += by_d;
    by_motion.topRightCorner<3, 3>() += by_turn;
    by_motion.bottomLeftCorner<3, 3>() += hat_a * by_d;
    by_motion.bottomRightCorner<3, 3>() += hat_a * by_turn + hat(law_.force(delta, n, u)) * hat_r;
    by_velocity.topLeftCorner<3, 3>() += F.by_u;
    by_velocity.topRightCorner<3, 3>() += by_w;
    by_velocity.bottomLeftCorner<3, 3>() += hat_a * F.by_u;
    by_velocity.bottomRightCorner<3, 3>() += hat_a * by_w;
  }
}

}  // namespace sigmafmu
