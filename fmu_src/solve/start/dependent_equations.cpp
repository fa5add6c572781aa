#include "solve/start/dependent_equations.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "lie/r3xso3.h"
#include "model/dense.h"
#include "multibody/dense_blocks.h"
#include "solve/start/least_squares.h"
#include "text/text.h"

namespace sigmafmu {
namespace {

// Of what an equation says beyond the others, relative to all it says: rounding leaves 1e-15, a dependence that holds
// in one plane alone and is left by the rounding of positions 1e-9.
constexpr double kDependent = 1e-8;
constexpr double kTakesPart = 1e-5;  // smallest weight of an equation in a dependence

// Longest lever arm of the joints at each body [m].
VectorXd lengths(const System& system, const Evaluation& e) {
  VectorXd length = VectorXd::Zero(system.body_count());
  for (const auto& [constraint, unknown, offset] : system.pattern().incidences) {
    if (!system.pattern().unknowns[unknown].pose) continue;
    const ConstRows B(e.B.data() + offset, system.constraint(constraint).equations(), 6);
    for (Eigen::Index row = 0; row < B.rows(); ++row) {
      const double displacement = B.row(row).head<3>().norm();
      if (displacement > 0) length[unknown] = std::max(length[unknown], B.row(row).tail<3>().norm() / displacement);
    }
  }
  return length;
}

// The joints' equations by motions, both scaled: B and phi by `row`, B by `column`, the motions per scaled one.
struct ScaledEquations {
  MatrixXd B;
  VectorXd phi, row, column;
  double length;  // the largest of a body [m]
};

// Rows and the columns of each body's translation and rotation get about the same size: what depends on each other
// does so in any scale, but what is independent is farthest from dependence in this one.
void equilibrate(int bodies, ScaledEquations& equations) {
  constexpr int kSweeps = 8;
  constexpr double kNothing = 1e-8;  // rounding is not to be scaled up
  MatrixXd& B = equations.B;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (int group = 0; group < 2 * bodies; ++group) {
      const double size = B.middleCols<3>(3 * group).norm();
      if (!(size > kNothing)) continue;
      B.middleCols<3>(3 * group) /= size;
      equations.column.segment<3>(3 * group) /= size;
    }
    for (Eigen::Index i = 0; i < B.rows(); ++i) {
      const double size = B.row(i).norm();
      if (!(size > 0)) continue;
      B.row(i) /= size;
      equations.row[i] /= size;
    }
  }
}

ScaledEquations scaled_equations(const System& system, const VectorXd& q, Evaluation& e) {
  system.evaluate(q, VectorXd::Zero(system.velocity_size()), e);
  ScaledEquations s;
  s.column.setOnes(system.velocity_size());
  s.row.setOnes(system.constraint_size());
  const double largest = lengths(system, e).maxCoeff();
  s.length = largest > 0 ? largest : 1.0;
  for (int i = 0; i < system.body_count(); ++i) s.column.segment<3>(6 * i + 3).setConstant(1 / s.length);
  s.B = dense_rows(system, e.B) * s.column.asDiagonal();
  if (s.B.allFinite()) equilibrate(system.body_count(), s);
  s.phi = e.phi;
  return s;
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

// Joints that `weights` of dependences tie together: the smallest of each group.
std::vector<int> tied_joints(const System& system, const MatrixXd& weights) {
  std::vector<int> joint_of, group(system.joint_count());
  for (int j = 0; j < system.joint_count(); ++j) {
    joint_of.insert(joint_of.end(), system.joint(j).equations(), j);
    group[j] = j;
  }
  for (Eigen::Index k = 0; k < weights.cols(); ++k) {
    int smallest = system.joint_count();
    std::vector<int> tied;
    for (Eigen::Index i = 0; i < weights.rows(); ++i) {
      if (std::abs(weights(i, k)) <= kTakesPart) continue;
      tied.push_back(group[joint_of[i]]);
      smallest = std::min(smallest, tied.back());
    }
    for (int& g : group) {
      if (std::find(tied.begin(), tied.end(), g) != tied.end()) g = smallest;
    }
  }
  return group;
}

std::string list(const MultibodyDef& definition, const std::vector<int>& joints) {
  std::string text;
  for (std::size_t k = 0; k < joints.size(); ++k) {
    text += (k == 0 ? "" : k + 1 == joints.size() ? " and " : ", ") + definition.joints[joints[k]].name;
  }
  return text;
}

// Whether equations that are dependent at q are so wherever its motions lead: moves along them a little.
bool dependent_everywhere(const System& system, const VectorXd& q, int independent) {
  constexpr double kDistance = 0.02;
  Evaluation e = system.make_evaluation();
  const ScaledEquations s = scaled_equations(system, q, e);
  const LeastSquares equations(s.B, kDependent);
  for (int trial = 0; trial < 4; ++trial) {
    VectorXd motion(system.velocity_size());
    for (Eigen::Index i = 0; i < motion.size(); ++i) {  // any direction without symmetry
      motion[i] = std::sin(1.0 + (2.0 + trial) * static_cast<double>(i) + 0.7 * trial);
    }
    motion += equations.solve(product(s.B, motion));
    motion = s.column.cwiseProduct(motion).eval();
    const double size = size_of(system, motion, s.length);
    if (!(size > kDependent)) return true;  // nothing moves
    motion *= kDistance / size;
    VectorXd near = displaced(system, q, motion);
    if (reach_positions(system, near) && freedom(system, near).independent > independent) return false;
  }
  return true;
}

}  // namespace

Freedom freedom(const System& system, const VectorXd& q) {
  Freedom result;
  result.velocities = system.velocity_size();
  result.equations = system.constraint_size();
  Evaluation e = system.make_evaluation();
  const MatrixXd rows = scaled_equations(system, q, e).B;

  // What each equation says beyond those before it; orthogonalized twice, which is enough.
  MatrixXd basis(result.velocities, std::min(result.velocities, result.equations));
  std::vector<int> independent, dependent;
  for (int i = 0; i < result.equations; ++i) {
    VectorXd beyond = rows.row(i).transpose();
    const auto before = basis.leftCols(result.independent);
    for (int repeat = 0; repeat < 2; ++repeat)
      beyond -= before.lazyProduct(before.transpose().lazyProduct(beyond).eval());
    const double part = beyond.norm();
    result.margin = std::min(result.margin, part);
    if (part > kDependent && result.independent < basis.cols()) {
      basis.col(result.independent++) = beyond / part;
      independent.push_back(i);
    } else {
      dependent.push_back(i);
    }
  }
  if (dependent.empty()) return result;

  MatrixXd left(result.velocities, result.independent);
  for (int k = 0; k < result.independent; ++k) left.col(k) = rows.row(independent[k]).transpose();
  const LeastSquares others(left, kDependent);
  MatrixXd weights = MatrixXd::Zero(result.equations, static_cast<Eigen::Index>(dependent.size()));
  for (Eigen::Index column = 0; column < weights.cols(); ++column) {
    const VectorXd found = others.solve(rows.row(dependent[column]).transpose());
    for (int k = 0; k < result.independent; ++k) weights(independent[k], column) = found[k];
  }
  std::vector<int> dependents(system.joint_count(), 0);
  for (std::size_t k = 0; k < dependent.size(); ++k) {
    weights(dependent[k], k) = 1;
    int j = 0;
    while (j + 1 < system.joint_count() && system.lambda_index(j + 1) <= dependent[k]) ++j;
    ++dependents[j];
  }
  const std::vector<int> group = tied_joints(system, weights);
  for (int first = 0; first < system.joint_count(); ++first) {
    Freedom::Group g;
    for (int j = first; j < system.joint_count(); ++j) {
      if (group[j] != first) continue;
      g.joints.push_back(j);
      g.equations += system.joint(j).equations();
      g.dependent += dependents[j];
    }
    if (g.dependent > 0) result.groups.push_back(g);
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
  reach_positions(system, q);
  return freedom(system, q);
}

std::string summary(const Freedom& f) {
  std::ostringstream text = text_stream(6);
  text << f.degrees() << " (" << f.velocities << " velocities, " << f.independent << " independent joint equations";
  if (f.equations > f.independent) text << ", " << f.equations - f.independent << " dependent ones";
  text << ")";
  return text.str();
}

bool reach_positions(const System& system, VectorXd& q) {
  constexpr int kMaxIterations = 100;
  constexpr double kReached = 1e-11, kMaxMotion = 0.5;  // [m or 1], [rad]
  Evaluation e = system.make_evaluation();
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const ScaledEquations s = scaled_equations(system, q, e);
    if (!s.phi.allFinite()) return false;
    const double residual = s.phi.size() > 0 ? s.phi.cwiseAbs().maxCoeff() : 0.0;
    if (residual <= kReached * (1 + q.lpNorm<Eigen::Infinity>())) return true;
    VectorXd motion = s.column.cwiseProduct(LeastSquares(s.B, kDependent).solve(s.row.cwiseProduct(s.phi)));
    const double size = size_of(system, motion, s.length);
    if (size > kMaxMotion) motion *= kMaxMotion / size;
    q = displaced(system, q, motion);
  }
  return false;
}

std::string describe_dependence(const MultibodyDef& definition, const System& system, const VectorXd& q) {
  const Freedom f = freedom(system, q);
  if (f.groups.empty()) return "";
  const bool always = dependent_everywhere(system, q, f.independent);
  std::string text = always ? "Joint equations are dependent: " : "The position is singular: ";
  for (std::size_t k = 0; k < f.groups.size(); ++k) {
    const Freedom::Group& g = f.groups[k];
    text += (k > 0 ? "; " : "") + std::to_string(g.dependent) + " of the " + std::to_string(g.equations) +
            " equations of " + (g.joints.size() == 1 ? "joint " : "joints ") + list(definition, g.joints) +
            (g.dependent == 1 ? " follows from the others" : " follow from the others");
  }
  if (!always) return text + " in it alone; choose a start at some distance from it.";
  return text + "; replace a joint by one that leaves more freedom.";
}

std::string describe_nearness(const System& system, const VectorXd& q) {
  constexpr double kNear = 1e-3;
  const double margin = freedom(system, q).margin;
  if (margin > kNear) return "";
  std::ostringstream text = text_stream(6);
  text << "The mechanism is near a singular position there: of one joint equation a part of " << margin
       << " is all that does not follow from the others.";
  return text.str();
}

std::string describe_singularity(const MultibodyDef& definition, const System& system, const VectorXd& q) {
  if (const std::string text = describe_dependence(definition, system, q); !text.empty()) return text;
  Evaluation e = system.make_evaluation();
  system.evaluate(q, VectorXd::Zero(system.velocity_size()), e);
  const VectorXd length = lengths(system, e).cwiseMax(1e-300);
  double heaviest = 0, least = INFINITY;
  for (const RigidBodyDef& body : definition.bodies) heaviest = std::max(heaviest, mass(body));
  std::size_t lightest = 0;
  for (std::size_t i = 0; i < definition.bodies.size(); ++i) {
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
