// Where the nonzero blocks of the linearized equations are; fixed when a System is built. Solvers need only this.
//
// Unknowns are what moves: the pose of a body's frame or the modal coordinates of a flexible body. First come the poses
// of all bodies, then the modal coordinates of the flexible ones, each body after body; q and v have this order.
#pragma once

#include <type_traits>
#include <utility>
#include <vector>

#include "multibody/kinematics.h"

namespace sigmafmu {

struct Unknown {
  int body;
  bool pose;               // or modal coordinates
  int position, velocity;  // first entry in q and v
  int size;                // velocities
};

struct BlockPattern {
  struct Incidence {
    int constraint, unknown;
    int offset;  // of the block of B in Evaluation::B, row-major; the same for Z
  };
  struct Pair {
    int row, column;  // unknowns
    int offset;       // of the block in Evaluation::C and K, column-major; the first ones also in M
  };
  int bodies = 0;
  std::vector<Unknown> unknowns;
  std::vector<int> constraint_sizes;    // equations
  std::vector<int> velocity_equations;  // of each constraint: its last ones that are of velocities alone
  // Blocks of M, C and K. Those of M come first: a pose with itself, body after body, then for each flexible body
  // (pose, modes), (modes, pose) and (modes, modes).
  std::vector<Pair> pairs;
  int inertia_pairs = 0;
  std::vector<Incidence> incidences;  // blocks of B and Z

  int unknown_count() const { return static_cast<int>(unknowns.size()); }
  int constraint_count() const { return static_cast<int>(constraint_sizes.size()); }
  // The nodes of a matrix of all: unknowns, then lambda of each constraint, then mu.
  int lambda_node(int constraint) const { return unknown_count() + constraint; }
  int mu_node(int constraint) const { return unknown_count() + constraint_count() + constraint; }
};

// Blocks of a BlockPattern::Pair, with constant sizes where they are.
template <int R, int C>
using PairBlock = Eigen::Map<Eigen::Matrix<double, R, C>, Eigen::Aligned16>;
template <int R, int C>
using ConstPairBlock = Eigen::Map<const Eigen::Matrix<double, R, C>, Eigen::Aligned16>;

inline PairBlock<Eigen::Dynamic, Eigen::Dynamic> pair_block(const BlockPattern& pattern, const BlockPattern::Pair& pair,
                                                            VectorXd& values) {
  return {values.data() + pair.offset, pattern.unknowns[pair.row].size, pattern.unknowns[pair.column].size};
}
inline ConstPairBlock<Eigen::Dynamic, Eigen::Dynamic> pair_block(const BlockPattern& pattern,
                                                                 const BlockPattern::Pair& pair,
                                                                 const VectorXd& values) {
  return {values.data() + pair.offset, pattern.unknowns[pair.row].size, pattern.unknowns[pair.column].size};
}

// Calls use(p, R, C) for the pairs up to `count`; R and C are integral constants, the size of the block or
// Eigen::Dynamic.
template <typename Use>
inline void for_each_pair(const BlockPattern& pattern, int count, Use use) {
  using Six = std::integral_constant<int, kVelocitiesPerBody>;
  using Any = std::integral_constant<int, Eigen::Dynamic>;
  for (int p = 0; p < count; ++p) {
    const bool row = pattern.unknowns[pattern.pairs[p].row].pose;
    const bool column = pattern.unknowns[pattern.pairs[p].column].pose;
    if (row && column) {
      use(p, Six{}, Six{});
    } else if (row) {
      use(p, Six{}, Any{});
    } else if (column) {
      use(p, Any{}, Six{});
    } else {
      use(p, Any{}, Any{});
    }
  }
}

}  // namespace sigmafmu
