#include "model/definition.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "model/mechanism.h"

namespace sigmafmu {

std::string key_of(const std::string& name) {
  std::string key;
  for (char c : name) {
    if (c >= 'A' && c <= 'Z') key += '_';
    key += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return key;
}

Matrix3d axes_with_z(const Vector3d& z) {
  const Vector3d e3 = z.normalized();
  Vector3d::Index smallest;
  e3.cwiseAbs().minCoeff(&smallest);
  Matrix3d axes;
  axes.col(0) = Vector3d::Unit(smallest).cross(e3).normalized();
  axes.col(1) = e3.cross(axes.col(0));
  axes.col(2) = e3;
  return axes;
}

ModalDef modal_file(std::string name, int modes) {
  ModalDef modal;
  modal.file = std::move(name);
  modal.modes = modes;
  return modal;
}

double mass(const RigidBodyDef& body) {
  if (!body.modal) return body.mass;
  return body.modal->mass_matrix.size() > 0 ? body.modal->mass_matrix.sum() : body.modal->masses.sum();
}

Matrix3d inertia_matrix(const RigidBodyDef& b) {
  Matrix3d J = b.inertia.asDiagonal();
  J(0, 1) = J(1, 0) = b.inertia_products[0];
  J(0, 2) = J(2, 0) = b.inertia_products[1];
  J(1, 2) = J(2, 1) = b.inertia_products[2];
  return J;
}

const std::vector<std::string>& joint_type_names() {
  static const std::vector<std::string> names = {"spherical",   "revolute", "universal", "prismatic",     "fixed",
                                                 "cylindrical", "planar",   "distance",  "point_on_line", "free"};
  return names;
}

std::string constraint_name(const MultibodyDef& d, int constraint) {
  const auto c = static_cast<std::size_t>(constraint), joints = d.joints.size(), drives = d.drives.size();
  if (c < joints) return d.joints[c].name;
  if (c < joints + drives) return "the drive of " + d.joints[d.drives[c - joints].joint].name;
  return d.couplings[c - joints - drives].name;
}

int MultibodyDef::add(RigidBodyDef body) {
  bodies.push_back(std::move(body));
  return static_cast<int>(bodies.size()) - 1;
}
int MultibodyDef::add(JointDef joint) {
  joints.push_back(std::move(joint));
  return static_cast<int>(joints.size()) - 1;
}
int MultibodyDef::add(SpringDamperDef spring_damper) {
  spring_dampers.push_back(std::move(spring_damper));
  return static_cast<int>(spring_dampers.size()) - 1;
}
int MultibodyDef::add(LoadDef load) {
  loads.push_back(std::move(load));
  return static_cast<int>(loads.size()) - 1;
}
int MultibodyDef::add(JointSpringDef spring) {
  joint_springs.push_back(spring);
  return static_cast<int>(joint_springs.size()) - 1;
}
int MultibodyDef::add(JointFrictionDef friction) {
  joint_frictions.push_back(friction);
  return static_cast<int>(joint_frictions.size()) - 1;
}
int MultibodyDef::add(JointStopDef stop) {
  joint_stops.push_back(stop);
  return static_cast<int>(joint_stops.size()) - 1;
}
int MultibodyDef::add(JointArmatureDef armature) {
  joint_armatures.push_back(armature);
  return static_cast<int>(joint_armatures.size()) - 1;
}
int MultibodyDef::add(RotationMotorDef motor) {
  rotation_motors.push_back(motor);
  return static_cast<int>(rotation_motors.size()) - 1;
}
int MultibodyDef::add(DriveDef drive) {
  drives.push_back(std::move(drive));
  return static_cast<int>(drives.size()) - 1;
}
int MultibodyDef::add(CouplingDef coupling) {
  couplings.push_back(std::move(coupling));
  return static_cast<int>(couplings.size()) - 1;
}
int MultibodyDef::add(MotionDef motion) {
  motions.push_back(std::move(motion));
  return static_cast<int>(motions.size()) - 1;
}
int Mechanism::add(StationDef station) {
  stations.push_back(std::move(station));
  return static_cast<int>(stations.size()) - 1;
}

double size(const MultibodyDef& d) {
  double largest = 0;
  const auto add = [&](int body, const Vector3d& point, int node) {
    if (body == kGround) return;
    const Vector3d origin = node == kFloatingFrame ? Vector3d::Zero() : Vector3d(d.bodies[body].modal->nodes.row(node));
    largest = std::max(largest, (origin + point).norm());
  };
  for (const RigidBodyDef& b : d.bodies) {
    largest = std::max(largest,
                       b.modal ? b.modal->nodes.rowwise().norm().maxCoeff() : std::sqrt(b.inertia.maxCoeff() / b.mass));
  }
  for (const JointDef& j : d.joints) {
    add(j.body1, j.frame1.origin, j.frame1.node);
    add(j.body2, j.frame2.origin, j.frame2.node);
  }
  for (const SpringDamperDef& s : d.spring_dampers) {
    add(s.body1, s.point1, s.node1);
    add(s.body2, s.point2, s.node2);
  }
  return largest;
}

}  // namespace sigmafmu
