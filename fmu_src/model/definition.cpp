#include "model/definition.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "model/mechanism.h"

namespace sigmafmu {
namespace {

template <typename Def>
int append(std::vector<Def>& list, Def element) {
  list.push_back(std::move(element));
  return static_cast<int>(list.size()) - 1;
}

}  // namespace

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
  static const std::vector<std::string> names = {"spherical",      "revolute",    "universal", "prismatic",
                                                 "fixed",          "cylindrical", "planar",    "distance",
                                                 "point_on_line",  "free",        "screw",     "constant_velocity",
                                                 "point_in_plane", "rolling_disk"};
  return names;
}

const std::vector<std::string>& sensor_type_names() {
  static const std::vector<std::string> names = {"motion", "imu"};
  return names;
}

const std::vector<std::string>& sensor_axes_names() {
  static const std::vector<std::string> names = {"ground", "reference", "sensor"};
  return names;
}

std::string constraint_name(const MultibodyDef& d, int constraint) {
  const auto c = static_cast<std::size_t>(constraint), joints = d.joints.size(), drives = d.drives.size();
  if (c < joints) return d.joints[c].name;
  if (c < joints + drives) return "the drive of " + d.joints[d.drives[c - joints].joint].name;
  return d.couplings[c - joints - drives].name;
}

int MultibodyDef::add(RigidBodyDef body) { return append(bodies, std::move(body)); }
int MultibodyDef::add(JointDef joint) { return append(joints, std::move(joint)); }
int MultibodyDef::add(SpringDamperDef spring_damper) { return append(spring_dampers, std::move(spring_damper)); }
int MultibodyDef::add(LineSpringDef spring) { return append(line_springs, std::move(spring)); }
int MultibodyDef::add(TableSpringDef spring) { return append(table_springs, std::move(spring)); }
int MultibodyDef::add(TorsionSpringDef spring) { return append(torsion_springs, std::move(spring)); }
int MultibodyDef::add(BushingDef bushing) { return append(bushings, std::move(bushing)); }
int MultibodyDef::add(BearingDef bearing) { return append(bearings, std::move(bearing)); }
int MultibodyDef::add(DragDef drag) { return append(drags, std::move(drag)); }
int MultibodyDef::add(CloudContactDef contact) { return append(cloud_contacts, std::move(contact)); }
int MultibodyDef::add(FollowerForceDef force) { return append(follower_forces, std::move(force)); }
int MultibodyDef::add(PlaneContactDef contact) { return append(plane_contacts, std::move(contact)); }
int MultibodyDef::add(SphereContactDef contact) { return append(sphere_contacts, std::move(contact)); }
int MultibodyDef::add(LoadDef load) { return append(loads, std::move(load)); }
int MultibodyDef::add(TendonDef tendon) { return append(tendons, std::move(tendon)); }
int MultibodyDef::add(JointSpringDef spring) { return append(joint_springs, spring); }
int MultibodyDef::add(JointFrictionDef friction) { return append(joint_frictions, friction); }
int MultibodyDef::add(JointStopDef stop) { return append(joint_stops, stop); }
int MultibodyDef::add(JointArmatureDef armature) { return append(joint_armatures, armature); }
int MultibodyDef::add(RotationMotorDef motor) { return append(rotation_motors, motor); }
int MultibodyDef::add(DriveDef drive) { return append(drives, std::move(drive)); }
int MultibodyDef::add(CouplingDef coupling) { return append(couplings, std::move(coupling)); }
int MultibodyDef::add(MotionDef motion) { return append(motions, std::move(motion)); }
int Mechanism::add(StationDef station) { return append(stations, std::move(station)); }
int Mechanism::add(SensorDef sensor) { return append(sensors, std::move(sensor)); }

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
  for_each_force_list(d, [&](const char*, const auto& forces) {
    for (const auto& force : forces) force.points(add);
  });
  return largest;
}

}  // namespace sigmafmu
