#include "multibody/forces/bushing.h"

#include "lie/so3.h"

namespace sigmafmu {

const std::vector<ForcePort>& Bushing::ports() const {
  static const std::vector<ForcePort> table = {
      {"displacement", 3, "Displacement", "Displacement of the second frame, in the axes of the first",
       [](const Force& f, const Kinematics& k, const Inputs&, double* x) {
         Vector3d::Map(x) = static_cast<const Bushing&>(f).relative(k).d;
       }},
      {"rotation", 3, "Angle", "Rotation vector from the first frame to the second",
       [](const Force& f, const Kinematics& k, const Inputs&, double* x) {
         Vector3d::Map(x) = deformation(static_cast<const Bushing&>(f).relative(k)).x.tail<3>();
       }},
      {"force", 3, "Force", "Force on the second body, in the axes of the first frame",
       [](const Force& f, const Kinematics& k, const Inputs&, double* x) {
         const auto& self = static_cast<const Bushing&>(f);
         Vector3d::Map(x) = self.wrench(self.relative(k), nullptr).head<3>();
       }},
      {"torque", 3, "Torque", "Torque on the second body about its frame's origin, in the axes of the first frame",
       [](const Force& f, const Kinematics& k, const Inputs&, double* x) {
         const auto& self = static_cast<const Bushing&>(f);
         Vector3d::Map(x) = self.wrench(self.relative(k), nullptr).tail<3>();
       }},
      {"energy", 0, "Energy", "Elastic energy", energy_output},
      {"power", 0, "Power", "Power of the element on its bodies", power_output},
  };
  return table;
}

void Bushing::set_values(const MultibodyDef& definition) {
  stiffness_ = definition.bushings[index_].stiffness_matrix();
  damping_ = definition.bushings[index_].damping_matrix();
}

Stiffest Bushing::stiffest() const {
  return {stiffness_.diagonal().head<3>().maxCoeff(), stiffness_.diagonal().tail<3>().maxCoeff()};
}

Bushing::Deformation Bushing::deformation(const RelativeMotion& m) {
  Deformation s;
  const Vector3d psi = lie::log(lie::Quaterniond(m.Q));
  s.P = lie::tangent_inverse(-psi);
  s.x << m.d, psi;
  s.xdot << m.velocity, s.P * m.w;
  return s;
}

double Bushing::stored(const RelativeMotion& m) const {
  const Vector6d x = deformation(m).x;
  return 0.5 * x.dot(stiffness_ * x);
}

Vector6d Bushing::wrench(const RelativeMotion& m, const double*) const {
  const Deformation s = deformation(m);
  const Vector6d y = load(s);
  Vector6d W;
  W << -y.head<3>(), -(s.P.transpose() * y.tail<3>());
  return W;
}

void Bushing::derivatives(const RelativeMotion& m, const double*, Matrix6d& by_motion, Matrix6d& by_velocity) const {
  const Deformation s = deformation(m);
  const Vector3d psi = s.x.tail<3>();
  const auto rotate = [&](Matrix6d& A) {  // -L^T A L
    A.rightCols<3>() = (A.rightCols<3>() * s.P).eval();
    A.bottomRows<3>() = (s.P.transpose() * A.bottomRows<3>()).eval();
    A = -A;
  };
  by_motion = stiffness_;
  // dP w/dpsi: what the rate of psi owes to a turn.
  by_motion.rightCols<3>() -= damping_.rightCols<3>() * lie::tangent_inverse_derivative(-psi, m.w);
  rotate(by_motion);
  by_motion.bottomRightCorner<3, 3>() -= lie::tangent_inverse_derivative(psi, load(s).tail<3>()) * s.P;
  by_velocity = damping_;
  rotate(by_velocity);
}

}  // namespace sigmafmu
