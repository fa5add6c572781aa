// What a slave says beside the results of its calls: warnings about settings and accuracy, events.
#pragma once

#include <string>

#include "fmi/snapshot.h"
#include "model/mechanism.h"
#include "solve/index1.h"

namespace sigmafmu {

inline constexpr char kNoMemory[] = "There is not enough memory.";

class Listener {
 public:
  virtual void warning(const char* text) noexcept = 0;
  virtual void event(const char* text) noexcept = 0;
  virtual bool wants_events() const noexcept = 0;  // making their texts allocates

 protected:
  ~Listener() = default;
};

// Throws nothing: the call that deserves a remark has succeeded. A text for which there is no memory is replaced by a
// sentence that says so.
class Remarks {
 public:
  explicit Remarks(Listener* listener) : listener_(listener) {}

  void about_start(const Mechanism& mechanism, const System& system, ConsistentSolver& solver,
                   const State& state) noexcept;
  // After a communication step with internal steps of h. Each kind once after a start: results go on, but are not what
  // the user expects.
  void about_step(const Mechanism& mechanism, const State& state, double h) noexcept;
  void about_retries(std::int64_t retries, double t) noexcept;

 private:
  template <typename MakeText>
  void warn(MakeText make_text) noexcept;
  template <typename MakeText>
  void tell(MakeText make_text) noexcept;

  Listener* listener_;
  bool warned_of_error_ = false, warned_of_spin_ = false;
};

}  // namespace sigmafmu
