#include "solve/start/held_projection.h"

#include <algorithm>
#include <cmath>

#include "lie/r3xso3.h"
#include "multibody/dense_blocks.h"
#include "solve/start/assembly.h"
#include "solve/start/least_squares.h"

namespace sigmafmu {
namespace {

using Kind = InitialValue::Kind;

constexpr double kTwoPi = 6.28318530717958647692;
constexpr double kIndependent = 1e-10;  // of equations whose gradients have length 1
// Gaps relative to the positions or velocities: rounding, what is aimed at, what values that are set may leave.
constexpr double kRounding = 1e-15, kReached = 1e-12, kAllowed = 1e-10;

}  // namespace

HeldProjection::HeldProjection(const MultibodyDef& definition, const System& system)
    : definition_(definition),
      system_(system),
      u_(inputs_at_start(definition, system)),
      rest_(u_),
      e_(system.make_evaluation()) {
  rest_.xdot.setZero();
  turned_at_start_ = u_.turned;
}

bool HeldProjection::holds(Kind kind, int object, int component) const {
  return definition_.held.count({kind, object, component}) > 0;
}

HeldProjection::Coordinates HeldProjection::held_coordinates(Kind kind) const {
  Coordinates result;
  for (const auto& [what, start] : definition_.held) {
    if (what.kind != kind) continue;
    result.push_back({system_.coordinate_index(what.object) + what.component, 0.0, initial_value(definition_, what)});
  }
  return result;
}

std::vector<int> HeldProjection::free_coordinates(Kind kind) const {
  std::vector<int> result;
  for (int j = 0; j < system_.joint_count(); ++j) {
    for (int c = 0; c < definition_.joints[j].coordinate_count(); ++c) {
      if (!holds(kind, j, c)) result.push_back(system_.coordinate_index(j) + c);
    }
  }
  return result;
}

// The velocities that a value of a body fixes.
std::vector<int> HeldProjection::columns(const InitialValue& what) const {
  const int body = kVelocitiesPerBody * what.object;
  switch (what.kind) {
    case Kind::quaternion:
      return {body + 3, body + 4, body + 5};
    case Kind::angular_velocity:
      return {body + 3 + what.component};
    case Kind::modal:
    case Kind::modal_rate:
      return {system_.modal_velocity(system_.flexible_index(what.object)) + what.component};
    default:
      return {body + what.component};
  }
}

// Finds the velocities that no projection may change.
void HeldProjection::fix(bool motion) {
  std::vector<bool> fixed(system_.velocity_size(), false);
  for (const auto& [what, start] : definition_.held) {
    if (what.of_joint() || what.of_motion() != motion) continue;
    for (int k : columns(what)) fixed[k] = true;
  }
  const int frames = kVelocitiesPerBody * system_.body_count();
  for (auto& level : free_) level.clear();
  for (int k = 0; k < system_.velocity_size(); ++k) {
    if (!fixed[k]) free_[k >= frames ? 2 : k % kVelocitiesPerBody < 3 ? 0 : 1].push_back(k);
  }
}

// Held positions of bodies, the part s of the way from q0.
void HeldProjection::impose(const VectorXd& q0, double s, VectorXd& q) const {
  const auto between = [s](double from, double to) { return s < 1 ? from + s * (to - from) : to; };
  for (const auto& [what, start] : definition_.held) {
    if (what.of_joint() || what.of_motion()) continue;
    const RigidBodyDef& body = definition_.bodies[what.object];
    const int at = kPositionsPerBody * what.object;
    if (what.kind == Kind::position) {
      q[at + what.component] = between(q0[at + what.component], body.initial_position[what.component]);
    } else if (what.kind == Kind::modal) {
      const int k = system_.modal_position(system_.flexible_index(what.object)) + what.component;
      q[k] = between(q0[k], body.modal->initial_coordinates[what.component]);
    } else {
      const Vector4d set = body.initial_quaternion.normalized();
      lie::Vector6d motion = lie::Vector6d::Zero();
      const auto q0_body = q0.segment<7>(at);
      motion.tail<3>() =
          s * lie::log(lie::quaternion(q0_body).conjugate() * Eigen::Quaterniond(set[0], set[1], set[2], set[3]));
      q.segment<4>(at + 3) = s < 1 ? Vector4d(lie::compose(q0_body, motion).tail<4>()) : set;
    }
  }
}

void HeldProjection::impose(VectorXd& v) const {
  for (const auto& [what, start] : definition_.held) {
    if (!what.of_joint() && what.of_motion()) v[columns(what)[0]] = initial_value(definition_, what);
  }
}

// What the joints' equations and the coordinates, the part s of their ways, miss at q.
VectorXd HeldProjection::gaps(const VectorXd& q, const Coordinates& coordinates, double s) {
  system_.evaluate(q, VectorXd::Zero(system_.velocity_size()), u_, e_);
  int row = system_.constraint_size();
  VectorXd result(row + static_cast<Eigen::Index>(coordinates.size()));
  result.head(row) = e_.phi;
  for (const auto& [c, from, to] : coordinates) {
    const double gap = coordinate(c) - (s < 1 ? from + s * (to - from) : to);
    result[row++] = system_.coordinate(c).is_angle() ? std::remainder(gap, kTwoPi) : gap;
  }
  return result;
}

VectorXd HeldProjection::gaps_of_rates(const VectorXd& q, const VectorXd& v, const Inputs& u,
                                       const Coordinates& rates) {
  system_.evaluate(q, v, u, e_);
  int row = system_.constraint_size();
  VectorXd result(row + static_cast<Eigen::Index>(rates.size()));
  result.head(row) = e_.phidot;
  for (const auto& [c, from, to] : rates) result[row++] = coordinate_rate(c) - to;
  return result;
}

// A and M at q, for a motion or a change of positions: a column of A is what the velocity 1 of its number makes of the
// equations.
void HeldProjection::linearize(const VectorXd& q, const Coordinates& coordinates, bool motion) {
  VectorXd v = VectorXd::Zero(system_.velocity_size());
  Coordinates rates = coordinates;
  for (Coordinate& c : rates) c.to = 0;
  const VectorXd by_itself = gaps_of_rates(q, v, rest_, rates);  // what tables prescribe
  A_.resize(system_.constraint_size() + static_cast<Eigen::Index>(coordinates.size()), v.size());
  for (Eigen::Index k = 0; k < v.size(); ++k) {
    v[k] = 1;
    A_.col(k) = gaps_of_rates(q, v, rest_, rates) - by_itself;
    v[k] = 0;
  }
  if (!motion) {
    for (int row : system_.velocity_equations()) A_.row(row).setZero();
  }
  M_ = dense_pairs(system_, e_.M);
}

// The motion x of what is free with A x = -gaps, as nearly as it can be: the least of the modes, then of the
// orientations, then of the positions.
VectorXd HeldProjection::least_motion(const VectorXd& gaps) const {
  MatrixXd A[kLevels];
  VectorXd y[kLevels], r = gaps, free = VectorXd::Zero(gaps.size()), lengths = free;
  std::vector<MassScaling> mass;
  for (int i = 0; i < kLevels; ++i) {
    A[i] = pick_columns(A_, free_[i]);
    free += A[i].rowwise().squaredNorm();
    mass.emplace_back(pick(M_, free_[i], free_[i]));
    A[i] = mass[i].scaled(A[i]);
    lengths += A[i].rowwise().squaredNorm();
  }
  const VectorXd all = A_.rowwise().squaredNorm();
  for (Eigen::Index row = 0; row < r.size();
       ++row) {  // gradients of length 1, or 0 where all is fixed but for rounding
    const double factor = free[row] > kIndependent * kIndependent * all[row] ? 1 / std::sqrt(lengths[row]) : 0.0;
    for (MatrixXd& level : A) level.row(row) *= factor;
    if (factor > 0) r[row] *= factor;
  }
  solve_in_turn(A, kLevels, r, kIndependent, y);
  VectorXd x = VectorXd::Zero(A_.cols());
  for (int i = 0; i < kLevels; ++i) {
    const VectorXd motion = mass[i].unscaled(y[i]);
    for (std::size_t k = 0; k < free_[i].size(); ++k) x[free_[i][k]] = motion[static_cast<Eigen::Index>(k)];
  }
  return x;
}

VectorXd HeldProjection::moved(const VectorXd& q, const VectorXd& x) const {
  VectorXd result(q.size());
  for (int i = 0; i < system_.body_count(); ++i) {
    result.segment<7>(7 * i) = lie::compose(q.segment<7>(7 * i), x.segment<6>(6 * i));
  }
  result.tail(system_.modal_count()) = q.tail(system_.modal_count()) + x.tail(system_.modal_count());
  return result;
}

// What makes all equations lengths: 1, or the size of the mechanism for directions and angles.
VectorXd HeldProjection::lengths_of_units(const Coordinates& coordinates) const {
  VectorXd result(system_.constraint_size() + static_cast<Eigen::Index>(coordinates.size()));
  result.setConstant(system_.size());
  for (int c = 0; c < system_.constraint_count(); ++c) {
    result.segment(system_.lambda_index(c), system_.constraint(c).length_equations()).setOnes();
  }
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    if (!system_.coordinate(coordinates[i].index).is_angle()) {
      result[system_.constraint_size() + static_cast<Eigen::Index>(i)] = 1;
    }
  }
  return result;
}

// If the coordinates and joints determine the motion of all bodies, the solver for that; else null. Where some
// equations are of velocities alone positions and velocities are not determined by as many.
DeterminedMotion* HeldProjection::determined(const Coordinates& coordinates) {
  const std::size_t free = free_[0].size() + free_[1].size() + free_[2].size();
  if (!system_.velocity_equations().empty() || !DeterminedMotion::applies(system_, coordinates.size()) ||
      static_cast<int>(free) < system_.velocity_size()) {
    return nullptr;
  }
  std::vector<int> indices;
  for (const Coordinate& c : coordinates) indices.push_back(c.index);
  if (!determined_ || determined_->coordinates() != indices) {
    determined_ = std::make_unique<DeterminedMotion>(definition_, indices, u_);
  }
  return determined_.get();
}

// What close() looks for, where nothing has to give way. False when that is not so, or not found.
bool HeldProjection::reach(const Coordinates& coordinates, double s, VectorXd& q) {
  DeterminedMotion* motion = determined(coordinates);
  if (!motion) return false;
  VectorXd x(static_cast<Eigen::Index>(coordinates.size())), found = q;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const auto& [c, from, to] = coordinates[static_cast<std::size_t>(i)];
    x[i] = s < 1 ? from + s * (to - from) : to;
  }
  const auto good = [&] {
    return gaps(found, coordinates, s).lpNorm<Eigen::Infinity>() <= kAllowed * (1.0 + found.lpNorm<Eigen::Infinity>());
  };
  if (!motion->positions(x, found) || !good()) return false;
  q = found;
  return true;
}

// Newton's method. False when it comes to a halt elsewhere.
bool HeldProjection::close(const Coordinates& coordinates, double s, int most_iterations, VectorXd& q) {
  constexpr double kMaxRotation = 0.5;  // in an iteration [rad]
  if (reach(coordinates, s, q)) return true;
  double previous = INFINITY;
  for (int iteration = 0;; ++iteration) {
    const VectorXd r = gaps(q, coordinates, s);
    const double largest = r.size() > 0 ? r.lpNorm<Eigen::Infinity>() : 0.0;
    if (!r.allFinite()) return false;
    const double scale = 1.0 + q.lpNorm<Eigen::Infinity>();
    if (largest <= kRounding * scale) return true;
    if (largest <= kReached * scale && largest >= 0.5 * previous) return true;
    if (iteration == most_iterations) return largest <= kAllowed * scale;
    previous = largest;
    linearize(q, coordinates, false);
    VectorXd x = least_motion(r);
    if (!x.allFinite()) return false;
    double rotation = 0;
    for (int i = 0; i < system_.body_count(); ++i) rotation = std::max(rotation, x.segment<3>(6 * i + 3).norm());
    if (rotation > kMaxRotation) x *= kMaxRotation / rotation;
    if (x.lpNorm<Eigen::Infinity>() <= kRounding * scale) return largest <= kAllowed * scale;
    q = moved(q, x);
  }
}

// Levenberg and Marquardt's method: to where the gaps are smallest, whether that is zero or not.
void HeldProjection::approach(const Coordinates& coordinates, VectorXd& q) {
  constexpr int kIterations = 300;
  constexpr double kSmallest = 1e-9, kLargest = 1e9, kProgress = 1e-14;
  std::vector<int> free;
  for (const auto& level : free_) free.insert(free.end(), level.begin(), level.end());
  const VectorXd weights = lengths_of_units(coordinates);
  VectorXd r = weights.cwiseProduct(gaps(q, coordinates, 1.0)), x = VectorXd::Zero(system_.velocity_size());
  if (free.empty() || !r.allFinite()) return;
  double damping = 1e-3;
  for (int i = 0; i < kIterations; ++i) {
    linearize(q, coordinates, false);
    const MatrixXd A = weights.asDiagonal() * pick_columns(A_, free);
    const double before = r.squaredNorm();
    for (bool better = false; !better; damping = better ? std::max(0.1 * damping, kSmallest) : 10 * damping) {
      if (damping > kLargest) return;
      MatrixXd H = A.transpose() * A;
      H.diagonal().array() += damping;
      const VectorXd motion = solve_definite(H, -(A.transpose() * r));
      for (std::size_t k = 0; k < free.size(); ++k) x[free[k]] = motion[static_cast<Eigen::Index>(k)];
      const VectorXd q_x = moved(q, x), r_x = weights.cwiseProduct(gaps(q_x, coordinates, 1.0));
      better = r_x.squaredNorm() < before;
      if (better) q = q_x, r = r_x;
    }
    if (r.squaredNorm() >= (1 - kProgress) * before) return;
  }
}

// Steps in which nothing turns by more than a tenth or moves by more than a twentieth of the mechanism.
int HeldProjection::steps(const VectorXd& q0, const Coordinates& coordinates) const {
  constexpr double kRotation = 0.1, kPart = 0.05, kMost = 100;
  VectorXd q1 = q0;
  impose(q0, 1.0, q1);
  double count = 1;
  for (int i = 0; i < system_.body_count(); ++i) {
    const lie::Vector7d a = q0.segment<7>(7 * i), b = q1.segment<7>(7 * i);
    count = std::max(count, (a.head<3>() - b.head<3>()).norm() / (kPart * system_.size()));
    count = std::max(count, lie::log(lie::quaternion(a).conjugate() * lie::quaternion(b)).norm() / kRotation);
  }
  for (const auto& [c, from, to] : coordinates) {
    count =
        std::max(count, std::abs(to - from) / (system_.coordinate(c).is_angle() ? kRotation : kPart * system_.size()));
  }
  return static_cast<int>(std::ceil(std::min(count, kMost)));
}

// From q0 to what is held, on the branch that small steps lead along. What the joints forbid on the way is passed over,
// the end alone counts, unless the way itself is the `condition`.
bool HeldProjection::follow(const VectorXd& q0, const Coordinates& coordinates, bool condition, VectorXd& q) {
  constexpr int kOnTheWay = 8, kAtTheEnd = 100;
  const int tries = condition ? 0 : 4;
  q = q0;
  u_.turned = turned_at_start_;
  const int n = steps(q0, coordinates);
  for (int i = 1; i < n; ++i) {
    const double s = static_cast<double>(i) / n;
    impose(q0, s, q);
    if (!close(coordinates, s, kOnTheWay, q) && condition) return false;
    count_turns();
  }
  VectorXd nearest;  // if there is no good end
  bool closed_badly = false;
  for (int attempt = 0;; ++attempt) {
    impose(q0, 1.0, q);
    bool closed = close(coordinates, 1.0, kAtTheEnd, q);
    if (!closed && !condition) {
      approach(coordinates, q);
      if (attempt == 0) nearest = q;
      closed = close(coordinates, 1.0, kAtTheEnd, q);
    }
    if (closed && axes_agree()) {
      impose(q0, 1.0, q);  // to the last bit
      return true;
    }
    if (attempt == tries) break;
    if (attempt == 0) {
      closed_badly = closed;
      if (closed) nearest = q;
      q = q0;  // at one go
      continue;
    }
    // A point where every direction is level, as at the top of a circle, is left by a turn that favours no direction.
    VectorXd turn = VectorXd::Zero(system_.velocity_size());
    for (int i = 0; i < system_.body_count(); ++i) {
      for (int c = 0; c < 3; ++c) turn[6 * i + 3 + c] = std::ldexp(0.05, attempt) * std::cos(1.0 + 3 * i + c);
    }
    q = moved(nearest, turn);
  }
  if (condition) return false;
  q = nearest;
  return closed_badly;  // the caller says what is wrong with it
}

// Couplings follow angles on the way.
void HeldProjection::count_turns() {
  if (system_.coupling_count() == 0) return;
  for (int c = 0; c < system_.coordinate_count(); ++c) {
    double x = coordinate(c);
    if (system_.coordinate(c).is_angle()) x += kTwoPi * std::round((u_.turned[c] - x) / kTwoPi);
    u_.turned[c] = x;
  }
}

bool HeldProjection::axes_agree() const {
  for (int j = 0; j < system_.joint_count(); ++j) {
    if (!system_.axes_agree(e_, j)) return false;
  }
  return true;
}

// Solves with what is held and as many of the wishes as can be had, in their order.
template <typename Solve>
bool HeldProjection::grant(const Coordinates& held, const Coordinates& wishes, VectorXd& x, Solve solve) {
  Coordinates all = held;
  all.insert(all.end(), wishes.begin(), wishes.end());
  if (!wishes.empty() && solve(all, true, x)) return true;
  if (!solve(held, false, x)) return false;
  if (wishes.size() < 2) return true;
  VectorXd attempt;
  all = held;
  for (const Coordinate& wish : wishes) {
    all.push_back(wish);
    if (solve(all, true, attempt)) {
      x = attempt;
    } else {
      all.pop_back();
    }
  }
  return true;
}

void HeldProjection::positions(VectorXd& q) {
  const VectorXd q0 = q;
  fix(false);
  Coordinates held = held_coordinates(Kind::joint_coordinate), wishes;
  system_.evaluate(q0, VectorXd::Zero(system_.velocity_size()), u_, e_);
  for (Coordinate& c : held) {  // whole turns are no way
    c.from = coordinate(c.index);
    if (system_.coordinate(c.index).is_angle()) c.to = c.from + std::fmod(c.to - c.from, kTwoPi);
  }
  for (int c : free_coordinates(Kind::joint_coordinate)) wishes.push_back({c, coordinate(c), coordinate(c)});
  const bool closed = grant(held, wishes, q, [&](const Coordinates& coordinates, bool condition, VectorXd& x) {
    return follow(q0, coordinates, condition, x);
  });
  if (closed) return;
  const VectorXd r = gaps(q, held, 1.0);
  linearize(q, held, false);
  refuse(r, held, false);
}

bool HeldProjection::adjust(const VectorXd& q, const Coordinates& rates, VectorXd& v) {
  impose(v);
  if (system_.constraint_size() + rates.size() == 0) return true;
  const auto good = [&](const VectorXd& w) {
    return gaps_of_rates(q, w, u_, rates).lpNorm<Eigen::Infinity>() <= kAllowed * (1.0 + w.lpNorm<Eigen::Infinity>());
  };
  if (DeterminedMotion* motion = determined(rates)) {
    VectorXd x(static_cast<Eigen::Index>(rates.size())), found = v;
    for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = rates[static_cast<std::size_t>(i)].to;
    if (motion->velocities(q, x, found) && good(found)) {
      v = found;
      return true;
    }
  }
  linearize(q, rates, true);
  for (int repeat = 0; repeat < 2; ++repeat)
    v += least_motion(gaps_of_rates(q, v, u_, rates));  // once more for rounding
  impose(v);
  return good(v);
}

void HeldProjection::velocities(const VectorXd& q0, const VectorXd& q, VectorXd& v) {
  const VectorXd v0 = v;
  fix(true);
  const Coordinates held = held_coordinates(Kind::joint_rate);
  Coordinates wishes;
  system_.evaluate(q0, v0, u_, e_);
  for (int c : free_coordinates(Kind::joint_rate)) wishes.push_back({c, coordinate_rate(c), coordinate_rate(c)});
  const bool possible = grant(held, wishes, v, [&](const Coordinates& rates, bool, VectorXd& x) {
    x = v0;
    return adjust(q, rates, x);
  });
  if (!possible) refuse(gaps_of_rates(q, v, u_, held), held, true);
}

}  // namespace sigmafmu
