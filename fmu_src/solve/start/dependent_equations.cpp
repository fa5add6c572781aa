#include "solve/start/dependent_equations.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "lie/r3xso3.h"
#include "model/dense.h"
#include "solve/start/assembly.h"
#include "solve/start/row_space.h"
#include "text/text.h"

namespace sigmafmu {
namespace {

// Of what an equation says beyond the others, relative to all it says: rounding leaves 1e-15, a dependence that holds
// in one plane alone and is left by the rounding of positions 1e-9.
constexpr double kDependent = 1e-8;
constexpr double kFlat = 1e-6;       // sine of an angle between disk and plane
constexpr double kTakesPart = 1e-5;  // smallest weight of an equation in a dependence

// Longest lever arm of the joints at each body [m].
VectorXd lengths(const System& system, const Evaluation& e) {
  VectorXd length = VectorXd::Zero(system.body_count());
  for (const auto& [constraint, body, offset] : system.pattern().incidences) {
    if (!system.pattern().unknowns[body].pose) continue;
    const ConstRows B(e.B.data() + offset, system.constraint(constraint).equations(), 6);
    for (Eigen::Index row = 0; row < B.rows(); ++row) {
      const double displacement = B.row(row).head<3>().norm();
      if (displacement > 0) length[body] = std::max(length[body], B.row(row).tail<3>().norm() / displacement);
    }
  }
  return length;
}

// The mechanism at rest in a position.
struct Place {
  const System& system;
  Evaluation e;
  VectorXd lengths;

  Place(const System& s, const VectorXd& q) : Place(s, q, s.make_inputs()) {}
  // `positions`: without equations of velocities alone.
  Place(const System& s, const VectorXd& q, const Inputs& u, bool positions = false)
      : system(s), e(s.make_evaluation()) {
    system.evaluate(q, VectorXd::Zero(system.velocity_size()), u, e);
    if (positions) system.clear_velocity_rows(e);
    lengths = sigmafmu::lengths(system, e);
  }
};

// Joints whose equations are looked at together, and the bodies that these place. Motions of a part are six for each
// body, then those of modes, body after body.
struct Part {
  std::vector<int> joints;  // each next to those that it shares a body with: equations then have little fill
  std::vector<int> bodies;  // in ascending order
};

// The equations of a part by its motions, both scaled: B by `row` and `column`, the motions per scaled one.
struct ScaledEquations {
  Eigen::SparseMatrix<double> B_transposed;  // a column for each equation
  VectorXd row, column;
  double length = 1;  // the largest of a body [m]
};

// Rows and the columns of each body's translation and rotation get about the same size: what depends on each other
// does so in any scale, but what is independent is farthest from dependence in this one.
void equilibrate(int bodies, ScaledEquations& equations) {
  constexpr int kSweeps = 8;
  constexpr double kNothing = 1e-8;  // rounding is not to be scaled up
  using Entry = Eigen::SparseMatrix<double>::InnerIterator;
  Eigen::SparseMatrix<double>& B = equations.B_transposed;
  VectorXd scale(B.rows());
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    scale.setZero();
    for (int i = 0; i < B.cols(); ++i) {
      for (Entry x(B, i); x; ++x) scale[x.row() - x.row() % 3] += x.value() * x.value();
    }
    for (int k = 0; k < B.rows(); ++k) {
      if (k >= 6 * bodies) {
        scale[k] = 1;
      } else if (k % 3 == 0) {
        const double size = std::sqrt(scale[k]);
        scale[k] = size > kNothing ? 1 / size : 1.0;
      } else {
        scale[k] = scale[k - 1];
      }
    }
    equations.column = equations.column.cwiseProduct(scale);
    for (int i = 0; i < B.cols(); ++i) {
      double sum = 0;
      for (Entry x(B, i); x; ++x) {
        x.valueRef() *= scale[x.row()];
        sum += x.value() * x.value();
      }
      if (!(sum > 0)) continue;
      const double per_size = 1 / std::sqrt(sum);
      for (Entry x(B, i); x; ++x) x.valueRef() *= per_size;
      equations.row[i] *= per_size;
    }
  }
}

// Calls use(first velocity of a body or of its modes, B) for each block of a joint's equations.
template <typename Use>
void for_gradients(const Place& at, int joint, Use use) {
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const BlockPattern& pattern = at.system.pattern();
  const auto before = [](const BlockPattern::Incidence& i, int j) { return i.constraint < j; };  // joint by joint
  auto i = std::lower_bound(pattern.incidences.begin(), pattern.incidences.end(), joint, before);
  for (; i != pattern.incidences.end() && i->constraint == joint; ++i) {
    const Unknown& unknown = pattern.unknowns[i->unknown];
    use(unknown.velocity,
        Eigen::Map<const RowMajor>(at.e.B.data() + i->offset, pattern.constraint_sizes[joint], unknown.size));
  }
}

// Where the velocities of a part are among those of the system.
std::vector<int> velocities(const System& system, const Part& part) {
  std::vector<int> result;
  const auto add = [&](int first, int count) {
    for (int k = 0; k < count; ++k) result.push_back(first + k);
  };
  for (int body : part.bodies) add(6 * body, 6);
  for (int body : part.bodies) {
    if (system.modes(body) > 0) add(system.modal_velocity(system.flexible_index(body)), system.modes(body));
  }
  return result;
}

ScaledEquations scaled_equations(const Place& at, const Part& part) {
  const System& system = at.system;
  const std::vector<int> places = velocities(system, part);  // ascending
  ScaledEquations s;
  s.column.setOnes(static_cast<Eigen::Index>(places.size()));
  s.length = 0;
  for (int body : part.bodies) s.length = std::max(s.length, at.lengths[body]);
  if (s.length == 0) s.length = 1;
  const int bodies = static_cast<int>(part.bodies.size());
  for (int i = 0; i < bodies; ++i) s.column.segment<3>(6 * i + 3).setConstant(1 / s.length);

  std::vector<Eigen::Triplet<double>> entries;
  bool finite = true;
  int first = 0;
  for (int joint : part.joints) {
    for_gradients(at, joint, [&](int velocity, const auto& B) {
      const auto place = std::lower_bound(places.begin(), places.end(), velocity);
      if (place == places.end() || *place != velocity) return;
      const int motion = static_cast<int>(place - places.begin());
      finite = finite && B.allFinite();
      for (int i = 0; i < B.rows(); ++i) {
        for (int k = 0; k < B.cols(); ++k) {
          if (B(i, k) != 0) entries.emplace_back(motion + k, first + i, B(i, k) * s.column[motion + k]);
        }
      }
    });
    first += system.constraint(joint).equations();
  }
  s.row.setOnes(first);
  s.B_transposed.resize(s.column.size(), first);
  s.B_transposed.setFromTriplets(entries.begin(), entries.end());
  if (finite) equilibrate(bodies, s);
  return s;
}

// Adds a motion of a part to one of the system.
void add_motion(const System& system, const Part& part, const VectorXd& motion, VectorXd& all) {
  const std::vector<int> places = velocities(system, part);
  for (std::size_t k = 0; k < places.size(); ++k) all[places[k]] += motion[static_cast<Eigen::Index>(k)];
}

VectorXd displaced(const System& system, const VectorXd& q, const VectorXd& motion) {
  VectorXd result = q;
  for (int i = 0; i < system.body_count(); ++i) {
    result.segment<7>(7 * i) = lie::compose(q.segment<7>(7 * i), motion.segment<6>(6 * i));
  }
  result.tail(system.modal_count()) += motion.tail(system.modal_count());
  return result;
}

// Largest rotation [rad] of a motion, or displacement by `length`.
double size_of(const System& system, const VectorXd& motion, double length) {
  double largest = 0;
  for (int i = 0; i < system.body_count(); ++i) {
    largest = std::max({largest, motion.segment<3>(6 * i + 3).norm(), motion.segment<3>(6 * i).norm() / length});
  }
  return largest;
}

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

std::string list(const MultibodyDef& definition, const std::vector<int>& joints) {
  std::string text;
  for (std::size_t k = 0; k < joints.size(); ++k) {
    text += (k == 0 ? "" : k + 1 == joints.size() ? " and " : ", ") + constraint_name(definition, joints[k]);
  }
  return text;
}

int independent_equations(const Place& at, const Part& part) {
  return RowSpace(scaled_equations(at, part).B_transposed, kDependent).rank();
}

Freedom freedom_of(const Place& at, const Part& part) {
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
std::vector<Part> parts_of(const Place& at) {
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
  std::vector<Part> parts;
  while (!held_by_one.empty()) {
    const int body = held_by_one.back();
    held_by_one.pop_back();
    if (left[body] != 1) continue;
    const int joint =
        *std::find_if(joints_at[body].begin(), joints_at[body].end(), [&](int j) { return done[j] == 0; });
    const Part part{{joint}, {body}};
    if (!freedom_of(at, part).groups.empty()) continue;
    parts.push_back(part);
    done[joint] = 1;
    for (int i : bodies_of[joint]) {
      if (--left[i] == 1) held_by_one.push_back(i);
    }
  }
  for (int first = 0; first < system.constraint_count(); ++first) {
    if (done[first] != 0 || bodies_of[first].empty()) continue;  // a free joint has no equation
    Part part{{first}, {}};
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
  std::vector<Part> parts;
  std::vector<int> independent;
};

Dependent dependent_parts(const Place& at) {
  Dependent result;
  for (Part& part : parts_of(at)) {
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
  const Place at(system, q);
  bool reached = false;
  Inputs u = system.make_inputs();
  // Drives and couplings stay where they are: phi is their coordinate while they prescribe 0.
  for (int d = 0; d < system.drive_count() + system.coupling_count(); ++d) {
    u.x[d] = at.e.phi[system.drive_lambda_index(d)];
  }
  for (int trial = 0; trial < 4; ++trial) {
    VectorXd motion = VectorXd::Zero(system.velocity_size());
    for (const Part& part : dependent.parts) {
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
    const Place there(system, near);
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

// Whether more equations are dependent at q, where `f` is known, than wherever else its joints lead.
bool singular_at(const System& system, const VectorXd& q, const Freedom& f) {
  return !f.groups.empty() && !dependent_everywhere(system, q, dependent_parts(Place(system, q)));
}

void add(const Freedom& part, Freedom& all) {
  all.independent += part.independent;
  all.groups.insert(all.groups.end(), part.groups.begin(), part.groups.end());
  all.margin = std::min(all.margin, part.margin);
  all.independent_margin = std::min(all.independent_margin, part.independent_margin);
}

// "2 of the 19 equations of joints a, b and c follow from the others", for each group.
std::string dependences(const MultibodyDef& definition, const Freedom& f) {
  std::string text;
  for (std::size_t k = 0; k < f.groups.size(); ++k) {
    const Freedom::Group& g = f.groups[k];
    text += (k > 0 ? "; " : "") + std::to_string(g.dependent) + " of the " + std::to_string(g.equations) +
            " equations of " + (g.joints.size() == 1 ? "joint " : "joints ") + list(definition, g.joints) +
            (g.dependent == 1 ? " follows from the others" : " follow from the others");
  }
  return text;
}

}  // namespace

Freedom freedom(const System& system, const VectorXd& q) {
  Freedom result;
  result.velocities = system.velocity_size();
  result.equations = system.constraint_size();
  const Place at(system, q);
  for (const Part& part : parts_of(at)) add(freedom_of(at, part), result);
  const auto earlier = [](const Freedom::Group& a, const Freedom::Group& b) { return a.joints[0] < b.joints[0]; };
  std::sort(result.groups.begin(), result.groups.end(), earlier);
  result.independent_of_positions = result.independent;
  if (system.velocity_equations().empty()) return result;
  const Place of_positions(system, q, system.make_inputs(), true);
  result.independent_of_positions = 0;
  for (const Part& part : parts_of(of_positions)) {
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

std::string summary(const Freedom& f) {
  std::ostringstream text = text_stream(6);
  text << f.degrees();
  if (f.degrees_of_positions() > f.degrees()) text << " of velocities, " << f.degrees_of_positions() << " of positions";
  text << " (" << f.velocities << " velocities, " << f.independent << " independent joint equations";
  if (f.equations > f.independent) text << ", " << f.equations - f.independent << " dependent ones";
  text << ")";
  return text.str();
}

bool reach_positions(const System& system, const Inputs& u, VectorXd& q) {
  constexpr int kMaxIterations = 100;
  constexpr double kReached = 1e-11, kMaxMotion = 0.5;  // [m or 1], [rad]
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const Place at(system, q, u, true);
    const double residual = system.position_residual(at.e);
    if (!std::isfinite(residual)) return false;
    if (residual <= kReached * (1 + q.lpNorm<Eigen::Infinity>())) return true;
    VectorXd motion = VectorXd::Zero(system.velocity_size());
    double length = 0;
    for (const Part& part : parts_of(at)) {
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

std::string describe_singular_position(const MultibodyDef& definition, const System& system, const VectorXd& q) {
  const Freedom f = freedom(system, q);
  if (!singular_at(system, q, f)) return "";
  return "The position is singular: " + dependences(definition, f) +
         " in it alone; choose a start at some distance from it, or velocities that lead through it.";
}

std::string describe_dependence(const MultibodyDef& definition, const System& system, const VectorXd& q) {
  const Freedom f = freedom(system, q);
  if (f.groups.empty()) return "";
  return "Joint equations are dependent: " + dependences(definition, f) +
         (singular_at(system, q, f) ? " in this position alone" : "") +
         "; the reactions of these joints are one choice of many that fit the motion.";
}

std::string describe_rigidity(const MultibodyDef& definition, const System& system, const VectorXd& q) {
  const Freedom f = freedom(system, q);
  if (f.degrees() > 0) return "";
  std::vector<int> joints(system.constraint_count());
  std::iota(joints.begin(), joints.end(), 0);
  return "The mechanism cannot move, but its bodies have initial velocities: joints " + list(definition, joints) +
         " hold all of them; degrees of freedom: " + summary(f) + ".";
}

std::string describe_nearness(const System& system, const VectorXd& q) {
  constexpr double kNear = 1e-3;
  const Freedom f = freedom(system, q);
  const bool more = f.equations - f.independent > system.compliance().dependent;
  const double margin = more ? f.margin : f.independent_margin;
  if (margin > kNear) return "";
  std::ostringstream text = text_stream(6);
  text << "The mechanism is near a singular position there: of one joint equation a part of " << margin
       << " is all that does not follow from the others.";
  return text.str();
}

std::string describe_flat_disk(const MultibodyDef& definition, const System& system, const VectorXd& q, double near) {
  const Place at(system, q);
  for (int j = 0; j < system.joint_count(); ++j) {
    const double tilt = system.tilt_of_disk(at.e, j);
    if (!(tilt <= near)) continue;
    return "The disk of joint " + definition.joints[j].name + (tilt > kFlat ? " nearly" : "") +
           " lies flat: with its axis normal to its plane it touches that in no single point.";
  }
  return "";
}

std::string describe_singularity(const MultibodyDef& definition, const System& system, const VectorXd& q) {
  if (const std::string text = describe_flat_disk(definition, system, q); !text.empty()) return text;
  if (const std::string text = describe_singular_position(definition, system, q); !text.empty()) return text;
  const VectorXd length = Place(system, q).lengths.cwiseMax(1e-300);
  double heaviest = 0, least = INFINITY;
  for (const RigidBodyDef& body : definition.bodies) heaviest = std::max(heaviest, mass(body));
  int lightest = 0;
  for (int i = 0; i < system.body_count(); ++i) {
    const RigidBodyDef& body = definition.bodies[i];
    const double inertia = body.modal ? INFINITY : body.inertia.minCoeff() / (length[i] * length[i]);
    const double measure = std::min(mass(body), inertia);
    if (measure < least) least = measure, lightest = i;
  }
  const RigidBodyDef& body = definition.bodies[lightest];
  std::ostringstream text = text_stream(6);
  text << "The mass or inertia of body " << body.name << " is too small for this mechanism: " << mass(body) << " kg";
  if (!body.modal) text << " and at least " << body.inertia.minCoeff() << " kg.m2";
  text << ", where joints act at up to " << length[lightest] << " m and the heaviest body has " << heaviest
       << " kg; digits to tell them apart are missing.";
  return text.str();
}

}  // namespace sigmafmu
