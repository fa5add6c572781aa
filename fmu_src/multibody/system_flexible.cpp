// What flexible bodies, and elements at their nodes, add to a System.
#include <algorithm>

#include "multibody/system.h"

namespace sigmafmu {
namespace {

PairBlocks all(Matrix6d (&m)[2][2]) { return {{{&m[0][0], &m[0][1]}, {&m[1][0], &m[1][1]}}}; }

}  // namespace

struct System::NodeElement {
  Vector6d force[2] = {Vector6d::Zero(), Vector6d::Zero()};
  Matrix6d K[2][2] = {{Matrix6d::Zero(), Matrix6d::Zero()}, {Matrix6d::Zero(), Matrix6d::Zero()}};
  Matrix6d C[2][2] = {{Matrix6d::Zero(), Matrix6d::Zero()}, {Matrix6d::Zero(), Matrix6d::Zero()}};
};

void System::evaluate_flexible(const VectorXd& q, const VectorXd& v, Evaluation& e) const {
  for (int f = 0; f < flexible_count(); ++f) {
    FlexibleEvaluation& flexible = e.flexible[f];
    flexible_[f].evaluate(e.bodies[flexible_bodies_[f]], q.data() + modal_position(f), v.data() + modal_velocity(f),
                          flexible);
    e.modal_M[3 * f] = flexible.M_modal;
    e.modal_M[3 * f + 1] = flexible.M_modal.transpose();
  }
  for (std::size_t k = 1; k < node_frames_.size(); ++k) {
    const auto& [body, f, node] = node_frames_[k];
    evaluate_node_frame(flexible_[f], e.flexible[f], node, e.bodies[body], e.bodies[body_count() + k],
                        e.node_frames[k]);
  }
}

// B = B_N J.
void System::evaluate_node_gradients(Evaluation& e) const {
  for (std::size_t k = 0; k < node_joints_.size(); ++k) {
    const auto& [j, incidence] = node_joints_[k];
    for (int i = 0; i < 2; ++i) {
      JointRows &B = e.joints[j].B[i], &B_N = e.node_gradients[k][i];
      B_N = B;
      if (incidence[i] < 0) continue;
      const Matrix6Xd& J = e.node_frames[joint_ends_[j].side[i].node_frame].J;
      B = B_N.lazyProduct(J.leftCols<6>());
      e.modal_joints[incidence[i]].B = B_N.lazyProduct(J.rightCols(J.cols() - 6));
    }
  }
}

void System::add_flexible_residual(const Evaluation& e, const VectorXd& vdot, const VectorXd& lambda, const VectorXd& u,
                                   VectorXd& r) const {
  r.tail(modal_count_).setZero();
  for (int f = 0; f < flexible_count(); ++f) {
    const int i = flexible_bodies_[f], modal = modal_velocity(f);
    flexible_[f].add_residual(e.bodies[i], e.flexible[f], vdot.data() + 6 * i, vdot.data() + modal, gravity_,
                              r.data() + 6 * i, r.data() + modal);
  }
  for (std::size_t k = 0; k < pattern_.modal_incidences.size(); ++k) {
    const auto& [j, f, side] = pattern_.modal_incidences[k];
    r.segment(modal_velocity(f), flexible_[f].modes()).noalias() +=
        e.modal_joints[k].B.transpose().lazyProduct(lambda.segment(lambda_index_[j], joints_[j].equations()));
  }
  for (const auto& [j, incidence] : node_joints_) {
    if (!joints_[j].has_motor() || u[motor_index_[j]] == 0.0) continue;
    Vector6d force[2] = {Vector6d::Zero(), Vector6d::Zero()};
    joints_[j].add_motor(attachment(e, j, 0), attachment(e, j, 1), u[motor_index_[j]], force[0].data(),
                         force[1].data());
    for (int i = 0; i < 2; ++i) add_end_force(e, joint_ends_[j].side[i], force[i], r);
  }
  for (int s : node_springs_) {
    const SpringDamperEvaluation& se = e.spring_dampers[s];
    const Vector3d force = spring_dampers_[s].force(se) + u.segment<3>(actuator_index_[s]);
    for (int i = 0; i < 2; ++i) {
      add_end_force(e, spring_ends_[s].side[i], -(se.B[i].topRows<3>().transpose() * force), r);
    }
  }
}

// r += J^T f_N.
void System::add_end_force(const Evaluation& e, const End& end, const Vector6d& f_N, VectorXd& r) const {
  if (end.body == kGround) return;
  const Matrix6Xd& J = e.node_frames[end.node_frame].J;
  r.segment<6>(6 * end.body).noalias() += J.leftCols<6>().transpose() * f_N;
  if (end.node_frame == 0) return;
  const int f = flexible_index_[end.body], modes = flexible_[f].modes();
  r.segment(modal_velocity(f), modes).noalias() += J.rightCols(modes).transpose().lazyProduct(f_N);
}

// Z = Z_N J + B_N L.
void System::evaluate_node_rates(Evaluation& e) const {
  for (std::size_t k = 0; k < node_joints_.size(); ++k) {
    const auto& [j, incidence] = node_joints_[k];
    for (int i = 0; i < 2; ++i) {
      if (incidence[i] < 0) continue;
      const NodeFrameEvaluation& node = e.node_frames[joint_ends_[j].side[i].node_frame];
      const Eigen::Index modes = node.J.cols() - 6;
      const JointRows& B_N = e.node_gradients[k][i];
      const JointRows Z_N = e.joints[j].Z[i];
      MatrixXd& modal_Z = e.modal_joints[incidence[i]].Z;
      e.joints[j].Z[i] = Z_N.lazyProduct(node.J.leftCols<6>()) + B_N.lazyProduct(node.L.leftCols<6>());
      modal_Z.noalias() = Z_N.lazyProduct(node.J.rightCols(modes));
      modal_Z.noalias() += B_N.lazyProduct(node.L.rightCols(modes));
    }
  }
}

void System::linearize_at_nodes(const VectorXd& lambda, const VectorXd& u, Evaluation& e) const {
  for (std::size_t p = 0; p < e.modal_C.size(); ++p) {
    e.modal_C[p].setZero();
    e.modal_K[p].setZero();
  }
  for (std::size_t k = 0; k < node_joints_.size(); ++k) {
    const int j = node_joints_[k].joint;
    const Joint& joint = joints_[j];
    const auto &k1 = attachment(e, j, 0), &k2 = attachment(e, j, 1);
    const double motor = joint.has_motor() ? u[motor_index_[j]] : 0.0;
    NodeElement element;
    joint.stiffness(k1, k2, lambda.data() + lambda_index_[j], motor, all(element.K));
    for (int i = 0; i < 2; ++i) {
      element.force[i].noalias() =
          e.node_gradients[k][i].transpose().lazyProduct(lambda.segment(lambda_index_[j], joint.equations()));
    }
    joint.add_motor(k1, k2, motor, element.force[0].data(), element.force[1].data());
    add_element(joint_ends_[j], element, e);
  }
  for (int s : node_springs_) {
    const SpringDamper& spring = spring_dampers_[s];
    const Ends& ends = spring_ends_[s];
    SpringDamperEvaluation& se = e.spring_dampers[s];
    const Vector3d force = spring.force(se) + u.segment<3>(actuator_index_[s]);
    NodeElement element;
    spring.linearize(e.bodies[ends.side[0].frame], e.bodies[ends.side[1].frame], force, se, all(element.K),
                     all(element.C));
    for (int i = 0; i < 2; ++i) element.force[i].noalias() = -(se.B[i].topRows<3>().transpose() * force);
    add_element(ends, element, e);
  }
}

void System::linearize(const VectorXd& vdot, const VectorXd& lambda, const VectorXd& u, Evaluation& e) const {
  linearize(lambda, u, e);
  for (int f = 0; f < flexible_count(); ++f) {
    const int i = flexible_bodies_[f];
    flexible_[f].linearize(e.bodies[i], e.flexible[f], vdot.data() + 6 * i, vdot.data() + modal_velocity(f), gravity_,
                           flexible_blocks(e.C, e.modal_C, f), flexible_blocks(e.K, e.modal_K, f));
  }
}

// C_ij += J_i^T C_N,ij J_j,  K_ij += J_i^T (K_N,ij J_j + C_N,ij L_j) + Q_ij.
void System::add_element(const Ends& ends, const NodeElement& element, Evaluation& e) const {
  struct Part {  // columns of J that belong to a node of the equations
    int node, first, size;
  };
  const auto part = [&](const End& end, int p) -> Part {
    if (p == 0) return {end.body, 0, 6};
    const int f = flexible_index_[end.body];
    return {pattern_.modal_node(f), 6, flexible_[f].modes()};
  };
  const auto add = [&](std::vector<Matrix6d>& frames, std::vector<MatrixXd>& modal, int i, int j) {
    const NodeFrameEvaluation& node = e.node_frames[ends.side[i].node_frame];
    for (int p = 0; p < (ends.side[i].node_frame > 0 ? 2 : 1); ++p) {
      for (int r = 0; r < (ends.side[j].node_frame > 0 ? 2 : 1); ++r) {
        const Part row = part(ends.side[i], p), column = part(ends.side[j], r);
        const int index = pair_table_[row.node * nodes_ + column.node];
        if (index < 0) continue;  // a joint that does not couple its bodies
        double* block = std::max(row.node, column.node) < body_count() ? frames[index].data() : modal[index].data();
        Eigen::Map<MatrixXd>(block, row.size, column.size).noalias() +=
            node.J.middleCols(row.first, row.size)
                .transpose()
                .lazyProduct(e.work.middleCols(column.first, column.size));
      }
    }
  };
  for (int i = 0; i < 2; ++i) {
    if (ends.side[i].body == kGround) continue;
    for (int j = 0; j < 2; ++j) {
      if (ends.side[j].body == kGround) continue;
      const NodeFrameEvaluation& node = e.node_frames[ends.side[j].node_frame];
      auto work = e.work.leftCols(node.J.cols());
      work.noalias() = element.C[i][j].lazyProduct(node.J);
      add(e.C, e.modal_C, i, j);
      work.noalias() = element.K[i][j].lazyProduct(node.J);
      work.noalias() += element.C[i][j].lazyProduct(node.L);
      add(e.K, e.modal_K, i, j);
    }
    if (ends.side[i].node_frame == 0) continue;
    const auto& [body, f, node] = node_frames_[ends.side[i].node_frame];
    add_node_stiffness(flexible_[f], node, e.node_frames[ends.side[i].node_frame], element.force[i],
                       flexible_blocks(e.K, e.modal_K, f));
  }
}

Vector3d System::node_position(const Evaluation& e, int body, int node) const {
  const int f = flexible_index_[body];
  return e.bodies[body].p_WB + e.bodies[body].R_WB * flexible_[f].position(node, e.flexible[f]);
}

FlexibleBody::Blocks System::flexible_blocks(std::vector<Matrix6d>& frames, std::vector<MatrixXd>& modal,
                                             int flexible) const {
  MatrixXd* first = &modal[3 * flexible];
  return {frames[flexible_bodies_[flexible]], first[0], first[1], first[2]};
}

}  // namespace sigmafmu
