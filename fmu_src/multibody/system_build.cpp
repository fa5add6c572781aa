// What a System is built from: unknowns, frames, elements, and where all their blocks are.
#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "model/dense.h"
#include "multibody/bodies/rigid_body_inline.h"
#include "multibody/constraints/drive.h"
#include "multibody/forces/bearing.h"
#include "multibody/forces/bushing.h"
#include "multibody/forces/cloud_contact.h"
#include "multibody/forces/drag.h"
#include "multibody/forces/follower_force.h"
#include "multibody/forces/joint_armature.h"
#include "multibody/forces/joint_friction.h"
#include "multibody/forces/joint_spring.h"
#include "multibody/forces/joint_stop.h"
#include "multibody/forces/line_spring.h"
#include "multibody/forces/load.h"
#include "multibody/forces/motor.h"
#include "multibody/forces/plane_contact.h"
#include "multibody/forces/rotation_motor.h"
#include "multibody/forces/sphere_contact.h"
#include "multibody/forces/spring_damper.h"
#include "multibody/forces/table_spring.h"
#include "multibody/forces/tendon.h"
#include "multibody/forces/torsion_spring.h"
#include "multibody/system.h"

namespace sigmafmu {
namespace {

// A thin rod gets a moment about its axis: a part 1e-9 of the others, which no result shows, and with which its block
// of the mass matrix is regular.
Matrix3d regular_inertia(const RigidBodyDef& body) {
  constexpr double kNothing = 1e-12, kLeast = 1e-9;
  Matrix3d J = inertia_matrix(body);
  const PrincipalAxes principal = principal_axes(J);
  if (principal.values[0] > kNothing * principal.values[2]) return J;
  const Vector3d axis = principal.axes.col(0);
  return J + (kLeast * principal.values[2]) * (axis * axis.transpose());
}

}  // namespace

class System::Builder {
 public:
  Builder(System& system, const MultibodyDef& definition) : s_(system), definition_(definition) {}

  void build() {
    bodies();
    s_.input_size_ = kVelocitiesPerBody * s_.body_count_;
    for (const MotionDef& motion : definition_.motions) {
      const std::size_t before = definition_.drives.size() + definition_.couplings.size();
      s_.moving_frames_.emplace_back(motion, s_.prescribed_count() + static_cast<int>(before));
    }
    s_.node_frames_.assign(1 + definition_.motions.size(), {kGround, -1, -1});
    for (const JointDef& joint : definition_.joints) this->joint(joint);
    for (const DriveDef& drive : definition_.drives) this->drive(drive);
    for (const CouplingDef& coupling : definition_.couplings) this->coupling(coupling);
    for_each_force_list(definition_, [&](const char*, const auto& forces) {
      for (std::size_t i = 0; i < forces.size(); ++i) force(forces[i], static_cast<int>(i));
    });
    for (const AttachedCoordinate& c : s_.coordinates_) force(std::make_unique<Motor>(c.coordinate), c.at.frames);
  }

 private:
  void bodies() {
    s_.body_count_ = s_.pattern_.bodies = static_cast<int>(definition_.bodies.size());
    for (int i = 0; i < s_.body_count_; ++i) {
      const RigidBodyDef& body = definition_.bodies[i];
      unknown(i, true, kPositionsPerBody, kVelocitiesPerBody);
      s_.flexible_index_.push_back(body.modal ? s_.flexible_count() : -1);
      s_.rigid_index_.push_back(body.modal ? -1 : static_cast<int>(s_.rigid_.size()));
      if (body.modal) {
        s_.flexible_.push_back({i, FlexibleBody(*body.modal)});
      } else {
        s_.rigid_.push_back({i, {body.mass, regular_inertia(body)}});
      }
    }
    for (const Flexible& flexible : s_.flexible_) {
      const int modes = flexible.body.modes();
      unknown(flexible.index, false, modes, modes);
      s_.modal_count_ += modes;
    }
    for (int i = 0; i < s_.body_count_; ++i) pair(i, i);
    for (int f = 0; f < s_.flexible_count(); ++f) {
      const int pose = s_.flexible_[f].index, modes = s_.body_count_ + f;
      pair(pose, modes);
      pair(modes, pose);
      pair(modes, modes);
    }
    armature_blocks();
    s_.pattern_.inertia_pairs = static_cast<int>(s_.pattern_.pairs.size());
    s_.inertia_size_ = s_.blocks_size_;
  }

  // Blocks of M that armatures change; those of the frame of a flexible body are written anew anyhow.
  void armature_blocks() {
    std::set<std::pair<int, int>> known;
    for (const JointArmatureDef& d : definition_.joint_armatures) {
      const JointDef& joint = definition_.joints[d.joint];
      std::vector<int> unknowns;
      for (auto [body, node] : {std::pair(joint.body1, joint.frame1.node), std::pair(joint.body2, joint.frame2.node)}) {
        if (body == kGround) continue;
        unknowns.push_back(body);
        if (node != kFloatingFrame) unknowns.push_back(s_.body_count_ + s_.flexible_index_[body]);
      }
      for (int i : unknowns) {
        for (int j : unknowns) {
          if (!known.emplace(i, j).second) continue;
          const BlockPattern::Pair block = {i, j, pair(i, j)};
          const Unknown& row = s_.pattern_.unknowns[i];
          const bool same_body = row.body == s_.pattern_.unknowns[j].body, modes = i == j && !row.pose;
          if (same_body && !modes && !s_.rigid(row.body)) continue;
          s_.armature_blocks_.push_back({block, i == j ? s_.rigid(row.body) : nullptr,
                                         modes ? &s_.flexible(s_.flexible_index_[row.body]) : nullptr});
        }
      }
    }
  }

  void unknown(int body, bool pose, int positions, int velocities) {
    s_.pattern_.unknowns.push_back({body, pose, positions_, velocities_, velocities});
    positions_ += positions;
    velocities_ += velocities;
  }

  // The offset of a block, which is made if there is none.
  int pair(int i, int j) {
    const auto [found, is_new] = pair_.try_emplace({i, j}, s_.blocks_size_);
    if (is_new) {
      const int size = s_.pattern_.unknowns[i].size * s_.pattern_.unknowns[j].size;
      s_.pattern_.pairs.push_back({i, j, s_.blocks_size_});
      s_.blocks_size_ += size + size % 2;  // aligned for pairs of numbers
    }
    return found->second;
  }

  // The index in Evaluation::frames.
  int frame(int body, int node) {
    if (body == kGround) return s_.body_count_ + 1 + node;  // the ground itself, then what moves
    if (node == kFloatingFrame) return body;
    const auto [found, is_new] = node_.try_emplace({body, node}, s_.body_count_ + s_.node_frames_.size());
    if (is_new) s_.node_frames_.push_back({body, s_.flexible_index_[body], node});
    return static_cast<int>(found->second);
  }

  int body(int frame) const { return frame < s_.body_count_ ? frame : s_.node_frames_[frame - s_.body_count_].body; }

  // `coupled`: blocks of C and K between different frames.
  Attachment attach(std::vector<int> frames, bool coupled) {
    Attachment at;
    at.frames = std::move(frames);
    const int n = at.count();
    for (int i = 0; i < n; ++i) {
      const int frame = at.frames[i], body = this->body(frame);
      if (body == kGround) continue;
      at.parts.push_back({i, body, 0});
      if (frame <= s_.body_count_) continue;
      at.parts.push_back({i, s_.body_count_ + s_.flexible_index_[body], kVelocitiesPerBody});
      at.at_node = true;
    }
    at.force.assign(n, -1);
    at.pair.assign(n * n, -1);
    for (const auto& row : at.parts) {
      if (row.first == 0) at.force[row.frame] = at.at_node ? 6 * row.frame : s_.pattern_.unknowns[row.unknown].velocity;
      for (const auto& column : at.parts) {
        int offset = -1;
        if (coupled || row.frame == column.frame) offset = pair(row.unknown, column.unknown);
        at.part_pair.push_back(offset);
        if (row.first > 0 || column.first > 0) continue;
        const int in_element = row.frame * n + column.frame;
        at.pair[in_element] = offset < 0 ? -1 : at.at_node ? 36 * in_element : offset;
      }
    }
    return at;
  }

  int constraint(std::unique_ptr<Constraint> element, const std::vector<int>& frames) {
    const int c = s_.constraint_count(), m = element->equations();
    Attachment at = m > 0 ? attach(frames, element->couples_frames()) : Attachment{frames, false, {}, {}, {}, {}};
    const int rows = s_.rows_size_;
    s_.rows_size_ += 6 * m * at.count();
    std::map<int, int> offset;  // of the rows for each unknown
    const auto rows_for = [&](int unknown) {
      const auto [found, is_new] = offset.try_emplace(unknown, s_.rows_size_);
      if (is_new) {
        s_.pattern_.incidences.push_back({c, unknown, s_.rows_size_});
        s_.rows_size_ += m * s_.pattern_.unknowns[unknown].size;
      }
      return std::pair(found->second, !is_new);
    };
    for (const auto& part : at.parts) {
      if (part.first > 0) continue;
      const int frame = at.frames[part.frame], of_frame = rows + 6 * m * part.frame;
      if (frame < s_.body_count_ && offset.emplace(part.unknown, of_frame).second) {
        s_.pattern_.incidences.push_back({c, part.unknown, of_frame});
        continue;
      }
      const auto [pose, add_pose] = rows_for(part.unknown);
      PulledRows pulled{frame, m, of_frame, pose, 0, add_pose, false};
      if (frame > s_.body_count_) {
        std::tie(pulled.modes, pulled.add_modes) = rows_for(s_.body_count_ + s_.flexible_index_[part.unknown]);
      }
      s_.pulled_rows_.push_back(pulled);
    }
    for (int i = 0; i < at.count(); ++i) {
      const int moving = at.frames[i] - s_.body_count_ - 1;
      if (moving < 0 || moving >= static_cast<int>(s_.moving_frames_.size())) continue;
      s_.moving_rows_.push_back({moving, s_.constraint_size_, m, rows + 6 * m * i});
    }
    s_.pattern_.constraint_sizes.push_back(m);
    velocity_equations(c, m, element->velocity_equations());
    s_.constraints_.push_back({std::move(element), std::move(at), s_.constraint_size_, rows});
    s_.constraint_size_ += m;
    return c;
  }

  // `count`: the last ones of constraint c, which has `equations`.
  void velocity_equations(int c, int equations, int count) {
    s_.pattern_.velocity_equations.push_back(count);
    for (int i = equations - count; i < equations; ++i) s_.velocity_equations_.push_back(s_.constraint_size_ + i);
    if (count == 0) return;
    for (const auto& [constraint, unknown, offset] : s_.pattern_.incidences) {
      const int size = s_.pattern_.unknowns[unknown].size;
      if (constraint == c) s_.velocity_rows_.push_back({offset + (equations - count) * size, count * size});
    }
  }

  void force(std::unique_ptr<Force> element, const std::vector<int>& frames) {
    element->set_first_input(s_.input_size_);
    s_.input_size_ += element->input_count();
    for (int m = 0; m < static_cast<int>(s_.moving_frames_.size()); ++m) {
      std::vector<int> offset;
      offset.reserve(frames.size());
      for (int frame : frames) offset.push_back(frame == s_.body_count_ + 1 + m ? 0 : -1);
      if (*std::max_element(offset.begin(), offset.end()) < 0) continue;
      s_.moving_forces_.push_back({m, s_.force_count(), std::move(offset)});
    }
    s_.forces_.push_back({std::move(element), attach(frames, true)});
  }

  void joint(const JointDef& d) {
    const double length = d.type == JointType::distance ? rod_length(definition_, d) : 0.0;
    auto element = std::make_unique<Joint>(d, length);
    const std::vector<int> frames = {frame(d.body1, d.frame1.node), frame(d.body2, d.frame2.node)};
    s_.joints_.push_back(element.get());
    s_.coordinate_index_.push_back(s_.coordinate_count());
    for (const JointCoordinate& coordinate : element->coordinates()) {
      s_.coordinates_.push_back({coordinate, {frames, false, {}, {}, {}, {}}});
    }
    constraint(std::move(element), frames);
  }

  void drive(const DriveDef& d) {
    const AttachedCoordinate& coordinate = s_.coordinates_[s_.coordinate_index_[d.joint] + d.coordinate];
    CubicTable table;
    if (d.table) table = CubicTable(d.table->times, d.table->values, static_cast<int>(d.motion));
    constraint(std::make_unique<Drive>(coordinate.coordinate, s_.drive_count_++, std::move(table)),
               coordinate.at.frames);
  }

  void coupling(const CouplingDef& d) {
    std::vector<Coupling::Term> terms;
    std::vector<int> frames;
    for (const CouplingDef::Term& term : d.terms) {
      const int c = s_.coordinate_index_[term.joint] + term.coordinate;
      terms.push_back({s_.coordinates_[c].coordinate, c, term.polynomial});
      frames.insert(frames.end(), s_.coordinates_[c].at.frames.begin(), s_.coordinates_[c].at.frames.end());
    }
    auto element = std::make_unique<Coupling>(std::move(terms), s_.drive_count_ + s_.coupling_count());
    s_.couplings_.push_back(element.get());
    constraint(std::move(element), frames);
  }

  // Where an element attaches to.
  template <typename Def>
  std::vector<int> points_of(const Def& d) {
    std::vector<int> frames;
    d.points([&](int body, const Vector3d&, int node) { frames.push_back(frame(body, node)); });
    return frames;
  }

  // One for each type of force.
  void force(const LoadDef& d, int index) { force(std::make_unique<Load>(index), {frame(d.body, kFloatingFrame)}); }
  void force(const SpringDamperDef& d, int index) { force(std::make_unique<SpringDamper>(d, index), points_of(d)); }
  void force(const LineSpringDef& d, int index) { force(std::make_unique<LineSpring>(d, index), points_of(d)); }
  void force(const TableSpringDef& d, int) { force(std::make_unique<TableSpring>(d), points_of(d)); }
  void force(const TorsionSpringDef& d, int index) { force(std::make_unique<TorsionSpring>(d, index), points_of(d)); }
  void force(const BushingDef& d, int index) { force(std::make_unique<Bushing>(d, index), points_of(d)); }
  void force(const BearingDef& d, int index) { force(std::make_unique<Bearing>(d, index), points_of(d)); }
  void force(const DragDef& d, int index) { force(std::make_unique<Drag>(d, index), points_of(d)); }
  void force(const CloudContactDef& d, int index) {
    force(std::make_unique<CloudContact>(d, index), {frame(d.body1, d.frame1.node), frame(d.body2, d.node2)});
  }
  void force(const FollowerForceDef& d, int index) { force(std::make_unique<FollowerForce>(d, index), points_of(d)); }
  void force(const PlaneContactDef& d, int index) { force(std::make_unique<PlaneContact>(d, index), points_of(d)); }
  void force(const SphereContactDef& d, int index) { force(std::make_unique<SphereContact>(d, index), points_of(d)); }
  void force(const TendonDef& d, int index) {
    std::vector<Tendon::Term> terms;
    std::vector<int> frames;
    for (const TendonDef::Term& term : d.terms) {
      const int c = s_.coordinate_index_[term.joint] + term.coordinate;
      const AttachedCoordinate& coordinate = s_.coordinates_[c];
      terms.push_back({coordinate.coordinate, c, term.coefficient});
      frames.insert(frames.end(), coordinate.at.frames.begin(), coordinate.at.frames.end());
    }
    force(std::make_unique<Tendon>(std::move(terms), index), frames);
  }
  void force(const JointSpringDef& d, int index) { on_coordinate<JointSpring>(d, index); }
  void force(const JointFrictionDef& d, int index) { on_coordinate<JointFriction>(d, index); }
  void force(const JointStopDef& d, int index) { on_coordinate<JointStop>(d, index); }
  void force(const JointArmatureDef& d, int index) {
    const auto& [coordinate, at] = s_.coordinates_[s_.coordinate_index_[d.joint] + d.coordinate];
    auto element = std::make_unique<JointArmature>(coordinate, index);
    s_.armatures_.push_back({element.get(), s_.force_count()});
    force(std::move(element), at.frames);
  }
  void force(const RotationMotorDef& d, int) {
    const JointDef& joint = definition_.joints[d.joint];
    force(std::make_unique<RotationMotor>(joint.frame1, joint.frame2),
          {frame(joint.body1, joint.frame1.node), frame(joint.body2, joint.frame2.node)});
  }

  template <typename Element, typename Def>
  void on_coordinate(const Def& d, int index) {
    const int c = s_.coordinate_index_[d.joint] + d.coordinate;
    const auto& [coordinate, at] = s_.coordinates_[c];
    force(std::make_unique<Element>(coordinate, c, index), at.frames);
  }

  System& s_;
  const MultibodyDef& definition_;
  std::map<std::pair<int, int>, int> pair_;          // unknowns -> offset
  std::map<std::pair<int, int>, std::size_t> node_;  // body, node -> frame
  int positions_ = 0, velocities_ = 0;
};

System::System(const MultibodyDef& definition, Compliance compliance)
    : size_(sigmafmu::size(definition)), compliance_(std::move(compliance)) {
  Builder(*this, definition).build();
  set_values(definition);
}

Evaluation System::make_evaluation() const {
  Evaluation e;
  e.frames.resize(body_count_ + node_frames_.size());
  for (VectorXd* x : {&e.phi, &e.phidot, &e.W}) x->setZero(constraint_size_);
  for (VectorXd* x : {&e.B, &e.Z}) x->setZero(rows_size_);
  for (VectorXd* x : {&e.C, &e.K}) x->setZero(blocks_size_);
  e.M.setZero(inertia_size_);
  e.moving_accelerations.assign(moving_frames_.size(), Vector6d::Zero());
  for (const auto& [i, body] : rigid_) {  // constant
    PairBlock<6, 6> M(e.M.data() + pattern_.pairs[i].offset);
    M.diagonal().head<3>().setConstant(body.mass);
    M.bottomRightCorner<3, 3>() = body.J;
  }
  for (int f = 0; f < flexible_count(); ++f) {
    e.flexible.push_back(flexible(f).make_evaluation());
    flexible_blocks(e.M, f).modal = flexible(f).modal_mass();  // the only block that is constant
  }
  int most_modes = 0;
  for (const NodeFrame& frame : node_frames_) {
    const int modes = frame.flexible < 0 ? 0 : flexible_[frame.flexible].body.modes();
    e.node_frames.push_back(make_node_frame_evaluation(modes));
    most_modes = std::max(most_modes, modes);
  }
  int most_frames = 0;
  const auto count = [&](const Attachment& at) { most_frames = std::max(most_frames, at.at_node ? at.count() : 0); };
  for (const auto& constraint : constraints_) count(constraint.at);
  for (const auto& force : forces_) count(force.at);
  e.frame_forces.setZero(6 * most_frames);
  for (VectorXd* x : {&e.frame_C, &e.frame_K}) x->setZero(36 * most_frames * most_frames);
  e.work.setZero(6, 6 + most_modes);
  if (!armatures_.empty()) {
    for (Matrix6Xd* x : {&e.by_motion, &e.by_velocity}) x->setZero(6, 6 + most_modes);
  }
  return e;
}

}  // namespace sigmafmu
