#include "multibody/system.h"

#include <algorithm>
#include <cmath>

#include "lie/r3xso3.h"
#include "multibody/bodies/rigid_body_inline.h"

namespace sigmafmu {
namespace {

using Segment6 = Eigen::Map<Vector6d>;

}  // namespace

System::System(const MultibodyDef& d) : size_(sigmafmu::size(d)) {
  const int n = body_count_ = static_cast<int>(d.bodies.size());
  pattern_.body_sizes.assign(n, kVelocitiesPerBody);
  for (int i = 0; i < n; ++i) {
    flexible_index_.push_back(d.bodies[i].modal ? flexible_count() : -1);
    if (!d.bodies[i].modal) continue;
    flexible_.emplace_back(*d.bodies[i].modal);
    flexible_bodies_.push_back(i);
    modal_index_.push_back(modal_count_);
    modal_count_ += flexible_.back().modes();
    pattern_.modal_sizes.push_back(flexible_.back().modes());
  }
  bodies_.resize(n);
  loads_.resize(d.loads.size());
  nodes_ = n + flexible_count();
  pair_table_.assign(nodes_ * nodes_, -1);
  for (int i = 0; i < n; ++i) add_pair(i, i);
  for (int f = 0; f < flexible_count(); ++f) {
    const int frame = flexible_bodies_[f], modes = pattern_.modal_node(f);
    add_pair(frame, modes);
    add_pair(modes, frame);
    add_pair(modes, modes);
  }

  input_size_ = 6 * n;
  node_frames_.push_back({kGround, -1, -1});
  for (const JointDef& definition : d.joints) {
    const Joint joint(definition);
    const int j = static_cast<int>(joints_.size());
    const Ends ends = make_ends(make_end(joint.body1(), definition.frame1.node),
                                make_end(joint.body2(), definition.frame2.node), joint.couples_rotations());
    pattern_.joint_sizes.push_back(joint.equations());
    NodeJoint node_joint{j, {-1, -1}};
    for (int i = 0; i < 2; ++i) {
      const End& end = ends.side[i];
      if (end.body == kGround) continue;
      pattern_.incidences.push_back({j, end.body, i});
      if (end.node_frame == 0) continue;
      node_joint.modal_incidence[i] = static_cast<int>(pattern_.modal_incidences.size());
      pattern_.modal_incidences.push_back({j, flexible_index_[end.body], i});
    }
    if (ends.at_node()) {
      node_joints_.push_back(node_joint);
    } else {
      frame_joints_.push_back(j);
    }
    lambda_index_.push_back(constraint_size_);
    constraint_size_ += joint.equations();
    motor_index_.push_back(joint.has_motor() ? input_size_++ : -1);
    joint_ends_.push_back(ends);
    joints_.push_back(joint);
  }
  for (const SpringDamperDef& definition : d.spring_dampers) {
    const int s = static_cast<int>(spring_dampers_.size());
    spring_dampers_.push_back({definition.body1,
                               definition.body2,
                               {definition.point1, definition.point2},
                               definition.stiffness,
                               definition.damping});
    spring_ends_.push_back(
        make_ends(make_end(definition.body1, definition.node1), make_end(definition.body2, definition.node2), true));
    (spring_ends_.back().at_node() ? node_springs_ : frame_springs_).push_back(s);
    actuator_index_.push_back(input_size_);
    input_size_ += 3;
  }
  set_values(d);
}

System::End System::make_end(int body, int node) {
  if (body == kGround) return {body, body_count(), 0};
  if (node == kFloatingFrame) return {body, body, 0};
  std::size_t k = 1;
  while (k < node_frames_.size() && !(node_frames_[k].body == body && node_frames_[k].node == node)) ++k;
  if (k == node_frames_.size()) node_frames_.push_back({body, flexible_index_[body], node});
  return {body, body_count() + static_cast<int>(k), static_cast<int>(k)};
}

// Adds the blocks that couple two bodies: their frames and, at nodes, their modes.
System::Ends System::make_ends(const End& end1, const End& end2, bool coupled) {
  Ends ends{{end1, end2}, {{-1, -1}, {-1, -1}}};
  for (int i = 0; i < 2; ++i) {
    if (ends.side[i].body != kGround) ends.pair[i][i] = ends.side[i].body;
  }
  if (!coupled || end1.body == kGround || end2.body == kGround) return ends;
  ends.pair[0][1] = add_pair(end1.body, end2.body);
  ends.pair[1][0] = add_pair(end2.body, end1.body);
  std::vector<int> nodes[2];
  for (int i = 0; i < 2; ++i) {
    nodes[i].push_back(ends.side[i].body);
    if (ends.side[i].node_frame > 0) nodes[i].push_back(pattern_.modal_node(flexible_index_[ends.side[i].body]));
  }
  for (int i : nodes[0]) {
    for (int j : nodes[1]) {
      add_pair(i, j);
      add_pair(j, i);
    }
  }
  return ends;
}

int System::add_pair(int i, int j) {
  int& index = pair_table_[i * nodes_ + j];
  if (index < 0) {
    auto& pairs = std::max(i, j) < body_count() ? pattern_.body_pairs : pattern_.modal_pairs;
    index = static_cast<int>(pairs.size());
    pairs.emplace_back(i, j);
  }
  return index;
}

void System::set_values(const MultibodyDef& d) {
  for (int i = 0; i < body_count(); ++i) {
    const RigidBodyDef& body = d.bodies[i];
    if (body.modal) {
      bodies_[i] = {0.0, Matrix3d::Zero()};
      flexible_[flexible_index_[i]].set_values(*body.modal);
    } else {
      bodies_[i] = {body.mass, inertia_matrix(body)};
    }
  }
  for (std::size_t s = 0; s < spring_dampers_.size(); ++s) {
    spring_dampers_[s].stiffness = d.spring_dampers[s].stiffness;
    spring_dampers_[s].damping = d.spring_dampers[s].damping;
  }
  for (std::size_t l = 0; l < loads_.size(); ++l) {
    loads_[l] = {d.loads[l].body, d.loads[l].force, d.loads[l].torque};
  }
  gravity_ = d.gravity;
}

Evaluation System::make_evaluation() const {
  Evaluation e;
  e.bodies.resize(body_count() + node_frames_.size());
  for (const Joint& joint : joints_) e.joints.push_back(joint.make_evaluation());
  e.spring_dampers.resize(spring_dampers_.size());
  e.C.resize(pattern_.body_pairs.size());
  e.K.resize(pattern_.body_pairs.size());

  auto modes_of = [&](int node) { return node < body_count() ? 6 : pattern_.modal_sizes[node - body_count()]; };
  for (const FlexibleBody& body : flexible_) e.flexible.push_back(body.make_evaluation());
  for (auto [i, j] : pattern_.modal_pairs) {
    e.modal_C.emplace_back(MatrixXd::Zero(modes_of(i), modes_of(j)));
    e.modal_K.push_back(e.modal_C.back());
  }
  e.modal_M.assign(e.modal_C.begin(), e.modal_C.begin() + 3 * flexible_count());
  for (int f = 0; f < flexible_count(); ++f) e.modal_M[3 * f + 2] = flexible_[f].modal_mass();
  for (const auto& [joint, flexible, side] : pattern_.modal_incidences) {
    const MatrixXd rows = MatrixXd::Zero(joints_[joint].equations(), pattern_.modal_sizes[flexible]);
    e.modal_joints.push_back({rows, rows});
  }
  e.node_frames.push_back(make_node_frame_evaluation(0));
  int most_modes = 0;
  for (std::size_t k = 1; k < node_frames_.size(); ++k) {
    const int modes = pattern_.modal_sizes[node_frames_[k].flexible];
    e.node_frames.push_back(make_node_frame_evaluation(modes));
    most_modes = std::max(most_modes, modes);
  }
  for (const NodeJoint& node_joint : node_joints_) {
    const JointEvaluation& joint = e.joints[node_joint.joint];
    e.node_gradients.push_back({joint.B[0], joint.B[1]});
  }
  e.work.setZero(6, 6 + most_modes);
  return e;
}

void System::evaluate(const VectorXd& q, const VectorXd& v, Evaluation& e) const {
  for (int i = 0; i < body_count(); ++i) {
    const double* qi = q.data() + kPositionsPerBody * i;
    const double* vi = v.data() + kVelocitiesPerBody * i;
    BodyKinematics& k = e.bodies[i];
    k.p_WB = Vector3d(qi[0], qi[1], qi[2]);
    k.R_WB = lie::quaternion(qi).toRotationMatrix();
    k.v_WB = Vector3d(vi[0], vi[1], vi[2]);
    k.w_WB_B = Vector3d(vi[3], vi[4], vi[5]);
  }
  if (!flexible_.empty()) evaluate_flexible(q, v, e);
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const Ends& ends = joint_ends_[j];
    joints_[j].constraint(e.bodies[ends.side[0].frame], e.bodies[ends.side[1].frame], e.joints[j]);
  }
  for (std::size_t s = 0; s < spring_dampers_.size(); ++s) {
    const Ends& ends = spring_ends_[s];
    spring_dampers_[s].evaluate(e.bodies[ends.side[0].frame], e.bodies[ends.side[1].frame], e.spring_dampers[s]);
  }
  if (!node_joints_.empty()) evaluate_node_gradients(e);
}

void System::residual(const Evaluation& e, const VectorXd& vdot, const VectorXd& lambda, const VectorXd& u,
                      VectorXd& r) const {
  for (int i = 0; i < body_count(); ++i) {
    const double* input = u.data() + force_index(i);
    Segment6 ri(r.data() + 6 * i);
    ri = bodies_[i].inertial_force(e.bodies[i], vdot.segment<6>(6 * i));
    ri.head<3>() -= bodies_[i].mass * gravity_ + Vector3d(input[0], input[1], input[2]);
    ri.tail<3>() -= Vector3d(input[3], input[4], input[5]);
  }
  for (const Load& load : loads_) {
    Segment6 ri(r.data() + 6 * load.body);
    ri.head<3>() -= load.force;
    ri.tail<3>() -= e.bodies[load.body].R_WB.transpose() * load.torque;
  }
  auto rows_of = [&](int body) { return body == kGround ? nullptr : r.data() + 6 * body; };
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const Joint& joint = joints_[j];
    const double* multipliers = lambda.data() + lambda_index_[j];
    for (int side = 0; side < 2; ++side) {
      double* ri = rows_of(side == 0 ? joint.body1() : joint.body2());
      if (!ri) continue;
      const double* row = e.joints[j].B[side].data();
      for (int m = 0; m < joint.equations(); ++m, row += kVelocitiesPerBody) {
        for (int c = 0; c < kVelocitiesPerBody; ++c) ri[c] += row[c] * multipliers[m];
      }
    }
    if (joint.has_motor() && u[motor_index_[j]] != 0.0 && !joint_ends_[j].at_node()) {
      joint.add_motor(kinematics(e, joint.body1()), kinematics(e, joint.body2()), u[motor_index_[j]],
                      rows_of(joint.body1()), rows_of(joint.body2()));
    }
  }
  for (int s : frame_springs_) {
    const SpringDamper& spring = spring_dampers_[s];
    const SpringDamperEvaluation& se = e.spring_dampers[s];
    const Vector3d force = spring.force(se) + u.segment<3>(actuator_index_[s]);
    for (int side = 0; side < 2; ++side) {
      double* ri = rows_of(side == 0 ? spring.body1 : spring.body2);
      if (ri) Segment6(ri).noalias() -= se.B[side].topRows<3>().transpose() * force;
    }
  }
  if (!flexible_.empty()) add_flexible_residual(e, vdot, lambda, u, r);
}

void System::constraint_rates(Evaluation& e) const {
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const Ends& ends = joint_ends_[j];
    joints_[j].rate(e.bodies[ends.side[0].frame], e.bodies[ends.side[1].frame], e.joints[j]);
  }
  if (!node_joints_.empty()) evaluate_node_rates(e);
}

void System::linearize(const VectorXd& lambda, const VectorXd& u, Evaluation& e) const {
  for (std::size_t p = 0; p < e.C.size(); ++p) {
    e.C[p].setZero();
    e.K[p].setZero();
  }
  for (int i = 0; i < body_count(); ++i) {
    e.C[i].bottomRightCorner<3, 3>() = bodies_[i].gyroscopic_damping(e.bodies[i]);
  }
  for (const Load& load : loads_) {  // r has -R^T t: d/dphi = -hat(R^T t)
    e.K[load.body].bottomRightCorner<3, 3>() -= lie::hat(e.bodies[load.body].R_WB.transpose() * load.torque);
  }
  for (int j : frame_joints_) {
    const Joint& joint = joints_[j];
    joint.stiffness(attachment(e, j, 0), attachment(e, j, 1), lambda.data() + lambda_index_[j],
                    joint.has_motor() ? u[motor_index_[j]] : 0.0, blocks(e.K, joint_ends_[j]));
  }
  for (int s : frame_springs_) {
    const SpringDamper& spring = spring_dampers_[s];
    const Ends& ends = spring_ends_[s];
    SpringDamperEvaluation& se = e.spring_dampers[s];
    const Vector3d force = spring.force(se) + u.segment<3>(actuator_index_[s]);
    spring.linearize(e.bodies[ends.side[0].frame], e.bodies[ends.side[1].frame], force, se, blocks(e.K, ends),
                     blocks(e.C, ends));
  }
  if (!flexible_.empty()) linearize_at_nodes(lambda, u, e);
}

double System::position_residual(const Evaluation& e) const {
  double worst = 0;
  for (const JointEvaluation& j : e.joints) worst = std::max(worst, j.phi.lpNorm<Eigen::Infinity>());
  return worst;
}

double System::velocity_residual(const Evaluation& e) const {
  double worst = 0;
  for (const JointEvaluation& j : e.joints) worst = std::max(worst, j.phidot.lpNorm<Eigen::Infinity>());
  return worst;
}

double System::kinetic_energy(const Evaluation& e) const {
  double energy = 0;
  for (int i = 0; i < body_count(); ++i) energy += bodies_[i].kinetic_energy(e.bodies[i]);
  for (int f = 0; f < flexible_count(); ++f) {
    energy += flexible_[f].kinetic_energy(e.bodies[flexible_bodies_[f]], e.flexible[f]);
  }
  return energy;
}

double System::potential_energy(const Evaluation& e) const {
  double energy = 0;
  for (int i = 0; i < body_count(); ++i) energy -= bodies_[i].mass * gravity_.dot(e.bodies[i].p_WB);
  for (int f = 0; f < flexible_count(); ++f) {
    energy += flexible_[f].potential_energy(e.bodies[flexible_bodies_[f]], e.flexible[f], gravity_);
  }
  for (std::size_t s = 0; s < spring_dampers_.size(); ++s) {
    energy += spring_dampers_[s].energy(e.spring_dampers[s]);
  }
  return energy;
}

Joint::Reaction System::reaction(const Evaluation& e, int joint, const double* lambda) const {
  const BodyKinematics& k2 = attachment(e, joint, 1);
  for (std::size_t k = 0; k < node_joints_.size(); ++k) {
    if (node_joints_[k].joint != joint) continue;
    JointEvaluation in_frames = e.joints[joint];
    for (int side = 0; side < 2; ++side) in_frames.B[side] = e.node_gradients[k][side];
    return joints_[joint].reaction(k2, in_frames, lambda);
  }
  return joints_[joint].reaction(k2, e.joints[joint], lambda);
}

PairBlocks System::blocks(std::vector<Matrix6d>& matrices, const Ends& ends) {
  PairBlocks result{};
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      const int index = ends.pair[i][j];
      result.block[i][j] = index < 0 ? nullptr : &matrices[index];
    }
  }
  return result;
}

void System::gradient_times(const Evaluation& e, const VectorXd& mu, VectorXd& out) const {
  out.setZero();
  for (const auto& [joint, body, side] : pattern_.incidences) {
    const double* row = e.joints[joint].B[side].data();
    const double* multiplier = mu.data() + lambda_index_[joint];
    double* of_body = out.data() + kVelocitiesPerBody * body;
    for (int m = 0; m < joints_[joint].equations(); ++m, row += kVelocitiesPerBody) {
      for (int c = 0; c < kVelocitiesPerBody; ++c) of_body[c] += multiplier[m] * row[c];
    }
  }
  for (std::size_t k = 0; k < pattern_.modal_incidences.size(); ++k) {
    const auto& [joint, flexible, side] = pattern_.modal_incidences[k];
    const MatrixXd& B = e.modal_joints[k].B;
    const double* multiplier = mu.data() + lambda_index_[joint];
    for (int m = 0; m < B.rows(); ++m) {
      out.segment(modal_velocity(flexible), B.cols()) += multiplier[m] * B.row(m).transpose();
    }
  }
}

void System::start_turns(const Evaluation& e, VectorXd& angle) const {
  for (int j = 0; j < joint_count(); ++j) {
    if (joints_[j].type() != JointType::revolute) continue;
    angle[j] = joints_[j].coordinate(attachment(e, j, 0), attachment(e, j, 1));
  }
}

// The turn nearest to the angle that the rate predicts.
void System::count_turns(const Evaluation& e, double h, VectorXd& angle) const {
  constexpr double kTurn = 2 * 3.14159265358979323846;
  for (int j = 0; j < joint_count(); ++j) {
    if (joints_[j].type() != JointType::revolute) continue;
    const auto &k1 = attachment(e, j, 0), &k2 = attachment(e, j, 1);
    const double wrapped = joints_[j].coordinate(k1, k2);
    const double predicted = angle[j] + h * joints_[j].coordinate_rate(k1, k2);
    angle[j] = wrapped + kTurn * std::round((predicted - wrapped) / kTurn);
  }
}

std::vector<bool> System::bodies_in_joints() const {
  std::vector<bool> held(body_count(), false);
  for (const auto& incidence : pattern_.incidences) held[incidence.body] = true;
  return held;
}

}  // namespace sigmafmu
