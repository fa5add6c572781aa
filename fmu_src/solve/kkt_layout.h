// Nodes of a KKT matrix for the block solver: the bodies' frames, the modes of flexible bodies, then joints with one or
// two unknowns per equation.
#pragma once

#include "multibody/system.h"
#include "solve/block_lu.h"

namespace sigmafmu {

enum class Kkt {
  index1,      // M and B alone: vdot and lambda
  newton,      // C and K as well: motion and lambda
  stabilized,  // motion, lambda and mu
};

BlockLU make_kkt_solver(const BlockPattern& pattern, Kkt form);

}  // namespace sigmafmu
