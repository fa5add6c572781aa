#include "solve/start/scaled_equations.h"

#include <cmath>

#include "lie/r3xso3.h"

namespace sigmafmu {
namespace {

// Longest lever arm of the joints at each body [m].
VectorXd lever_arms(const System& system, const Evaluation& e) {
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

// Where the velocities of a part are among those of the system.
std::vector<int> velocities(const System& system, const JointPart& part) {
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

}  // namespace

RestPlace::RestPlace(const System& s, const VectorXd& q, const Inputs& u, bool positions)
    : system(s), e(s.make_evaluation()) {
  system.evaluate(q, VectorXd::Zero(system.velocity_size()), u, e);
  if (positions) system.clear_velocity_rows(e);
  lengths = lever_arms(system, e);
}

ScaledEquations scaled_equations(const RestPlace& at, const JointPart& part) {
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

void add_motion(const System& system, const JointPart& part, const VectorXd& motion, VectorXd& all) {
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

double size_of(const System& system, const VectorXd& motion, double length) {
  double largest = 0;
  for (int i = 0; i < system.body_count(); ++i) {
    largest = std::max({largest, motion.segment<3>(6 * i + 3).norm(), motion.segment<3>(6 * i).norm() / length});
  }
  return largest;
}

}  // namespace sigmafmu
