// Positions and velocities of a mechanism whose joints and coordinates of joints leave nothing open, such as a tree on
// hinges and sliders.
//
// With a drive on each of these coordinates they are equations of joints like others, as many as there are velocities:
// the sparse solver finds what satisfies them, and there is no choice of what gives way.
#pragma once

#include <vector>

#include "solve/index1.h"

namespace sigmafmu {

class DeterminedMotion {
 public:
  // `coordinates`: among those of all joints. `u`: what the definition's own drives prescribe.
  DeterminedMotion(const MultibodyDef& definition, std::vector<int> coordinates, const Inputs& u);

  // Whether the equations of joints and so many coordinates are as many as velocities.
  static bool applies(const System& system, std::size_t coordinates) {
    return system.constraint_size() + static_cast<int>(coordinates) == system.velocity_size();
  }
  const std::vector<int>& coordinates() const { return coordinates_; }
  // From a q nearby to where coordinates are x; false when that cannot be reached.
  [[nodiscard]] bool positions(const VectorXd& x, VectorXd& q);
  // The velocities at q with which coordinates change at `rates`.
  [[nodiscard]] bool velocities(const VectorXd& q, const VectorXd& rates, VectorXd& v);

 private:
  std::vector<int> coordinates_;
  MultibodyDef driven_;
  System system_;
  ConsistentSolver solver_;
  Inputs u_;
};

}  // namespace sigmafmu
