// The joints' equations B v = 0 at a position, part by part and scaled: what the search for equations that depend on
// others works on. With allocations: never part of a step that goes well.
#pragma once

#include <Eigen/SparseCore>

#include <algorithm>
#include <vector>

#include "multibody/system.h"

namespace sigmafmu {

// The mechanism at rest in a position.
struct RestPlace {
  const System& system;
  Evaluation e;
  VectorXd lengths;  // longest lever arm of the joints at each body [m]

  RestPlace(const System& s, const VectorXd& q) : RestPlace(s, q, s.make_inputs()) {}
  // `positions`: without equations of velocities alone.
  RestPlace(const System& s, const VectorXd& q, const Inputs& u, bool positions = false);
};

// Joints whose equations are looked at together, and the bodies that these place. Motions of a part are six for each
// body, then those of modes, body after body.
struct JointPart {
  std::vector<int> joints;  // each next to those that it shares a body with: equations then have little fill
  std::vector<int> bodies;  // in ascending order
};

// The equations of a part by its motions, both scaled: B by `row` and `column`, the motions per scaled one.
struct ScaledEquations {
  Eigen::SparseMatrix<double> B_transposed;  // a column for each equation
  VectorXd row, column;
  double length = 1;  // the largest of a body [m]
};

// Calls use(first velocity of a body or of its modes, B) for each block of a joint's equations.
template <typename Use>
void for_gradients(const RestPlace& at, int joint, Use use) {
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

ScaledEquations scaled_equations(const RestPlace& at, const JointPart& part);

// Adds a motion of a part to one of the system.
void add_motion(const System& system, const JointPart& part, const VectorXd& motion, VectorXd& all);

VectorXd displaced(const System& system, const VectorXd& q, const VectorXd& motion);

// Largest rotation [rad] of a motion, or displacement by `length`.
double size_of(const System& system, const VectorXd& motion, double length);

}  // namespace sigmafmu
