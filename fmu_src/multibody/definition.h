// The plain description of a multibody system: what a mechanism file fills in and what parameters change.
//
// SI units. W is the inertial frame. A body's frame B sits in its centre of mass; points and axes of a body are given
// in B. The ground is body kGround, its frame is W.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace sigmafmu {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;

inline constexpr int kGround = -1;

struct RigidBodyDef {
  std::string name;
  std::string description;
  double mass = 1.0;                                     // [kg]
  Vector3d inertia = Vector3d::Ones();                   // xx, yy, zz about B [kg m^2]
  Vector3d inertia_products = Vector3d::Zero();          // xy, xz, yz: the matrix elements themselves [kg m^2]
  Vector3d initial_position = Vector3d::Zero();          // p_WB [m]
  Vector4d initial_quaternion = Vector4d(1, 0, 0, 0);    // quat_WB (w, x, y, z), any length > 0
  Vector3d initial_velocity = Vector3d::Zero();          // v_WB in W [m/s]
  Vector3d initial_angular_velocity = Vector3d::Zero();  // w_WB_B in B [rad/s]
};

// A right-handed frame fixed in a body: origin [m] and axes (columns x, y, z) in body coordinates.
struct Frame {
  Vector3d origin = Vector3d::Zero();
  Matrix3d axes = Matrix3d::Identity();
};

// Axes whose z is the given direction (need not be unit); equal directions give equal axes.
Matrix3d axes_with_z(const Vector3d& z);

enum class JointType {
  spherical,  // origins coincide
  revolute,   // and z1 = z2; angle from x1 to x2 about z
  universal,  // origins coincide and y1 is perpendicular to x2 (the two axes of the cross)
  prismatic,  // frames parallel, origin 2 on the z axis of frame 1; displacement along it
  fixed,      // frames coincide
};

struct JointDef {
  std::string name;
  JointType type = JointType::spherical;
  int body1 = kGround;
  Frame frame1;
  int body2 = kGround;
  Frame frame2;
};

// Between point1 of body1 and point2 of body2: force on body2 f = -K (p2 - p1) - D (v2 - v1) + f_actuator, with
// diagonal K [N/m], D [N s/m] and all vectors in W.
struct SpringDamperDef {
  std::string name;
  int body1 = kGround;
  Vector3d point1 = Vector3d::Zero();
  int body2 = kGround;
  Vector3d point2 = Vector3d::Zero();
  Vector3d stiffness = Vector3d::Zero();
  Vector3d damping = Vector3d::Zero();
};

// A constant force [N] at B's origin and a constant torque [N m] on a body, both in W.
struct LoadDef {
  std::string name;
  std::string description;
  int body = 0;
  Vector3d force = Vector3d::Zero();
  Vector3d torque = Vector3d::Zero();
};

struct MultibodyDef {
  std::vector<RigidBodyDef> bodies;
  std::vector<JointDef> joints;
  std::vector<SpringDamperDef> spring_dampers;
  std::vector<LoadDef> loads;
  Vector3d gravity = Vector3d::Zero();  // in W [m/s^2]

  // Each returns the index that later calls and `body1`, `body2` refer to.
  int add(RigidBodyDef body);
  int add(JointDef joint);
  int add(SpringDamperDef spring_damper);
  int add(LoadDef load);
};

// Throws std::invalid_argument with one sentence that names the variable, its value and what is allowed: mass and
// inertia that no rigid body can have, a zero quaternion, negative stiffness, numbers that are not finite, unknown
// bodies, axes that are no rotation.
void validate(const MultibodyDef& definition);

}  // namespace sigmafmu
