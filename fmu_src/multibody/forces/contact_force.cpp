#include "multibody/forces/contact_force.h"

#include "lie/isotropic_operator.h"

namespace sigmafmu {

const std::vector<ForcePort>& ContactForce::ports() const {
  static const std::vector<ForcePort> table = {
      {"gap", 0, "Gap", "Distance of the surfaces, negative where they penetrate",
       [](const Force& f, const Kinematics& k, const Inputs&, double* x) {
         const auto& self = static_cast<const ContactForce&>(f);
         *x = -self.touch(self.relative(k).d).delta;
       }},
      {"normalForce", 0, "Force", "Normal force between the surfaces",
       [](const Force& f, const Kinematics& k, const Inputs&, double* x) {
         const auto& self = static_cast<const ContactForce&>(f);
         const RelativeMotion m = self.relative(k);
         const Touch t = self.touch(m.d);
         *x = self.law_.normal(t.delta, -t.n.dot(m.velocity));
       }},
      {"force", 3, "Force", "Force of contact and friction on the second body, in W",
       [](const Force& f, const Kinematics& k, const Inputs&, double* x) {
         const auto& self = static_cast<const ContactForce&>(f);
         Vector3d::Map(x) = self.axes(k) * self.wrench(self.relative(k), nullptr).head<3>();
       }},
      {"energy", 0, "Energy", "Elastic energy", energy_output},
      {"power", 0, "Power", "Power of the element on its bodies", power_output},
  };
  return table;
}

Vector6d ContactForce::wrench(const RelativeMotion& x, const double*) const {
  const Touch t = touch(x.d);
  const Vector3d F = law_.force(t.delta, t.n, velocity(x, t.n));
  Vector6d W;
  W << F, -radius_ * t.n.cross(F);
  return W;
}

void ContactForce::derivatives(const RelativeMotion& x, const double*, Matrix6d& by_motion,
                               Matrix6d& by_velocity) const {
  by_motion.setZero();
  by_velocity.setZero();
  const Touch t = touch(x.d);
  if (t.delta <= 0) return;
  const Vector3d u = velocity(x, t.n);
  const ContactLaw::Derivatives F = law_.derivatives(t.delta, t.n, u);
  const Matrix3d Ht = -radius_ * lie::hat(t.n);  // hat(c): the lower block of H^T
  const Matrix3d by_d = -F.by_delta * t.n.transpose() + (F.by_n - radius_ * F.by_u * lie::hat(x.w)) * t.n_by_d;
  by_motion.topLeftCorner<3, 3>() = by_d;
  by_motion.bottomLeftCorner<3, 3>() = Ht * by_d + radius_ * lie::hat(law_.force(t.delta, t.n, u)) * t.n_by_d;
  by_velocity.topLeftCorner<3, 3>() = F.by_u;
  by_velocity.topRightCorner<3, 3>() = -F.by_u * Ht;
  by_velocity.bottomRows<3>() = (Ht * by_velocity.topRows<3>()).eval();
}

}  // namespace sigmafmu
