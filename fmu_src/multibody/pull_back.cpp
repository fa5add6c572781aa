// Rows, forces and blocks between frames at nodes, pulled back onto the poses and modes of flexible bodies (frame.h).
#include "multibody/system.h"

namespace sigmafmu {

FlexibleBody::Blocks System::flexible_blocks(VectorXd& blocks, int flexible) const {
  const int modes = flexible_[flexible].body.modes(), first = body_count_ + 3 * flexible;
  const auto at = [&](int p) { return blocks.data() + pattern_.pairs[p].offset; };
  return {PairBlock<6, 6>(at(flexible_[flexible].index)),
          {at(first), 6, modes},
          {at(first + 1), modes, 6},
          {at(first + 2), modes, modes}};
}

// J vdot + L v.
Vector6d System::frame_acceleration(const Evaluation& e, int frame, const VectorXd& vdot) const {
  if (frame == body_count_) return Vector6d::Zero();
  if (frame < body_count_) return vdot.segment<6>(kVelocitiesPerBody * frame);
  const auto moving = static_cast<std::size_t>(frame - body_count_ - 1);
  if (moving < moving_frames_.size()) return e.moving_accelerations[moving];
  const auto& [body, f, node] = node_frames_[frame - body_count_];
  const NodeFrameEvaluation& at = node_frame(e, frame);
  const int pose = kVelocitiesPerBody * body, modes = modal_velocity(f), count = this->modes(body);
  Vector6d v;
  v << e.frames[body].v_WB, e.frames[body].w_WB_B;
  Vector6d result = at.J.leftCols<6>().lazyProduct(vdot.segment<6>(pose));
  result += at.L.leftCols<6>().lazyProduct(v);
  result += at.J.rightCols(count).lazyProduct(vdot.segment(modes, count));
  result += at.L.rightCols(count).lazyProduct(e.flexible[f].zetadot);
  return result;
}

void System::move_frames(const Inputs& u, Evaluation& e) const {
  for (std::size_t i = 0; i < moving_frames_.size(); ++i) {
    e.frames[body_count_ + 1 + i] = moving_frames_[i].kinematics(u);
    e.moving_accelerations[i] = moving_frames_[i].acceleration(u);
  }
}

// W += B_1 v_1' + Z_1 v_1 of what moves by itself.
void System::add_explicit_rates(Evaluation& e) const {
  for (const auto& [moving, first, m, rows] : moving_rows_) {
    const FrameKinematics& k = e.frames[body_count_ + 1 + moving];
    const ConstRows B(e.B.data() + rows, m, 6), Z(e.Z.data() + rows, m, 6);
    Vector6d v;
    v << k.v_WB, k.w_WB_B;
    e.W.segment(first, m) += B.lazyProduct(e.moving_accelerations[moving]);
    e.W.segment(first, m) += Z.lazyProduct(v);
  }
}

System::MovingLoad System::moving_load(const Evaluation& e, int m, const VectorXd& vdot, const VectorXd& lambda,
                                       const Inputs& u) const {
  const FrameKinematics& k = e.frames[body_count_ + 1 + m];
  Vector6d r = Vector6d::Zero();  // of the frame, as if it were a body without mass: what moves it is r
  for (const auto& [moving, first, equations, rows] : moving_rows_) {
    if (moving != m) continue;
    r += ConstRows(e.B.data() + rows, equations, 6).transpose().lazyProduct(lambda.segment(first, equations));
  }
  for (const auto& [moving, force, offset] : moving_forces_) {
    if (moving != m) continue;
    forces_[force].element->add(force_kinematics(e, force), u, {r.data(), offset.data()});
    for (const auto& [armature, index] : armatures_) {
      if (index != force) continue;
      const Attachment& at = forces_[force].at;
      armature->add_inertial_force(kinematics(e, at), accelerations(e, at, vdot), {r.data(), offset.data()});
    }
  }
  return {r.head<3>(), k.R_WB * r.tail<3>(), r.head<3>().dot(k.v_WB) + r.tail<3>().dot(k.w_WB_B)};
}

// B = B_N J.
void System::pull_back_rows(Evaluation& e) const {
  for (const auto& [frame, m, rows, pose, modes, add_pose, add_modes] : pulled_rows_) {
    const Matrix6Xd& J = node_frame(e, frame).J;
    const ConstRows B_N(e.B.data() + rows, m, 6);
    Rows of_pose(e.B.data() + pose, m, 6);
    if (!add_pose) of_pose.setZero();
    of_pose += B_N.lazyProduct(J.leftCols<6>());
    auto of_modes = modal_rows(e.B, m, modes, J.cols() - 6);
    if (!add_modes) of_modes.setZero();
    of_modes += B_N.lazyProduct(J.rightCols(J.cols() - 6));
  }
}

// Z = Z_N J + B_N L.
void System::pull_back_rates(Evaluation& e) const {
  for (const auto& [frame, m, rows, pose, modes, add_pose, add_modes] : pulled_rows_) {
    const auto& [J, L, s, theta, R, A] = node_frame(e, frame);
    const ConstRows B_N(e.B.data() + rows, m, 6), Z_N(e.Z.data() + rows, m, 6);
    const Eigen::Index f = J.cols() - 6;
    Rows of_pose(e.Z.data() + pose, m, 6);
    if (!add_pose) of_pose.setZero();
    of_pose += Z_N.lazyProduct(J.leftCols<6>()) + B_N.lazyProduct(L.leftCols<6>());
    auto Z = modal_rows(e.Z, m, modes, f);
    if (!add_modes) Z.setZero();
    Z += Z_N.lazyProduct(J.rightCols(f));
    Z += B_N.lazyProduct(L.rightCols(f));
  }
}

// r += J^T f_N.
void System::pull_back_forces(const Attachment& at, const Evaluation& e, VectorXd& r) const {
  for (const auto& [i, unknown, first] : at.parts) {
    const Matrix6Xd& J = node_frame(e, at.frames[i]).J;
    const auto f_N = e.frame_forces.segment<6>(6 * i);
    const auto& [body, pose, position, velocity, size] = pattern_.unknowns[unknown];
    r.segment(velocity, size).noalias() += J.middleCols(first, size).transpose().lazyProduct(f_N);
  }
}

void System::add_pulled_back(const Attachment& at, const Evaluation& e, int i, int j, VectorXd& blocks) const {
  const Matrix6Xd& J = node_frame(e, at.frames[i]).J;
  const int parts = static_cast<int>(at.parts.size());
  for (int p = 0; p < parts; ++p) {
    if (at.parts[p].frame != i) continue;
    for (int c = 0; c < parts; ++c) {
      if (at.parts[c].frame != j) continue;
      const int rows = pattern_.unknowns[at.parts[p].unknown].size;
      const int columns = pattern_.unknowns[at.parts[c].unknown].size;
      Eigen::Map<MatrixXd>(blocks.data() + at.part_pair[p * parts + c], rows, columns).noalias() +=
          J.middleCols(at.parts[p].first, rows).transpose().lazyProduct(e.work.middleCols(at.parts[c].first, columns));
    }
  }
}

// M_ij += J_i^T M_N,ij J_j, with M_N in frame_K.
void System::pull_back_masses(const Attachment& at, Evaluation& e) const {
  const int n = at.count();
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const int block = at.pair[i * n + j];
      if (block < 0) continue;
      const Matrix6Xd& J = node_frame(e, at.frames[j]).J;
      const Eigen::Map<const Matrix6d> M_N(e.frame_K.data() + block);
      e.work.leftCols(J.cols()).noalias() = M_N.lazyProduct(J);
      add_pulled_back(at, e, i, j, e.M);
    }
  }
}

// K_ij += J_i^T M_N,ij d(v_N,j')/d(motion),  C_ij += J_i^T M_N,ij d(v_N,j')/dv, with M_N in frame_K.
void System::pull_back_accelerations(const Attachment& at, const VectorXd& vdot, Evaluation& e) const {
  const int n = at.count();
  for (int j = 0; j < n; ++j) {
    if (at.force[j] < 0 || at.frames[j] <= body_count_) continue;
    const auto& [body, f, node] = node_frames_[at.frames[j] - body_count_];
    const int modes = this->modes(body), columns = 6 + modes;
    auto by_motion = e.by_motion.leftCols(columns), by_velocity = e.by_velocity.leftCols(columns);
    node_acceleration_derivatives(flexible(f), e.flexible[f], node, e.frames[body], node_frame(e, at.frames[j]),
                                  vdot.segment<6>(kVelocitiesPerBody * body), vdot.segment(modal_velocity(f), modes),
                                  by_motion, by_velocity);
    for (int i = 0; i < n; ++i) {
      const int block = at.pair[i * n + j];
      if (block < 0) continue;
      const Eigen::Map<const Matrix6d> M_N(e.frame_K.data() + block);
      e.work.leftCols(columns).noalias() = M_N.lazyProduct(by_motion);
      add_pulled_back(at, e, i, j, e.K);
      e.work.leftCols(columns).noalias() = M_N.lazyProduct(by_velocity);
      add_pulled_back(at, e, i, j, e.C);
    }
  }
}

// C_ij += J_i^T C_N,ij J_j,  K_ij += J_i^T (K_N,ij J_j + C_N,ij L_j) + Q_ij.
void System::pull_back_pairs(const Attachment& at, Evaluation& e) const {
  const int n = at.count();
  for (int i = 0; i < n; ++i) {
    if (at.force[i] < 0) continue;
    for (int j = 0; j < n; ++j) {
      const int block = at.pair[i * n + j];
      if (block < 0) continue;
      const NodeFrameEvaluation& frame = node_frame(e, at.frames[j]);
      const Eigen::Map<const Matrix6d> C_N(e.frame_C.data() + block), K_N(e.frame_K.data() + block);
      auto work = e.work.leftCols(frame.J.cols());
      work.noalias() = C_N.lazyProduct(frame.J);
      add_pulled_back(at, e, i, j, e.C);
      work.noalias() = K_N.lazyProduct(frame.J);
      work.noalias() += C_N.lazyProduct(frame.L);
      add_pulled_back(at, e, i, j, e.K);
    }
    if (at.frames[i] <= body_count_) continue;
    const auto& [body, f, node] = node_frames_[at.frames[i] - body_count_];
    add_node_stiffness(flexible(f), node, node_frame(e, at.frames[i]), e.frame_forces.segment<6>(6 * i),
                       flexible_blocks(e.K, f));
  }
}

}  // namespace sigmafmu
