// The complete state of a slave as a plain value, and its form as bytes.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "integrator/state.h"
#include "multibody/input_signal.h"

namespace sigmafmu {

enum class Phase { instantiated, initialization, step, terminated };

struct Snapshot {
  Phase phase = Phase::instantiated;
  double start_time = 0, stop_time = 0;  // [s]
  bool has_stop_time = false;
  double tolerance = 0;            // of the experiment; 0: none
  bool stale = true;               // the state does not follow from the parameters and initial values yet
  std::vector<double> parameters;  // every parameter in the order of the variable table, enumerations as numbers
  State state;
  InputSignal input;
  Inputs last_input;                 // at the end of the last step, against which jumps are measured
  bool parameter_jump = false;       // a tunable parameter changed since the last step ...
  Eigen::VectorXd vdot_before_jump;  // ... and this was vdot just before
};

// Whether all their vectors have the same sizes, so that one can be copied to the other without allocation.
bool same_sizes(const Snapshot& a, const Snapshot& b);

// Bytes that another process with the same FMU can read. `identity` (the GUID, after a checksum of what came from
// resources) and a checksum are part of them.
std::vector<char> serialize(const Snapshot& snapshot, const std::string& identity);
// Throws std::invalid_argument with one sentence when the bytes are not those of such a snapshot.
Snapshot deserialize(const char* bytes, std::size_t size, const std::string& identity);

}  // namespace sigmafmu
