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
Vector6d System::frame_acceleration(const Evaluation& e, int frame, const VectorXd& v, const VectorXd& vdot) const {
  if (frame == body_count_) return Vector6d::Zero();
  if (frame < body_count_) return vdot.segment<6>(kVelocitiesPerBody * frame);
  const auto moving = static_cast<std::size_t>(frame - body_count_ - 1);
  if (moving < moving_frames_.size()) return e.moving_accelerations[moving];
  const auto& [body, f, node] = node_frames_[frame - body_count_];
  const NodeFrameEvaluation& at = node_frame(e, frame);
  const int pose = kVelocitiesPerBody * body, modes = modal_velocity(f), count = this->modes(body);
  Vector6d result = at.J.leftCols<6>().lazyProduct(vdot.segment<6>(pose));
  result += at.L.leftCols<6>().lazyProduct(v.segment<6>(pose));
  result += at.J.rightCols(count).lazyProduct(vdot.segment(modes, count));
  result += at.L.rightCols(count).lazyProduct(v.segment(modes, count));
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

// C_ij += J_i^T C_N,ij J_j,  K_ij += J_i^T (K_N,ij J_j + C_N,ij L_j) + Q_ij.
void System::pull_back_pairs(const Attachment& at, Evaluation& e) const {
  const int n = at.count(), parts = static_cast<int>(at.parts.size());
  const auto add = [&](VectorXd& blocks, int i, int j) {
    const Matrix6Xd& J = node_frame(e, at.frames[i]).J;
    for (int p = 0; p < parts; ++p) {
      if (at.parts[p].frame != i) continue;
      for (int c = 0; c < parts; ++c) {
        if (at.parts[c].frame != j) continue;
        const int rows = pattern_.unknowns[at.parts[p].unknown].size;
        const int columns = pattern_.unknowns[at.parts[c].unknown].size;
        Eigen::Map<MatrixXd>(blocks.data() + at.part_pair[p * parts + c], rows, columns).noalias() +=
            J.middleCols(at.parts[p].first, rows)
                .transpose()
                .lazyProduct(e.work.middleCols(at.parts[c].first, columns));
      }
    }
  };
  for (int i = 0; i < n; ++i) {
    if (at.force[i] < 0) continue;
    for (int j = 0; j < n; ++j) {
      const int block = at.pair[i * n + j];
      if (block < 0) continue;
      const NodeFrameEvaluation& frame = node_frame(e, at.frames[j]);
      const Eigen::Map<const Matrix6d> C_N(e.frame_C.data() + block), K_N(e.frame_K.data() + block);
      auto work = e.work.leftCols(frame.J.cols());
      work.noalias() = C_N.lazyProduct(frame.J);
      add(e.C, i, j);
      work.noalias() = K_N.lazyProduct(frame.J);
      work.noalias() += C_N.lazyProduct(frame.L);
      add(e.K, i, j);
    }
    if (at.frames[i] <= body_count_) continue;
    const auto& [body, f, node] = node_frames_[at.frames[i] - body_count_];
    add_node_stiffness(flexible(f), node, node_frame(e, at.frames[i]), e.frame_forces.segment<6>(6 * i),
                       flexible_blocks(e.K, f));
  }
}

}  // namespace sigmafmu
