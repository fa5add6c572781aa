#include "multibody/forces/rotation_motor.h"

#include "lie/so3.h"

namespace sigmafmu {

const std::vector<ForcePort>& RotationMotor::ports() const {
  static const std::vector<ForcePort> table = {
      {"rotationVector", 3, "Angle",
       "Orientation of the second frame in the first one, at most pi long: it jumps where the turn passes pi",
       [](const Force& f, const Kinematics& k, const Inputs&, double* x) {
         Vector3d::Map(x) = static_cast<const RotationMotor&>(f).rotation_vector(k);
       }},
      {"relativeAngularVelocity", 3, "AngularVelocity",
       "Angular velocity of the second body against the first one, in the axes of the joint's first frame",
       [](const Force& f, const Kinematics& k, const Inputs&, double* x) {
         Vector3d::Map(x) = static_cast<const RotationMotor&>(f).angular_velocity(k);
       }},
      {"motorTorque", 3, "Torque", "Torque on the second body, in the axes of the joint's first frame", nullptr},
      {"motorPower", 0, "Power", "Power of the motor in the joint", power_output, true},
  };
  return table;
}

Vector3d RotationMotor::rotation_vector(const Kinematics& k) const {
  const Matrix3d R12 = (k[0].R_WB * axes1_).transpose() * (k[1].R_WB * axes2_);
  return lie::log(Eigen::Quaterniond(R12).normalized());
}

Vector3d RotationMotor::angular_velocity(const Kinematics& k) const {
  return axes1_.transpose() * (k[0].R_WB.transpose() * (k[1].R_WB * k[1].w_WB_B) - k[0].w_WB_B);
}

void RotationMotor::add(const Kinematics& k, const Inputs& u, const FrameForces& r) const {
  const Vector3d n = torque_in_1(u);
  if (r.has(0)) r[0].tail<3>() += n;
  if (r.has(1)) r[1].tail<3>() -= k[1].R_WB.transpose() * (k[0].R_WB * n);
}

// dm = hat(m) phi_2 - R_2^T R_1 hat(n) phi_1.
void RotationMotor::linearize(const Kinematics& k, const Inputs& u, const FramePairs& K, const FramePairs&) const {
  const Vector3d n = torque_in_1(u);
  if (!K.has(1, 1)) return;
  K(1, 1).bottomRightCorner<3, 3>() -= lie::hat(k[1].R_WB.transpose() * (k[0].R_WB * n));
  if (K.has(1, 0)) {
    K(1, 0).bottomRightCorner<3, 3>() += k[1].R_WB.transpose() * (k[0].R_WB * lie::hat(n));
  }
}

}  // namespace sigmafmu
