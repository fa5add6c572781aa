// Compliance of constraints whose equations depend on each other.
//
// No equations of motion tell how dependent constraints share a load. Stiff springs in place of them do:
//
//   Phi(q) = e s lambda,   s = beta h^2,   and in the stabilized index-2 form   Phi'(q, v) / gamma' = -d mu
//
// with an e and a d of each equation; s is not below a quarter of the square of the step size that is set. Joints give
// way by less than a step's rounding of velocities, multipliers are unique and smooth, and nothing has to decide about
// a rank while the mechanism moves. Index 2 has Phi' / gamma' = e s lambda. The index-1 equations have a multiple of
// -e lambda beside B vdot as well, until refinement takes it out again (solve/index1.h).
#pragma once

#include <Eigen/Core>
#include <vector>

namespace sigmafmu {

struct Compliance {
  int dependent = 0;  // equations that follow from others; 0: all constraints are exact and what follows is empty
  struct Equation {
    int constraint, row;   // row: among those of the constraint
    double force, motion;  // e [1/kg], of directions [1/(kg m2)], and d [1]
  };
  std::vector<Equation> equations;
};

}  // namespace sigmafmu
