#include "solve/start/assembly.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "lie/r3xso3.h"
#include "model/dense.h"
#include "solve/start/dependent_equations.h"
#include "solve/start/held_projection.h"
#include "text/text.h"

namespace sigmafmu {
namespace {

using Kind = InitialValue::Kind;

constexpr double kAtRest = 1e-9;  // velocities that nobody meant [m/s], [rad/s]

void read_initial_values(const MultibodyDef& definition, const System& system, VectorXd& q, VectorXd& v) {
  for (int i = 0; i < system.body_count(); ++i) {
    const RigidBodyDef& body = definition.bodies[i];
    q.segment<3>(7 * i) = body.initial_position;
    q.segment<4>(7 * i + 3) = body.initial_quaternion.normalized();
    v.segment<3>(6 * i) = body.initial_velocity;
    v.segment<3>(6 * i + 3) = body.initial_angular_velocity;
    if (!body.modal) continue;
    const int f = system.flexible_index(i), modes = system.modes(i);
    auto zeta = q.segment(system.modal_position(f), modes), zetadot = v.segment(system.modal_velocity(f), modes);
    zeta.setZero();
    zetadot.setZero();
    if (body.modal->initial_coordinates.size() > 0) zeta = body.modal->initial_coordinates;
    if (body.modal->initial_rates.size() > 0) zetadot = body.modal->initial_rates;
  }
}

void require_agreeing_axes(const MultibodyDef& definition, const System& system, const VectorXd& q) {
  Evaluation e = system.make_evaluation();
  system.evaluate(q, VectorXd::Zero(system.velocity_size()), system.make_inputs(), e);
  for (int j = 0; j < system.joint_count(); ++j) {
    if (system.axes_agree(e, j)) continue;
    throw std::runtime_error("The mechanism cannot be assembled from its initial positions: the axes of joint " +
                             definition.joints[j].name +
                             " point in opposite directions; turn the initial quaternions of its bodies.");
  }
}

void require_standing_disks(const MultibodyDef& definition, const System& system, const VectorXd& q) {
  const std::string flat = describe_flat_disk(definition, system, q);
  if (!flat.empty()) throw std::runtime_error(flat);
}

// A thin rod has no inertia about its axis: joints must not let it turn about that alone.
void require_held_rods(const MultibodyDef& definition, const System& system, const VectorXd& q) {
  constexpr double kNothing = 1e-12, kFree = 1e-8;
  Evaluation e = system.make_evaluation();
  system.evaluate(q, VectorXd::Zero(system.velocity_size()), system.make_inputs(), e);
  for (int i = 0; i < system.body_count(); ++i) {
    if (!system.rigid(i)) continue;
    const PrincipalAxes principal = principal_axes(inertia_matrix(definition.bodies[i]));
    if (principal.values[0] > kNothing * principal.values[2]) continue;
    double held = 0;
    for (const auto& [constraint, unknown, offset] : system.pattern().incidences) {
      if (unknown != i) continue;
      const ConstRows B(e.B.data() + offset, system.pattern().constraint_sizes[constraint], 6);
      held = std::max(held, (B.rightCols<3>() * principal.axes.col(0)).cwiseAbs().maxCoeff());
    }
    if (held > kFree * std::min(1.0, system.size())) continue;
    throw std::runtime_error(definition.bodies[i].name +
                             " has no inertia about an axis about which its joints let it turn; it must have some.");
  }
}

// What stopped the projection that began at `start` and came to `end`, if it is not that joints are too far apart.
std::string describe_obstacle(const MultibodyDef& definition, const System& system, ConsistentSolver& solver,
                              const Inputs& u, const VectorXd& start, const VectorXd& end) {
  VectorXd reachable = start, rest = VectorXd::Zero(system.velocity_size());
  if (!reach_positions(system, u, reachable)) return "";
  for (const VectorXd& q : {reachable, end}) {
    const std::string text = describe_singular_position(definition, system, q);
    if (!text.empty()) return text;
  }
  if (solver.project_velocities(reachable, u, rest)) return "";
  return describe_singularity(definition, system, reachable);
}

// Whether a motion goes through a singular position q with velocities v: then joints allow accelerations there. Where
// motions branch they do so for velocities of the branches alone, and at rest nothing tells which one to take.
bool leads_through(const System& system, ConsistentSolver& solver, const Inputs& u, const VectorXd& q,
                   const VectorXd& v) {
  VectorXd vdot(system.velocity_size()), lambda(system.constraint_size());
  return v.lpNorm<Eigen::Infinity>() > kAtRest && solver.accelerations(q, v, u, vdot, lambda);
}

// All initial values give way.
void assemble_freely(const MultibodyDef& definition, const System& system, ConsistentSolver& solver, VectorXd& q,
                     VectorXd& v) {
  read_initial_values(definition, system, q, v);
  const VectorXd q0 = q;
  require_standing_disks(definition, system, q);
  const Inputs u = inputs_at_start(definition, system);
  if (!solver.project_positions(u, q).possible) {
    const std::string reason = describe_obstacle(definition, system, solver, u, q0, q);
    if (!reason.empty()) throw std::runtime_error(reason);
    q = q0;
    HeldProjection(definition, system).positions(q);  // says which joints cannot be closed, unless it can close them
  }
  require_agreeing_axes(definition, system, q);
  require_held_rods(definition, system, q);
  const std::string singular = describe_singular_position(definition, system, q);
  const bool moves = v.lpNorm<Eigen::Infinity>() > kAtRest;
  const bool possible = solver.project_velocities(q, u, v);
  if (!singular.empty() && !(possible && leads_through(system, solver, u, q, v))) throw std::runtime_error(singular);
  if (!possible) throw std::runtime_error(describe_singularity(definition, system, q));
  if (moves && system.drive_count() == 0) {
    const std::string rigid = describe_rigidity(definition, system, q);
    if (!rigid.empty()) throw std::runtime_error(rigid);
  }
}

// A joint's or body's present value.
double present(const System& system, const Evaluation& e, const VectorXd& q, const VectorXd& v,
               const InitialValue& what) {
  const auto& [kind, i, c] = what;
  switch (kind) {
    case Kind::position:
      return q[7 * i + c];
    case Kind::quaternion:
      return q[7 * i + 3 + c];
    case Kind::velocity:
      return v[6 * i + c];
    case Kind::angular_velocity:
      return v[6 * i + 3 + c];
    case Kind::modal:
      return q[system.modal_position(system.flexible_index(i)) + c];
    case Kind::modal_rate:
      return v[system.modal_velocity(system.flexible_index(i)) + c];
    case Kind::joint_coordinate:
      return system.coordinate_value(e, system.coordinate_index(i) + c);
    default:
      return system.coordinate_rate(e, system.coordinate_index(i) + c);
  }
}

// Every vector of initial values, by its first element, and its length; joints first, which say most.
std::vector<std::pair<InitialValue, int>> all_initial_values(const MultibodyDef& definition, const System& system) {
  std::vector<std::pair<InitialValue, int>> result;
  for (int j = 0; j < system.joint_count(); ++j) {
    for (int c = 0; c < definition.joints[j].coordinate_count(); ++c) {
      for (Kind kind : {Kind::joint_coordinate, Kind::joint_rate}) result.push_back({{kind, j, c}, 1});
    }
  }
  for (int i = 0; i < system.body_count(); ++i) {
    for (Kind kind : {Kind::position, Kind::velocity, Kind::angular_velocity}) result.push_back({{kind, i}, 3});
    result.push_back({{Kind::quaternion, i}, 4});
    if (system.modes(i) == 0) continue;
    for (Kind kind : {Kind::modal, Kind::modal_rate}) result.push_back({{kind, i}, system.modes(i)});
  }
  return result;
}

// sum_i p_i(x_i) at the coordinates of all joints.
double sum_of_terms(const MultibodyDef& definition, const CouplingDef& coupling, const VectorXd& coordinates) {
  double result = 0;
  for (const CouplingDef::Term& term : coupling.terms) {
    int c = term.coordinate;
    for (int j = 0; j < term.joint; ++j) c += definition.joints[j].coordinate_count();
    result += Coupling::value(term.polynomial, coordinates[c]).p;
  }
  return result;
}

double offset_at_start(const MultibodyDef& definition, const CouplingDef& coupling, const VectorXd& coordinates) {
  return std::isnan(coupling.offset) ? sum_of_terms(definition, coupling, coordinates) : coupling.offset;
}

double round_to_12_digits(double x) {
  const double digits = std::pow(10.0, 12 - std::max(0.0, std::ceil(std::log10(std::abs(x)))));
  return std::round(x * digits) / digits + 0.0;  // no negative zero
}

}  // namespace

Inputs inputs_at_start(const MultibodyDef& definition, const System& system) {
  Inputs u = system.make_inputs();
  if (u.x.size() == 0) return u;
  VectorXd q(system.position_size()), v(system.velocity_size());
  Evaluation e = system.make_evaluation();
  if (!definition.couplings.empty()) {  // that mesh as the bodies came, not as what was set has them
    read_initial_values(without_held_values(definition), system, q, v);
    system.evaluate(q, v, u, e);
    system.coordinate_values(e, u.turned);
  }
  read_initial_values(definition, system, q, v);
  system.evaluate(q, v, u, e);
  for (int d = 0; d < system.drive_count(); ++d) {
    const DriveDef& drive = definition.drives[d];
    const auto start = [&](Kind kind) {
      const InitialValue what{kind, drive.joint, drive.coordinate};
      return definition.held.count(what) > 0 ? initial_value(definition, what) : present(system, e, q, v, what);
    };
    const double values[] = {drive.table ? 0.0 : drive.value, drive.first_derivative, drive.second_derivative};
    const auto order = static_cast<int>(drive.motion);  // derivatives below that are those of the start
    u.x[d] = order == 0 ? values[0] : start(Kind::joint_coordinate);
    u.xdot[d] = order <= 1 ? values[1 - order] : start(Kind::joint_rate);
    u.xddot[d] = values[2 - order];
  }
  Eigen::Index at = system.drive_count();
  for (const CouplingDef& coupling : definition.couplings) u.x[at++] = offset_at_start(definition, coupling, u.turned);
  for (const MotionDef& motion : definition.motions) {
    for (std::size_t i = 0; i < motion.tables.size(); ++i, ++at) {
      u.x[at] = motion.start[0][i], u.xdot[at] = motion.start[1][i], u.xddot[at] = motion.start[2][i];
    }
  }
  return u;
}

void start_prescribed(const MultibodyDef& definition, const System& system, InputSignal& input) {
  const Inputs u = inputs_at_start(definition, system);
  input.drive[0] = u.x;
  input.drive[1] = u.xdot;
  input.drive[2] = u.xddot;
  input.start = 0;
  for (int k : {3, 4}) input.drive[k].setZero();
  for (int d = 0; d < system.drive_count(); ++d) {
    const DriveDef& drive = definition.drives[d];
    if (drive.motion == DriveDef::Motion::rate) input.drive[3][d] = drive.second_derivative;
    if (drive.motion != DriveDef::Motion::acceleration) continue;
    input.drive[3][d] = drive.first_derivative;
    input.drive[4][d] = drive.second_derivative;
  }
}

void mesh_couplings(const MultibodyDef& definition, const VectorXd& turned, InputSignal& input) {
  auto at = static_cast<Eigen::Index>(definition.drives.size());
  for (const CouplingDef& coupling : definition.couplings) {
    input.drive[0][at++] = sum_of_terms(definition, coupling, turned);
  }
}

void assemble(const MultibodyDef& definition, const System& system, ConsistentSolver& solver, VectorXd& q,
              VectorXd& v) {
  if (definition.held.empty()) return assemble_freely(definition, system, solver, q, v);
  read_initial_values(definition, system, q, v);
  require_standing_disks(definition, system, q);
  assemble_freely(without_held_values(definition), system, solver, q, v);
  const VectorXd q0 = q;
  HeldProjection projection(definition, system);
  const auto moves = [](const auto& entry) { return entry.first.of_motion(); };
  if (!std::all_of(definition.held.begin(), definition.held.end(), moves)) {
    projection.positions(q);
    require_agreeing_axes(definition, system, q);
  }
  projection.velocities(q0, q, v);
}

VectorXd coordinates_at_start(const MultibodyDef& definition, const System& system, const VectorXd& q) {
  constexpr double kTwoPi = 6.28318530717958647692;
  Evaluation e = system.make_evaluation();
  system.evaluate(q, VectorXd::Zero(system.velocity_size()), system.make_inputs(), e);
  VectorXd turned(system.coordinate_count());
  system.coordinate_values(e, turned);
  for (const auto& [what, start] : definition.held) {
    if (what.kind != Kind::joint_coordinate || !definition.joints[what.object].turns(what.component)) continue;
    double& x = turned[system.coordinate_index(what.object) + what.component];
    x += kTwoPi * std::round((initial_value(definition, what) - x) / kTwoPi);
  }
  return turned;
}

std::string describe_moved_values(const MultibodyDef& definition, const System& system, ConsistentSolver& solver,
                                  const VectorXd& q, const VectorXd& v) {
  constexpr double kRounding = 1e-9;
  constexpr int kShown = 4;
  if (definition.held.empty()) return {};
  VectorXd q0 = q, v0 = v;
  assemble_freely(without_held_values(definition), system, solver, q0, v0);
  Evaluation e0 = system.make_evaluation(), e = system.make_evaluation();
  system.evaluate(q0, v0, system.make_inputs(), e0);
  system.evaluate(q, v, system.make_inputs(), e);
  std::ostringstream text = text_stream(6);
  int moved = 0;
  for (const auto& [what, size] : all_initial_values(definition, system)) {
    VectorXd before(size), after(size), change;
    const auto component = [&, first = what](int c) {
      return InitialValue{first.kind, first.object, first.component + c};
    };
    for (int c = 0; c < size; ++c) {
      before[c] = present(system, e0, q0, v0, component(c));
      after[c] = present(system, e, q, v, component(c));
    }
    const bool orientation = what.kind == Kind::quaternion;
    if (orientation && before.dot(after) < 0) before = -before;
    const double scale = 1.0 + before.lpNorm<Eigen::Infinity>() + after.lpNorm<Eigen::Infinity>();
    change = after - before;
    for (int c = 0; c < size; ++c) {
      if (definition.held.count(component(c)) == 0) continue;
      change[c] = 0;
      if (orientation) change.setZero();  // one of its elements holds all
    }
    if (change.lpNorm<Eigen::Infinity>() <= kRounding * scale) continue;
    if (++moved > kShown) continue;
    text << (moved > 1 ? ", " : "") << initial_name(definition, what);
    const auto write = [&](const VectorXd& x) {
      if (x.size() > 1) text << "(";
      for (int c = 0; c < x.size(); ++c) text << (c > 0 ? ", " : "") << (std::abs(x[c]) > 1e-12 * scale ? x[c] : 0.0);
      if (x.size() > 1) text << ")";
    };
    text << " ", write(before), text << " -> ", write(after);
    if (!orientation) text << " " << initial_unit(definition, what);
  }
  if (moved == 0) return {};
  if (moved > kShown) text << " and " << moved - kShown << " more";
  return "Initial values gave way to those that were set: " + text.str() + ".";
}

void find_joint_values(MultibodyDef& definition, const KktPlans& plans) {
  constexpr double kTurn = 6.28318530717958647692;
  for (JointDef& joint : definition.joints) {
    if (joint.type == JointType::distance) joint.length = round_to_12_digits(rod_length(definition, joint));
  }
  const auto& joints = definition.joints;
  if (std::none_of(joints.begin(), joints.end(), [](const JointDef& joint) { return joint.coordinate_count() > 0; }))
    return;
  const System system(definition, find_compliance(definition));
  ConsistentSolver solver(system, plans);
  VectorXd q(system.position_size()), v(system.velocity_size());
  assemble(definition, system, solver, q, v);
  Evaluation e = system.make_evaluation();
  system.evaluate(q, v, system.make_inputs(), e);
  for (int j = 0; j < system.joint_count(); ++j) {
    JointDef& joint = definition.joints[j];
    for (int c = 0; c < joint.coordinate_count(); ++c) {
      double& x = joint.initial_coordinates[c];
      double found = present(system, e, q, v, {Kind::joint_coordinate, j, c});
      if (joint.turns(c) && !std::isnan(x)) found += kTurn * std::round((x - found) / kTurn);  // the turns that it has
      x = round_to_12_digits(found);
      joint.initial_rates[c] = round_to_12_digits(present(system, e, q, v, {Kind::joint_rate, j, c}));
    }
  }
}

}  // namespace sigmafmu
