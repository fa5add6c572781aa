#include "multibody/joints/joint.h"

#include <cmath>

#include "multibody/joints/primitives_inline.h"

namespace sigmafmu {
namespace {

enum Axis { x, y, z };

// What each type of joint is made of: origins coincide or not, axes of frame 1 along which the origins have no
// distance, and pairs (axis of frame 1, axis of frame 2) that stay perpendicular.
struct Composition {
  bool coincidence;
  std::vector<Axis> distances;
  std::vector<std::pair<Axis, Axis>> perpendiculars;
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
  }
  return {};
}

}  // namespace

Joint::Joint(const JointDef& d)
    : type_(d.type),
      body1_(d.body1),
      body2_(d.body2),
      origins_{d.frame1.origin, d.frame2.origin},
      frame1_(d.frame1),
      frame2_(d.frame2) {
  const Composition parts = composition(d.type);
  has_coincidence_ = parts.coincidence;
  for (Axis i : parts.distances) {
    distances_.push_back({d.frame1.axes.col(i), d.frame1.origin, d.frame2.origin});
  }
  for (auto [i, j] : parts.perpendiculars) {
    perpendiculars_.push_back({d.frame1.axes.col(i), d.frame2.axes.col(j)});
  }
  equations_ = (has_coincidence_ ? 3 : 0) + static_cast<int>(distances_.size() + perpendiculars_.size());
}

JointEvaluation Joint::make_evaluation() const {
  JointEvaluation e;
  e.phi.setZero(equations_);
  e.phidot.setZero(equations_);
  for (int i = 0; i < 2; ++i) {
    e.B[i].setZero(equations_, kVelocitiesPerBody);
    e.Z[i].setZero(equations_, kVelocitiesPerBody);
  }
  return e;
}

void Joint::constraint(const BodyKinematics& k1, const BodyKinematics& k2, JointEvaluation& e) const {
  int row = 0;
  if (has_coincidence_) {
    e.phi.segment<3>(row) = origins_.gap(k1, k2);
    // On the ground's side it is a constant that nothing reads.
    if (body1_ != kGround) origins_.gradient_1(k1, row, e.B[0]);
    origins_.gradient_2(k2, row, e.B[1]);
    row += 3;
  }
  for (const auto& d : distances_) {
    e.phi[row] = d.gap(k1, k2);
    d.gradient(k1, k2, row++, e.B[0], e.B[1]);
  }
  for (const auto& p : perpendiculars_) {
    e.phi[row] = p.gap(k1, k2);
    p.gradient(k1, k2, row++, e.B[0], e.B[1]);
  }
  const double* row1 = e.B[0].data();
  const double* row2 = e.B[1].data();
  for (int i = 0; i < equations_; ++i, row1 += kVelocitiesPerBody, row2 += kVelocitiesPerBody) {
    double sum = 0;
    for (int c = 0; c < 3; ++c) {
      sum += row1[c] * k1.v_WB[c] + row1[3 + c] * k1.w_WB_B[c] + row2[c] * k2.v_WB[c] + row2[3 + c] * k2.w_WB_B[c];
    }
    e.phidot[i] = sum;
  }
}

void Joint::rate(const BodyKinematics& k1, const BodyKinematics& k2, JointEvaluation& e) const {
  int row = 0;
  if (has_coincidence_) {
    if (body1_ != kGround) origins_.rate_1(k1, row, e.Z[0]);
    origins_.rate_2(k2, row, e.Z[1]);
    row += 3;
  }
  for (const auto& d : distances_) d.rate(k1, k2, row++, e.Z[0], e.Z[1]);
  for (const auto& p : perpendiculars_) p.rate(k1, k2, row++, e.Z[0], e.Z[1]);
}

void Joint::stiffness(const BodyKinematics& k1, const BodyKinematics& k2, const double* lambda, double motor,
                      const PairBlocks& K) const {
  if (has_coincidence_) {
    origins_.stiffness(k1, k2, Vector3d(lambda[0], lambda[1], lambda[2]), K);
    lambda += 3;
  }
  for (const auto& d : distances_) d.stiffness(k1, k2, *lambda++, K);
  for (const auto& p : perpendiculars_) p.stiffness(k1, k2, *lambda++, K);
  if (type_ == JointType::prismatic && motor != 0.0) {
    AxialDistance{frame1_.axes.col(z), frame1_.origin, frame2_.origin}.stiffness(k1, k2, -motor, K);
  }
}

void Joint::add_motor(const BodyKinematics& k1, const BodyKinematics& k2, double motor, double* r1, double* r2) const {
  using Map6 = Eigen::Map<Vector6d>;
  if (type_ == JointType::revolute) {  // +torque about z on body 2, -torque on body 1
    if (r1) Map6(r1).tail<3>() += motor * frame1_.axes.col(z);
    if (r2) Map6(r2).tail<3>() -= motor * frame2_.axes.col(z);
  } else if (type_ == JointType::prismatic) {  // works on d(displacement)
    const Vector3d n1 = frame1_.axes.col(z);
    const Vector3d n = k1.R_WB * n1;
    const AxialDistance along{n1, frame1_.origin, frame2_.origin};
    if (r1) {
      Map6(r1).head<3>() += motor * n;
      Map6(r1).tail<3>() -= motor * n1.cross(along.seen_from_1(k1, k2));
    }
    if (r2) {
      Map6(r2).head<3>() -= motor * n;
      Map6(r2).tail<3>() -= motor * frame2_.origin.cross(k2.R_WB.transpose() * n);
    }
  }
}

bool Joint::axes_agree(const BodyKinematics& k1, const BodyKinematics& k2) const {
  const Matrix3d R12 = (k1.R_WB * frame1_.axes).transpose() * (k2.R_WB * frame2_.axes);
  switch (type_) {
    case JointType::revolute:
      return R12(z, z) > 0;
    case JointType::prismatic:
    case JointType::fixed:
      return R12.diagonal().minCoeff() > 0;
    default:
      return true;
  }
}

double Joint::coordinate(const BodyKinematics& k1, const BodyKinematics& k2) const {
  if (type_ == JointType::prismatic) {
    return AxialDistance{frame1_.axes.col(z), frame1_.origin, frame2_.origin}.gap(k1, k2);
  }
  const Vector3d x2 = k1.R_WB.transpose() * (k2.R_WB * frame2_.axes.col(x));
  return std::atan2(frame1_.axes.col(y).dot(x2), frame1_.axes.col(x).dot(x2));
}

double Joint::coordinate_rate(const BodyKinematics& k1, const BodyKinematics& k2) const {
  const Vector3d n1 = frame1_.axes.col(z);
  if (type_ == JointType::prismatic) {
    const Vector3d n = k1.R_WB * n1;
    const AxialDistance along{n1, frame1_.origin, frame2_.origin};
    return n.dot(k2.v_WB - k1.v_WB) + k1.w_WB_B.dot(n1.cross(along.seen_from_1(k1, k2))) +
           k2.w_WB_B.dot(frame2_.origin.cross(k2.R_WB.transpose() * n));
  }
  return n1.dot(k1.R_WB.transpose() * (k2.R_WB * k2.w_WB_B) - k1.w_WB_B);
}

Joint::Reaction Joint::reaction(const BodyKinematics& k2, const JointEvaluation& e, const double* lambda) const {
  const Eigen::Map<const Eigen::VectorXd> multipliers(lambda, equations_);
  const Vector3d force = -(e.B[1].leftCols<3>().transpose() * multipliers);
  const Vector3d moment = -(k2.R_WB * (e.B[1].rightCols<3>().transpose() * multipliers));  // about the COM, in W
  return {force, moment - (k2.R_WB * frame2_.origin).cross(force)};
}

}  // namespace sigmafmu
