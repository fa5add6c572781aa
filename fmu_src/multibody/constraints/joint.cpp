#include "multibody/constraints/joint.h"

#include "multibody/constraints/primitives_inline.h"

namespace sigmafmu {
namespace {

enum Axis { x, y, z };
constexpr int kEquationsPerDisk = 3;

// What each type of joint is made of: origins coincide or not, axes of frame 1 along which the origins have no
// distance, pairs (axis of frame 1, axis of frame 2) that stay perpendicular, and one equation more of some types.
enum class More { nothing, rod, thread, no_twist, disk };
struct Composition {
  bool coincidence = false;
  std::vector<Axis> distances;
  std::vector<std::pair<Axis, Axis>> perpendiculars;
  More more = More::nothing;
};

Composition composition(JointType type) {
  const std::vector<std::pair<Axis, Axis>> parallel = {{x, y}, {y, z}, {z, x}};
  switch (type) {
    case JointType::spherical:
      return {true, {}, {}};
    case JointType::revolute:
      return {true, {}, {{x, z}, {y, z}}};
    case JointType::universal:
      return {true, {}, {{y, x}}};
    case JointType::prismatic:
      return {false, {x, y}, parallel};
    case JointType::fixed:
      return {true, {}, parallel};
    case JointType::cylindrical:
      return {false, {x, y}, {{x, z}, {y, z}}};
    case JointType::planar:
      return {false, {z}, {{x, z}, {y, z}}};
    case JointType::distance:
      return {false, {}, {}, More::rod};
    case JointType::point_on_line:
      return {false, {x, y}, {}};
    case JointType::screw:
      return {false, {x, y}, {{x, z}, {y, z}}, More::thread};
    case JointType::constant_velocity:
      return {true, {}, {}, More::no_twist};
    case JointType::point_in_plane:
      return {false, {z}, {}};
    case JointType::rolling_disk:
      return {false, {}, {}, More::disk};
    case JointType::free:
      return {};
  }
  return {};
}

}  // namespace

Joint::Joint(const JointDef& d, double length)
    : type_(d.type),
      on_ground_(d.body1 == kGround && d.frame1.node == kFloatingFrame),
      origins_{d.frame1.origin, d.frame2.origin},
      frame1_(d.frame1),
      frame2_(d.frame2),
      tells_(d.reaction) {
  const Composition parts = composition(d.type);
  has_coincidence_ = parts.coincidence;
  for (Axis i : parts.distances) {
    distances_.push_back({d.frame1.axes.col(i), d.frame1.origin, d.frame2.origin});
  }
  if (parts.more == More::rod) rods_.push_back({origins_, length});
  const auto axes = [&](Axis i, Axis j) { return PerpendicularAxes{d.frame1.axes.col(i), d.frame2.axes.col(j)}; };
  if (parts.more == More::thread) {
    constexpr double kTurn = 6.28318530717958647692;
    const AxialDistance along = {d.frame1.axes.col(z), d.frame1.origin, d.frame2.origin};
    threads_.push_back({along, axes(x, x), axes(y, x), d.pitch / kTurn});
  }
  for (auto [i, j] : parts.perpendiculars) {
    perpendiculars_.push_back(axes(i, j));
  }
  if (parts.more == More::disk) {
    disks_.push_back({d.frame1.axes, d.frame1.origin, d.frame2.origin, d.frame2.axes.col(z), d.radius});
    velocity_equations_ = 2;
  }
  if (parts.more == More::no_twist) no_twists_.push_back({axes(x, y), axes(y, x)});
  for (const CoordinateType& type : sigmafmu::coordinates(d.type)) coordinates_.emplace_back(type, d.frame1, d.frame2);
  length_equations_ = (has_coincidence_ ? 3 : 0) + static_cast<int>(distances_.size() + rods_.size() + threads_.size());
  length_equations_ += static_cast<int>(kEquationsPerDisk * disks_.size());
  equations_ = length_equations_ + static_cast<int>(perpendiculars_.size() + no_twists_.size());
  couples_frames_ = equations_ > (has_coincidence_ ? 3 : 0);
}

void Joint::evaluate(const Inputs&, const Kinematics& k, double* phi, double* phidot, const FrameRows& B) const {
  const FrameKinematics &k1 = k[0], &k2 = k[1];
  int row = 0;
  if (has_coincidence_) {
    Eigen::Map<Vector3d>{phi} = origins_.gap(k1, k2);
    // On the ground's side it is a constant that nothing reads.
    if (!on_ground_) origins_.gradient_1(k1, row, B[0]);
    origins_.gradient_2(k2, row, B[1]);
    row += 3;
  }
  for (const auto& d : distances_) {
    phi[row] = d.gap(k1, k2);
    d.gradient(k1, k2, row++, B[0], B[1]);
  }
  for (const auto& r : rods_) {
    phi[row] = r.gap(k1, k2);
    r.gradient(k1, k2, row++, B[0], B[1]);
  }
  for (const auto& t : threads_) {
    phi[row] = t.gap(k1, k2);
    t.gradient(k1, k2, row++, B[0], B[1]);
  }
  for (const auto& p : perpendiculars_) {
    phi[row] = p.gap(k1, k2);
    p.gradient(k1, k2, row++, B[0], B[1]);
  }
  for (const auto& t : no_twists_) {
    phi[row] = t.gap(k1, k2);
    t.gradient(k1, k2, row++, B[0], B[1]);
  }
  for (const auto& d : disks_) {
    phi[row] = d.gap(k1, k2);
    phi[row + 1] = phi[row + 2] = 0;
    d.gradient(k1, k2, row, B[0], B[1]);
    row += kEquationsPerDisk;
  }
  const double* row1 = B[0].data();
  const double* row2 = B[1].data();
  for (int i = 0; i < equations_; ++i, row1 += kVelocitiesPerBody, row2 += kVelocitiesPerBody) {
    double sum = 0;
    for (int c = 0; c < 3; ++c) {
      const double rate1 = on_ground_ ? 0.0 : row1[c] * k1.v_WB[c] + row1[3 + c] * k1.w_WB_B[c];
      sum += rate1 + row2[c] * k2.v_WB[c] + row2[3 + c] * k2.w_WB_B[c];
    }
    phidot[i] = sum;
  }
}

void Joint::rates(const Inputs&, const Kinematics& k, const FrameRows& Z, double*) const {
  const FrameKinematics &k1 = k[0], &k2 = k[1];
  int row = 0;
  if (has_coincidence_) {
    if (!on_ground_) origins_.rate_1(k1, row, Z[0]);
    origins_.rate_2(k2, row, Z[1]);
    row += 3;
  }
  for (const auto& d : distances_) d.rate(k1, k2, row++, Z[0], Z[1]);
  for (const auto& r : rods_) r.rate(k1, k2, row++, Z[0], Z[1]);
  for (const auto& t : threads_) t.rate(k1, k2, row++, Z[0], Z[1]);
  for (const auto& p : perpendiculars_) p.rate(k1, k2, row++, Z[0], Z[1]);
  for (const auto& t : no_twists_) t.rate(k1, k2, row++, Z[0], Z[1]);
  for (const auto& d : disks_) d.rate(k1, k2, row, Z[0], Z[1]);
}

void Joint::stiffness(const Inputs&, const Kinematics& k, const double* lambda, const FramePairs& K) const {
  const FrameKinematics &k1 = k[0], &k2 = k[1];
  if (has_coincidence_) {
    origins_.stiffness(k1, k2, Vector3d(lambda[0], lambda[1], lambda[2]), K);
    lambda += 3;
  }
  for (const auto& d : distances_) d.stiffness(k1, k2, *lambda++, K);
  for (const auto& r : rods_) r.stiffness(k1, k2, *lambda++, K);
  for (const auto& t : threads_) t.stiffness(k1, k2, *lambda++, K);
  for (const auto& p : perpendiculars_) p.stiffness(k1, k2, *lambda++, K);
  for (const auto& t : no_twists_) t.stiffness(k1, k2, *lambda++, K);
  for (const auto& d : disks_) d.stiffness(k1, k2, lambda, K);
}

bool Joint::axes_agree(const Kinematics& k) const {
  const Matrix3d R12 = (k[0].R_WB * frame1_.axes).transpose() * (k[1].R_WB * frame2_.axes);
  switch (type_) {
    case JointType::revolute:
    case JointType::cylindrical:
    case JointType::planar:
      return R12(z, z) > 0;
    case JointType::prismatic:
    case JointType::fixed:
      return R12.diagonal().minCoeff() > 0;
    case JointType::screw:
      return R12(z, z) > 0 && threads_[0].turns_agree(k[0], k[1]);
    case JointType::constant_velocity:
      return R12(x, x) + R12(y, y) > 0;
    default:
      return true;
  }
}

Joint::Reaction Joint::reaction(const Kinematics& k, const ConstRows& B2, const double* lambda) const {
  const FrameKinematics& k2 = k[1];
  const Eigen::Map<const Eigen::VectorXd> multipliers(lambda, equations_);
  const Vector3d force = -B2.leftCols<3>().transpose().lazyProduct(multipliers);
  const Vector3d moment =
      -(k2.R_WB * B2.rightCols<3>().transpose().lazyProduct(multipliers));  // about the frame's origin, in W
  if (tells_.is_default() && !disks_.empty()) return {force, Vector3d::Zero()};
  const Vector3d torque = moment - (k2.R_WB * frame2_.origin).cross(force);
  if (tells_.is_default()) return {force, torque};
  const bool at_1 = tells_.at == ReactionDef::At::frame1, in_1 = tells_.axes == ReactionDef::Axes::frame1;
  const Frame& frame = at_1 ? frame1_ : frame2_;
  const FrameKinematics& at = k[at_1 ? 0 : 1];
  const Vector3d point = at.p_WB + at.R_WB * (frame.origin + frame.axes * tells_.point);
  const Vector3d about_point = torque + (k2.p_WB + k2.R_WB * frame2_.origin - point).cross(force);
  if (tells_.axes == ReactionDef::Axes::ground) return {force, about_point};
  const Matrix3d axes = in_1 ? Matrix3d(k[0].R_WB * frame1_.axes) : Matrix3d(k2.R_WB * frame2_.axes);
  return {axes.transpose() * force, axes.transpose() * about_point};
}

}  // namespace sigmafmu
