#include "solve/start/dependent_equations.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "model/dense.h"
#include "solve/start/assembly.h"
#include "solve/start/row_space.h"
#include "solve/start/scaled_equations.h"

namespace sigmafmu {
namespace {

// Of what an equation says beyond the others, relative to all it says: rounding leaves 1e-15, a dependence that holds
// in one plane alone and is left by the rounding of positions 1e-9.
constexpr double kDependent = 1e-8;
constexpr double kTakesPart = 1e-5;  // smallest weight of an equation in a dependence

// Puts the joints of one dependence into one group, which is called by its first joint.
class Groups {
 public:
  explicit Groups(int joints) : parent_(joints) { std::iota(parent_.begin(), parent_.end(), 0); }
  int of(int joint) {
    while (parent_[joint] != joint) joint = parent_[joint] = parent_[parent_[joint]];
    return joint;
  }
  void tie(int a, int b) {
    a = of(a), b = of(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<int> parent_;
};

int independent_equations(const RestPlace& at, const JointPart& part) {
  return RowSpace(scaled_equations(at, part).B_transposed, kDependent).rank();
}

Freedom freedom_of(const RestPlace& at, const JointPart& part) {
  const System& system = at.system;
  const int joints = static_cast<int>(part.joints.size());
  std::vector<int> joint_of_row;
  for (int k = 0; k < joints; ++k) {
    joint_of_row.insert(joint_of_row.end(), system.constraint(part.joints[k]).equations(), k);
  }
  const ScaledEquations scaled = scaled_equations(at, part);
  const RowSpace rows(scaled.B_transposed, kDependent);
  Freedom result;
  result.velocities = static_cast<int>(scaled.B_transposed.rows());
  result.equations = static_cast<int>(scaled.B_transposed.cols());
  result.independent = rows.rank();
  result.independent_margin = result.margin = std::min(result.margin, rows.smallest_part());
  if (rows.rank() == result.equations) return result;

  std::vector<int> dependents(joints, 0);
  Groups groups(joints);
  for (const RowSpace::Dependence& dependence : rows.dependences()) {
    const int joint = joint_of_row[dependence.row];
    ++dependents[joint];
    result.margin = std::min(result.margin, dependence.part);
    for (const auto& [row, weight] : dependence.weights) {
      if (std::abs(weight) > kTakesPart) groups.tie(joint, joint_of_row[row]);
    }
  }
  std::vector<Freedom::Group> of_first(joints);
  for (int k = 0; k < joints; ++k) {
    Freedom::Group& g = of_first[groups.of(k)];
    g.joints.push_back(part.joints[k]);
    g.equations += system.constraint(part.joints[k]).equations();
    g.dependent += dependents[k];
  }
  for (Freedom::Group& g : of_first) {
    if (g.dependent == 0) continue;
    std::sort(g.joints.begin(), g.joints.end());
    result.groups.push_back(std::move(g));
  }
  return result;
}

// Parts whose equations are independent of those of the others, in an order in which each places its bodies against
// those of parts before it.
//
// Where a joint alone holds a body, whatever the other equations ask for can be had: it makes a part with this body,
// unless its own equations depend on each other, and the rest goes on without both. What remains are the loops, one
// part for all that are connected other than by the ground; bodies that nothing holds are in none.
std::vector<JointPart> parts_of(const RestPlace& at) {
  const System& system = at.system;
  std::vector<std::vector<int>> joints_at(system.body_count()), bodies_of(system.constraint_count());
  for (const auto& i : system.pattern().incidences) {
    if (!system.pattern().unknowns[i.unknown].pose) continue;
    joints_at[i.unknown].push_back(i.constraint);
    bodies_of[i.constraint].push_back(i.unknown);
  }
  std::vector<std::size_t> left(system.body_count());  // joints at each body
  std::vector<char> done(system.constraint_count(), 0);
  std::vector<int> held_by_one;
  for (int i = system.body_count() - 1; i >= 0; --i) {
    left[i] = joints_at[i].size();
    if (left[i] == 1) held_by_one.push_back(i);
  }
  std::vector<JointPart> parts;
  while (!held_by_one.empty()) {
    const int body = held_by_one.back();
    held_by_one.pop_back();
    if (left[body] != 1) continue;
    const int joint =
        *std::find_if(joints_at[body].begin(), joints_at[body].end(), [&](int j) { return done[j] == 0; });
    const JointPart part{{joint}, {body}};
    if (!freedom_of(at, part).groups.empty()) continue;
    parts.push_back(part);
    done[joint] = 1;
    for (int i : bodies_of[joint]) {
      if (--left[i] == 1) held_by_one.push_back(i);
    }
  }
  for (int first = 0; first < system.constraint_count(); ++first) {
    if (done[first] != 0 || bodies_of[first].empty()) continue;  // a free joint has no equation
    JointPart part{{first}, {}};
    done[first] = 1;
    for (std::size_t k = 0; k < part.joints.size(); ++k) {
      for (int body : bodies_of[part.joints[k]]) {
        if (left[body] == 0) continue;
        left[body] = 0;
        part.bodies.push_back(body);
        for (int joint : joints_at[body]) {
          if (done[joint] == 0) part.joints.push_back(joint);
          done[joint] = 1;
        }
      }
    }
    std::sort(part.bodies.begin(), part.bodies.end());
    parts.push_back(part);
  }
  std::reverse(parts.begin(), parts.end());
  return parts;
}

// Parts with dependent equations, and how many are independent.
struct Dependent {
  std::vector<JointPart> parts;
  std::vector<int> independent;
};

Dependent dependent_parts(const RestPlace& at) {
  Dependent result;
  for (JointPart& part : parts_of(at)) {
    const Freedom f = freedom_of(at, part);
    if (f.groups.empty()) continue;
    result.parts.push_back(std::move(part));
    result.independent.push_back(f.independent);
  }
  return result;
}

// Whether no more equations of these parts are dependent at q than wherever motions lead: moves all a little at once
// or, where they cannot be together, one after the other.
bool dependent_everywhere(const System& system, const VectorXd& q, const Dependent& dependent) {
  constexpr double kDistance = 0.02;
  const RestPlace at(system, q);
  bool reached = false;
  Inputs u = system.make_inputs();
  // Drives and couplings stay where they are: phi is their coordinate while they prescribe 0.
  for (int d = 0; d < system.drive_count() + system.coupling_count(); ++d) {
    u.x[d] = at.e.phi[system.drive_lambda_index(d)];
  }
  for (int trial = 0; trial < 4; ++trial) {
    VectorXd motion = VectorXd::Zero(system.velocity_size());
    for (const JointPart& part : dependent.parts) {
      const ScaledEquations s = scaled_equations(at, part);
      VectorXd scaled(s.column.size()), of_part = VectorXd::Zero(system.velocity_size());
      for (Eigen::Index i = 0; i < scaled.size(); ++i) {  // any direction without symmetry
        scaled[i] = std::sin(1.0 + (2.0 + trial) * static_cast<double>(i) + 0.7 * trial);
      }
      scaled += RowSpace(s.B_transposed, kDependent).solve(s.B_transposed.transpose() * scaled);
      add_motion(system, part, s.column.cwiseProduct(scaled), of_part);
      const double size = size_of(system, of_part, s.length);
      if (size > kDependent) motion += (kDistance / size) * of_part;
    }
    if (motion.isZero(0)) return true;  // nothing moves
    VectorXd near = displaced(system, q, motion);
    if (!reach_positions(system, u, near)) continue;
    reached = true;
    const RestPlace there(system, near);
    for (std::size_t k = 0; k < dependent.parts.size(); ++k) {
      if (independent_equations(there, dependent.parts[k]) > dependent.independent[k]) return false;
    }
  }
  if (reached || dependent.parts.size() == 1) return true;
  for (std::size_t k = 0; k < dependent.parts.size(); ++k) {
    if (!dependent_everywhere(system, q, {{dependent.parts[k]}, {dependent.independent[k]}})) return false;
  }
  return true;
}

void add(const Freedom& part, Freedom& all) {
  all.independent += part.independent;
  all.groups.insert(all.groups.end(), part.groups.begin(), part.groups.end());
  all.margin = std::min(all.margin, part.margin);
  all.independent_margin = std::min(all.independent_margin, part.independent_margin);
}

}  // namespace

Freedom freedom(const System& system, const VectorXd& q) {
  Freedom result;
  result.velocities = system.velocity_size();
  result.equations = system.constraint_size();
  const RestPlace at(system, q);
  for (const JointPart& part : parts_of(at)) add(freedom_of(at, part), result);
  const auto earlier = [](const Freedom::Group& a, const Freedom::Group& b) { return a.joints[0] < b.joints[0]; };
  std::sort(result.groups.begin(), result.groups.end(), earlier);
  result.independent_of_positions = result.independent;
  if (system.velocity_equations().empty()) return result;
  const RestPlace of_positions(system, q, system.make_inputs(), true);
  result.independent_of_positions = 0;
  for (const JointPart& part : parts_of(of_positions)) {
    result.independent_of_positions += independent_equations(of_positions, part);
  }
  return result;
}

Freedom initial_freedom(const MultibodyDef& definition) {
  const System system(definition);
  VectorXd q = VectorXd::Zero(system.position_size());
  for (int i = 0; i < system.body_count(); ++i) {
    q.segment<3>(7 * i) = definition.bodies[i].initial_position;
    q.segment<4>(7 * i + 3) = definition.bodies[i].initial_quaternion.normalized();
  }
  reach_positions(system, inputs_at_start(definition, system), q);
  return freedom(system, q);
}

// e = eps / m and, of directions, eps / (m L^2), with the mechanism's size L and the mass m of the heaviest body that
// the group's joints hold: under its weight they then give way by eps s g, of any size and mass. d = eps (1 + L^2) and
// eps are as small beside B B^T, whose rows have lengths of this kind.
Compliance find_compliance(const MultibodyDef& definition) {
  constexpr double kCompliance = 1e-7;
  const MultibodyDef as_it_comes = without_held_values(definition);
  const Freedom f = initial_freedom(as_it_comes);
  Compliance result;
  if (f.groups.empty()) return result;
  const System system(as_it_comes);
  const double L = system.size();
  result.dependent = f.equations - f.independent;
  for (const Freedom::Group& group : f.groups) {
    double heaviest = 0;
    for (const auto& i : system.pattern().incidences) {
      if (!std::binary_search(group.joints.begin(), group.joints.end(), i.constraint)) continue;
      heaviest = std::max(heaviest, mass(definition.bodies[system.pattern().unknowns[i.unknown].body]));
    }
    for (int c : group.joints) {
      const Constraint& constraint = system.constraint(c);
      for (int row = 0; row < constraint.equations(); ++row) {
        const bool length = row < constraint.length_equations();
        result.equations.push_back({c, row, kCompliance / (length ? heaviest : heaviest * L * L),
                                    length ? kCompliance * (1 + L * L) : kCompliance});
      }
    }
  }
  return result;
}

bool reach_positions(const System& system, const Inputs& u, VectorXd& q) {
  constexpr int kMaxIterations = 100;
  constexpr double kReached = 1e-11, kMaxMotion = 0.5;  // [m or 1], [rad]
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const RestPlace at(system, q, u, true);
    const double residual = system.position_residual(at.e);
    if (!std::isfinite(residual)) return false;
    if (residual <= kReached * (1 + q.lpNorm<Eigen::Infinity>())) return true;
    VectorXd motion = VectorXd::Zero(system.velocity_size());
    double length = 0;
    for (const JointPart& part : parts_of(at)) {
      const ScaledEquations s = scaled_equations(at, part);
      VectorXd gaps(s.row.size());
      Eigen::Index row = 0;
      for (int joint : part.joints) {  // after what the parts before it do to its bodies
        VectorXd gap = at.e.phi.segment(system.lambda_index(joint), system.constraint(joint).equations());
        for_gradients(at, joint,
                      [&](int velocity, const auto& B) { gap += B.lazyProduct(motion.segment(velocity, B.cols())); });
        gaps.segment(row, gap.size()) = gap;
        row += gap.size();
      }
      const VectorXd scaled = RowSpace(s.B_transposed, kDependent).solve(s.row.cwiseProduct(gaps));
      add_motion(system, part, s.column.cwiseProduct(scaled), motion);
      length = std::max(length, s.length);
    }
    const double size = size_of(system, motion, length);
    if (size > kMaxMotion) motion *= kMaxMotion / size;
    q = displaced(system, q, motion);
  }
  return false;
}

bool singular_at(const System& system, const VectorXd& q, const Freedom& f) {
  return !f.groups.empty() && !dependent_everywhere(system, q, dependent_parts(RestPlace(system, q)));
}

}  // namespace sigmafmu
