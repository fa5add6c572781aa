// Nodes of a KKT matrix for the block solver: the bodies' frames, the modes of flexible bodies, then lambda
// of each constraint and, in the stabilized form, mu.
#pragma once

#include <array>
#include <memory>

#include "multibody/system.h"
#include "solve/block_lu.h"

namespace sigmafmu {

enum class Kkt {
  index1,      // M and B alone: vdot and lambda
  newton,      // C and K as well: motion and lambda
  stabilized,  // motion, lambda and mu
};

// Plans of factorization for systems of one topology. Each is made when it is asked for the first time; copies share
// them. One thread at a time.
class KktPlans {
 public:
  std::shared_ptr<const BlockLU> get(const BlockPattern& pattern, Kkt form);

 private:
  using Plans = std::array<std::shared_ptr<const BlockLU>, 3>;
  std::shared_ptr<Plans> plans_ = std::make_shared<Plans>();
};

}  // namespace sigmafmu
