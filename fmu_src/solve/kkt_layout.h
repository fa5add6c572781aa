// Nodes of a KKT matrix for the block solver: the bodies' frames, the modes of flexible
// bodies, then joints with `sets` unknowns per
// equation.
#pragma once

#include "multibody/system.h"
#include "solve/block_lu.h"

namespace sigmafmu {

// sets = 1: (motion, lambda); sets = 2: (motion, lambda and mu). Bodies and modes are eliminated before joints.
BlockLU make_kkt_solver(const BlockPattern& pattern, int sets);

}  // namespace sigmafmu
