#include "multibody/system.h"

#include <algorithm>

namespace sigmafmu {
namespace {

using Segment6 = Eigen::Map<Vector6d>;

}  // namespace

System::System(const MultibodyDef& d) {
  const int n = static_cast<int>(d.bodies.size());
  pattern_.body_sizes.assign(n, kVelocitiesPerBody);
  pair_table_.assign(n * n, -1);
  auto add_pair = [&](int i, int j) {
    int& index = pair_table_[i * n + j];
    if (index >= 0) return;
    index = static_cast<int>(pattern_.body_pairs.size());
    pattern_.body_pairs.emplace_back(i, j);
  };
  for (int i = 0; i < n; ++i) add_pair(i, i);
  auto couple = [&](int i, int j) {
    if (i == kGround || j == kGround || i == j) return;
    add_pair(i, j);
    add_pair(j, i);
  };

  input_size_ = 6 * n;
  for (const JointDef& definition : d.joints) {
    const Joint joint(definition);
    const int j = static_cast<int>(joints_.size());
    pattern_.joint_sizes.push_back(joint.equations());
    if (joint.body1() != kGround) pattern_.incidences.push_back({j, joint.body1(), 0});
    if (joint.body2() != kGround) pattern_.incidences.push_back({j, joint.body2(), 1});
    if (joint.couples_rotations()) couple(joint.body1(), joint.body2());
    lambda_index_.push_back(constraint_size_);
    constraint_size_ += joint.equations();
    motor_index_.push_back(joint.has_motor() ? input_size_++ : -1);
    joints_.push_back(joint);
  }
  for (const SpringDamperDef& s : d.spring_dampers) {
    spring_dampers_.push_back({s.body1, s.body2, {s.point1, s.point2}, s.stiffness, s.damping});
    couple(s.body1, s.body2);
    actuator_index_.push_back(input_size_);
    input_size_ += 3;
  }
  bodies_.resize(n);
  loads_.resize(d.loads.size());
  set_values(d);
}

void System::set_values(const MultibodyDef& d) {
  for (int i = 0; i < body_count(); ++i) bodies_[i] = {d.bodies[i].mass, inertia_matrix(d.bodies[i])};
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
  e.bodies.resize(body_count() + 1);
  for (const Joint& joint : joints_) e.joints.push_back(joint.make_evaluation());
  e.spring_dampers.resize(spring_dampers_.size());
  e.C.resize(pattern_.body_pairs.size());
  e.K.resize(pattern_.body_pairs.size());
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
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const Joint& joint = joints_[j];
    joint.constraint(kinematics(e, joint.body1()), kinematics(e, joint.body2()), e.joints[j]);
  }
  for (std::size_t s = 0; s < spring_dampers_.size(); ++s) {
    const SpringDamper& spring = spring_dampers_[s];
    spring.evaluate(kinematics(e, spring.body1), kinematics(e, spring.body2), e.spring_dampers[s]);
  }
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
    if (joint.has_motor() && u[motor_index_[j]] != 0.0) {
      joint.add_motor(kinematics(e, joint.body1()), kinematics(e, joint.body2()), u[motor_index_[j]],
                      rows_of(joint.body1()), rows_of(joint.body2()));
    }
  }
  for (std::size_t s = 0; s < spring_dampers_.size(); ++s) {
    const SpringDamper& spring = spring_dampers_[s];
    const SpringDamperEvaluation& se = e.spring_dampers[s];
    const Vector3d force = spring.force(se) + u.segment<3>(actuator_index_[s]);
    for (int side = 0; side < 2; ++side) {
      double* ri = rows_of(side == 0 ? spring.body1 : spring.body2);
      if (ri) Segment6(ri).noalias() -= se.B[side].topRows<3>().transpose() * force;
    }
  }
}

void System::constraint_rates(Evaluation& e) const {
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const Joint& joint = joints_[j];
    joint.rate(kinematics(e, joint.body1()), kinematics(e, joint.body2()), e.joints[j]);
  }
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
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const Joint& joint = joints_[j];
    joint.stiffness(kinematics(e, joint.body1()), kinematics(e, joint.body2()), lambda.data() + lambda_index_[j],
                    joint.has_motor() ? u[motor_index_[j]] : 0.0, blocks(e.K, joint.body1(), joint.body2()));
  }
  for (std::size_t s = 0; s < spring_dampers_.size(); ++s) {
    const SpringDamper& spring = spring_dampers_[s];
    SpringDamperEvaluation& se = e.spring_dampers[s];
    const Vector3d force = spring.force(se) + u.segment<3>(actuator_index_[s]);
    spring.linearize(kinematics(e, spring.body1), kinematics(e, spring.body2), force, se,
                     blocks(e.K, spring.body1, spring.body2), blocks(e.C, spring.body1, spring.body2));
  }
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
  return energy;
}

double System::potential_energy(const Evaluation& e) const {
  double energy = 0;
  for (int i = 0; i < body_count(); ++i) energy -= bodies_[i].mass * gravity_.dot(e.bodies[i].p_WB);
  for (std::size_t s = 0; s < spring_dampers_.size(); ++s) {
    energy += spring_dampers_[s].energy(e.spring_dampers[s]);
  }
  return energy;
}

int System::pair_index(int i, int j) const {
  return i == kGround || j == kGround ? -1 : pair_table_[i * body_count() + j];
}

PairBlocks System::blocks(std::vector<Matrix6d>& matrices, int body1, int body2) const {
  const int body[2] = {body1, body2};
  PairBlocks result;
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      const int index = pair_index(body[i], body[j]);
      result.block[i][j] = index < 0 ? nullptr : &matrices[index];
    }
  }
  return result;
}

}  // namespace sigmafmu
