#include "multibody/system.h"

#include <algorithm>
#include <cmath>

#include "lie/r3xso3.h"
#include "multibody/bodies/rigid_body_inline.h"

namespace sigmafmu {
namespace {

using Segment6 = Eigen::Map<Vector6d>;

}  // namespace

void System::set_values(const MultibodyDef& d) {
  for (Flexible& flexible : flexible_) flexible.body.set_values(*d.bodies[flexible.index].modal);
  for (AttachedForce& force : forces_) force.element->set_values(d);
  gravity_ = d.gravity;
}

void System::evaluate(const VectorXd& q, const VectorXd& v, const Inputs& u, Evaluation& e) const {
  for (int i = 0; i < body_count(); ++i) {
    const double* qi = q.data() + kPositionsPerBody * i;
    const double* vi = v.data() + kVelocitiesPerBody * i;
    FrameKinematics& k = e.frames[i];
    k.p_WB = Vector3d(qi[0], qi[1], qi[2]);
    k.R_WB = lie::quaternion(qi).toRotationMatrix();
    k.v_WB = Vector3d(vi[0], vi[1], vi[2]);
    k.w_WB_B = Vector3d(vi[3], vi[4], vi[5]);
  }
  for (int f = 0; f < flexible_count(); ++f) {
    const auto& [i, body] = flexible_[f];
    body.evaluate(e.frames[i], q.data() + modal_position(f), v.data() + modal_velocity(f), e.flexible[f]);
    FlexibleBody::Blocks M = flexible_blocks(e.M, f);
    M.frame = e.flexible[f].M;
    M.frame_modal = e.flexible[f].M_modal;
    M.modal_frame = e.flexible[f].M_modal.transpose();
  }
  for (std::size_t k = 1 + moving_frames_.size(); k < node_frames_.size(); ++k) {
    const auto& [body, f, node] = node_frames_[k];
    evaluate_node_frame(flexible(f), e.flexible[f], node, e.frames[body], e.frames[body_count() + k], e.node_frames[k]);
  }
  if (!moving_frames_.empty()) move_frames(u, e);
  if (!armatures_.empty()) add_armature_masses(e);
  for (const auto& [element, at, first, rows] : constraints_) {
    element->evaluate(u, kinematics(e, at), e.phi.data() + first, e.phidot.data() + first,
                      FrameRows(e.B.data() + rows, element->equations()));
  }
  if (!pulled_rows_.empty()) pull_back_rows(e);
}

void System::residual(Evaluation& e, const VectorXd& vdot, const VectorXd& lambda, const Inputs& u, VectorXd& r) const {
  for (const auto& [i, body] : rigid_) {
    Segment6 ri(r.data() + kVelocitiesPerBody * i);
    ri = body.inertial_force(e.frames[i], vdot.segment<6>(kVelocitiesPerBody * i));
    ri.head<3>() -= body.mass * gravity_;
  }
  for (int f = 0; f < flexible_count(); ++f) {
    const auto& [i, body] = flexible_[f];
    const int pose = kVelocitiesPerBody * i, modes = modal_velocity(f);
    r.segment<6>(pose).setZero();
    r.segment(modes, body.modes()).setZero();
    body.add_residual(e.frames[i], e.flexible[f], vdot.data() + pose, vdot.data() + modes, gravity_, r.data() + pose,
                      r.data() + modes);
  }
  for (int k = 0; k < kVelocitiesPerBody * body_count(); ++k) r[k] -= u.u[k];
  add_gradient_times(e, lambda, r);
  for (const auto& [element, at] : forces_) {
    if (!at.at_node) {
      element->add(kinematics(e, at), u, {r.data(), at.force.data()});
      continue;
    }
    e.frame_forces.setZero();
    element->add(kinematics(e, at), u, {e.frame_forces.data(), at.force.data()});
    pull_back_forces(at, e, r);
  }
  if (!armatures_.empty()) add_armature_forces(e, vdot, r);
}

void System::add_gradient_times(const Evaluation& e, const VectorXd& lambda, VectorXd& out) const {
  for (const auto& [c, unknown, offset] : pattern_.incidences) {
    const double* row = e.B.data() + offset;
    const double* multipliers = lambda.data() + lambda_index(c);
    const int m = pattern_.constraint_sizes[c];
    double* x = out.data() + pattern_.unknowns[unknown].velocity;
    if (pattern_.unknowns[unknown].pose) {
      double sum[kVelocitiesPerBody];
      std::copy_n(x, kVelocitiesPerBody, sum);
      for (int i = 0; i < m; ++i, row += kVelocitiesPerBody) {
        for (int k = 0; k < kVelocitiesPerBody; ++k) sum[k] += row[k] * multipliers[i];
      }
      std::copy_n(sum, kVelocitiesPerBody, x);
      continue;
    }
    const int size = pattern_.unknowns[unknown].size;
    for (int i = 0; i < m; ++i, row += size) {
      for (int k = 0; k < size; ++k) x[k] += row[k] * multipliers[i];
    }
  }
}

void System::subtract_rows_times(const VectorXd& rows, const double* v, VectorXd& out) const {
  for (const auto& [c, unknown, offset] : pattern_.incidences) {
    const auto& [body, pose, position, velocity, size] = pattern_.unknowns[unknown];
    const int m = pattern_.constraint_sizes[c];
    auto result = out.segment(lambda_index(c), m);
    if (pose) {
      result.noalias() -= ConstRows(rows.data() + offset, m, 6).lazyProduct(Eigen::Map<const Vector6d>(v + velocity));
    } else {
      result.noalias() -= modal_rows(rows, m, offset, size).lazyProduct(Eigen::Map<const VectorXd>(v + velocity, size));
    }
  }
}

void System::constraint_rates(const Inputs& u, Evaluation& e) const {
  if (!moving_rows_.empty()) e.W.setZero();
  for (const auto& [element, at, first, rows] : constraints_) {
    element->rates(u, kinematics(e, at), FrameRows(e.Z.data() + rows, element->equations()), e.W.data() + first);
  }
  if (!moving_rows_.empty()) add_explicit_rates(e);
  if (!pulled_rows_.empty()) pull_back_rates(e);
}

void System::linearize(const VectorXd& vdot, const VectorXd& lambda, const Inputs& u, Evaluation& e) const {
  e.C.setZero();
  e.K.setZero();
  for (const auto& [i, body] : rigid_) {  // their M is constant
    PairBlock<6, 6>(e.C.data() + pattern_.pairs[i].offset).bottomRightCorner<3, 3>() =
        body.gyroscopic_damping(e.frames[i]);
  }
  for (int f = 0; f < flexible_count(); ++f) {
    const auto& [i, body] = flexible_[f];
    body.linearize(e.frames[i], e.flexible[f], vdot.data() + kVelocitiesPerBody * i, vdot.data() + modal_velocity(f),
                   gravity_, flexible_blocks(e.C, f), flexible_blocks(e.K, f));
  }
  for (const auto& [element, at, first, rows] : constraints_) {
    if (at.at_node) {
      e.frame_K.setZero();
      e.frame_C.setZero();
    }
    element->stiffness(u, kinematics(e, at), lambda.data() + first, pairs(at, e.K, e.frame_K));
    if (!at.at_node) continue;
    const int m = element->equations();
    for (int i = 0; i < at.count(); ++i) {
      e.frame_forces.segment<6>(6 * i).noalias() =
          ConstRows(e.B.data() + rows + 6 * m * i, m, 6).transpose().lazyProduct(lambda.segment(first, m));
    }
    pull_back_pairs(at, e);
  }
  for (const auto& [element, at] : forces_) {
    if (at.at_node) {
      e.frame_K.setZero();
      e.frame_C.setZero();
    }
    element->linearize(kinematics(e, at), u, pairs(at, e.K, e.frame_K), pairs(at, e.C, e.frame_C));
    if (!at.at_node) continue;
    e.frame_forces.setZero();
    element->add(kinematics(e, at), u, {e.frame_forces.data(), at.force.data()});
    pull_back_pairs(at, e);
  }
  if (!armatures_.empty()) linearize_armatures(vdot, e);
}

double System::kinetic_energy(const Evaluation& e) const {
  double energy = 0;
  for (const auto& [i, body] : rigid_) energy += body.kinetic_energy(e.frames[i]);
  for (int f = 0; f < flexible_count(); ++f) {
    energy += flexible(f).kinetic_energy(e.frames[flexible_body(f)], e.flexible[f]);
  }
  for (const auto& [element, force] : armatures_) energy += element->kinetic_energy(force_kinematics(e, force));
  return energy;
}

double System::potential_energy(const Evaluation& e, const Inputs& u) const {
  double energy = 0;
  for (const auto& [i, body] : rigid_) energy -= body.mass * gravity_.dot(e.frames[i].p_WB);
  for (int f = 0; f < flexible_count(); ++f) {
    energy += flexible(f).potential_energy(e.frames[flexible_body(f)], e.flexible[f], gravity_);
  }
  for (const AttachedForce& force : forces_) energy += force.element->energy(kinematics(e, force.at), u);
  return energy;
}

std::vector<bool> System::bodies_in_joints() const {
  std::vector<bool> held(body_count(), false);
  for (const auto& incidence : pattern_.incidences) held[pattern_.unknowns[incidence.unknown].body] = true;
  return held;
}

bool System::axes_agree(const Evaluation& e, int joint) const {
  return joints_[joint]->axes_agree(kinematics(e, constraints_[joint].at));
}

Vector3d System::touching_point(const Evaluation& e, int joint) const {
  const Kinematics k = kinematics(e, constraints_[joint].at);
  return joints_[joint]->disk()->touching_point(k[0], k[1]);
}

double System::tilt_of_disk(const Evaluation& e, int joint) const {
  const RollingDisk* disk = joints_[joint]->disk();
  if (!disk) return 1.0;
  const Kinematics k = kinematics(e, constraints_[joint].at);
  return disk->contact(k[0], k[1]).sine;
}

void System::clear_velocity_rows(Evaluation& e) const {
  for (const auto& [offset, count] : velocity_rows_) e.B.segment(offset, count).setZero();
}

Joint::Reaction System::reaction(const Evaluation& e, int joint, const double* lambda) const {
  const auto& [element, at, first, rows] = constraints_[joint];
  const int m = element->equations();
  return joints_[joint]->reaction(kinematics(e, at), ConstRows(e.B.data() + rows + 6 * m, m, 6), lambda);
}

double System::coordinate_value(const Evaluation& e, int c) const {
  return coordinates_[c].coordinate.value(kinematics(e, coordinates_[c].at));
}

double System::coordinate_rate(const Evaluation& e, int c) const {
  return coordinates_[c].coordinate.rate(kinematics(e, coordinates_[c].at));
}

double System::coordinate_acceleration(const Evaluation& e, int c, const VectorXd& vdot) const {
  const auto& [coordinate, at] = coordinates_[c];
  return coordinate.acceleration(kinematics(e, at), frame_acceleration(e, at.frames[0], vdot),
                                 frame_acceleration(e, at.frames[1], vdot));
}

void System::coordinate_values(const Evaluation& e, VectorXd& coordinates) const {
  for (int c = 0; c < coordinate_count(); ++c) coordinates[c] = coordinate_value(e, c);
}

void System::count_turns(const Evaluation& e, double h, VectorXd& coordinates) const {
  constexpr double kTurn = 6.28318530717958647692;
  for (int c = 0; c < coordinate_count(); ++c) {
    double& x = coordinates[c];
    const double wrapped = coordinate_value(e, c);
    const double predicted = x + h * coordinate_rate(e, c);
    x = wrapped;
    if (coordinate(c).is_angle()) x += kTurn * std::round((predicted - wrapped) / kTurn);
  }
}

Stiffest System::stiffest() const {
  Stiffest sum;
  for (const AttachedForce& force : forces_) {
    const Stiffest one = force.element->stiffest();
    sum.translation += one.translation;
    sum.rotation += one.rotation;
  }
  return sum;
}

Vector3d System::node_position(const Evaluation& e, int body, int node) const {
  const int f = flexible_index_[body];
  return e.frames[body].p_WB + e.frames[body].R_WB * flexible(f).position(node, e.flexible[f]);
}

}  // namespace sigmafmu
