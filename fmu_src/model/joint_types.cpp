// What joints are called, and their coordinates.
#include <cctype>
#include <cmath>

#include "lie/so3.h"
#include "model/definition.h"

namespace sigmafmu {

const std::vector<CoordinateType>& coordinates(JointType type) {
  using Kind = CoordinateKind;
  using Of = CoordinateType::AxisOf;
  constexpr int x = 0, y = 1, z = 2;
  static const CoordinateType angle = {Kind::angle, z, Of::both_frames}, along_x = {Kind::displacement, x, Of::frame1},
                              along_y = {Kind::displacement, y, Of::frame1},
                              along_z = {Kind::displacement, z, Of::frame1};
  static const std::vector<CoordinateType> none, hinge = {angle}, slide = {along_z}, both = {angle, along_z},
                                                 cross = {{Kind::angle, y, Of::frame1}, {Kind::angle, x, Of::frame2}},
                                                 plane = {angle, along_x, along_y}, space = {along_x, along_y, along_z},
                                                 across = {along_x, along_y};
  switch (type) {
    case JointType::revolute:
      return hinge;
    case JointType::prismatic:
    case JointType::point_on_line:
      return slide;
    case JointType::cylindrical:
    case JointType::screw:
      return both;
    case JointType::universal:
      return cross;
    case JointType::planar:
      return plane;
    case JointType::point_in_plane:
      return across;
    case JointType::free:
      return space;
    default:
      return none;
  }
}

std::string JointDef::number(int coordinate) const {
  int same = 0, place = 0;
  for (int c = 0; c < coordinate_count(); ++c) {
    if (turns(c) != turns(coordinate)) continue;
    ++same;
    if (c <= coordinate) ++place;
  }
  return same > 1 ? std::to_string(place) : "";
}

std::string JointDef::word(int coordinate, const char* of_angle, const char* of_displacement) const {
  return (turns(coordinate) ? of_angle : of_displacement) + number(coordinate);
}

std::string JointDef::word_on(int coordinate, const std::string& word) const {
  if (turns(coordinate) || !turns(0)) return word + number(coordinate);
  std::string longer = "displacement" + word + number(coordinate);
  char& first = longer[std::string("displacement").size()];
  first = static_cast<char>(std::toupper(static_cast<unsigned char>(first)));
  return longer;
}

PoseAtStart pose_at_start(const MultibodyDef& d, int body, int node) {
  if (body == kGround) {
    if (node == kFloatingFrame) return {};
    return {d.motions[node].position, d.motions[node].axes};
  }
  const RigidBodyDef& b = d.bodies[body];
  const Vector4d& quat = b.initial_quaternion;
  PoseAtStart pose;
  pose.axes = Eigen::Quaterniond(quat[0], quat[1], quat[2], quat[3]).normalized().toRotationMatrix();
  pose.position = b.initial_position;
  if (node == kFloatingFrame) return pose;
  const ModalDef& modal = *b.modal;
  const VectorXd& zeta = modal.initial_coordinates;
  Vector3d point = modal.nodes.row(node).transpose();
  if (zeta.size() > 0) point += modal.shapes.middleRows<3>(3 * node) * zeta;
  pose.position += pose.axes * point;
  if (zeta.size() > 0 && modal.rotations.size() > 0) {
    pose.axes *= lie::exp(Vector3d(modal.rotations.middleRows<3>(3 * node) * zeta)).toRotationMatrix();
  }
  return pose;
}

namespace {

// Where a frame's origin is at the start, in W.
Vector3d place_at_start(const MultibodyDef& d, int body, const Frame& frame) {
  const PoseAtStart pose = pose_at_start(d, body, frame.node);
  return pose.position + pose.axes * frame.origin;
}

}  // namespace

std::string DriveDef::input_name(const MultibodyDef& d) const {
  const JointDef& j = d.joints[joint];
  switch (motion) {
    case Motion::position:
      return j.name + "." + j.word(coordinate, "drivenAngle", "drivenDisplacement");
    case Motion::rate:
      return j.name + "." + j.word_on(coordinate, "drivenRate");
    case Motion::acceleration:
      break;
  }
  return j.name + "." + j.word_on(coordinate, "drivenAcceleration");
}

double rod_length(const MultibodyDef& d, const JointDef& j) {
  if (!std::isnan(j.length)) return j.length;
  return (place_at_start(d, j.body2, j.frame2) - place_at_start(d, j.body1, j.frame1)).norm();
}

}  // namespace sigmafmu
