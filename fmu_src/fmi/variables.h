// The variables of an FMU: the ports of its mechanism that are exposed, and those of the integrator.
#pragma once

#include <string>
#include <vector>

#include "integrator/state.h"
#include "multibody/ports/ports.h"

namespace sigmafmu {

// What the integrator's own outputs are read from as well.
struct SlaveView : View {
  SlaveView(const View& view, const State& state) : View(view), state(state) {}
  const State& state;
};

struct Variables {
  std::vector<Port> list;  // the value reference of a variable is its index
  std::vector<Owner> owners;
};
Variables make_variables(const Mechanism& mechanism, const System& system);
// Those that are not exposed as well.
Variables make_all_variables(const Mechanism& mechanism, const System& system);

// A checksum of the table: what value references mean.
std::string variables_checksum(const std::vector<Port>& variables);

}  // namespace sigmafmu
