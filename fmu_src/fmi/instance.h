// A slave as an instance of an FMU: a name, the master's log, and the guard around every call. Knows no FMI version;
// the functions of one are thin shells around `guarded`.
#pragma once

#include <memory>
#include <string>
#include <type_traits>

#include "fmi/slave.h"

namespace sigmafmu {

enum class Status { ok, warning, discard, error };  // the numbers that FMI gives them

inline constexpr char kError[] = "logStatusError", kWarning[] = "logStatusWarning", kDiscard[] = "logStatusDiscard",
                      kEvents[] = "logEvents";

// Phases in which a function may be called, as a bit mask.
constexpr unsigned mask(Phase phase) { return 1u << static_cast<unsigned>(phase); }
inline constexpr unsigned kInstantiated = mask(Phase::instantiated), kInitialization = mask(Phase::initialization),
                          kStep = mask(Phase::step), kTerminated = mask(Phase::terminated);
inline constexpr unsigned kAny = kInstantiated | kInitialization | kStep | kTerminated;
inline constexpr unsigned kReadable = kInitialization | kStep | kTerminated;
inline constexpr unsigned kWritable = kInstantiated | kInitialization | kStep;

// The one way to the master's log. Versions of FMI differ in the callback.
class Logger {
 public:
  virtual ~Logger() = default;
  virtual void write(const char* instance, Status status, const char* category, const char* message) const noexcept = 0;
};

// Reports the exception that is being handled; the status that the call returns.
Status report_exception(const Logger& logger, const char* instance, Status when_discarded) noexcept;

class Instance final : private Listener {
 public:
  Instance(const char* name, std::unique_ptr<const Logger> logger, Mechanism mechanism, const char* identity,
           bool logs_events);

  Slave& slave() noexcept { return slave_; }
  const char* name() const noexcept { return name_.c_str(); }
  const Logger& logger() const noexcept { return *logger_; }
  // Warnings and errors are always passed on; logging on or off concerns events alone.
  void log_events(bool on) noexcept { logs_events_ = on; }
  // Throws Refused in other phases.
  void require_phase(const char* function, unsigned allowed) const;
  // Logs why a step is discarded, which needs no memory.
  Status do_step(double t, double H);

 private:
  void warning(const char* text) noexcept override { logger_->write(name(), Status::warning, kWarning, text); }
  void event(const char* text) noexcept override { logger_->write(name(), Status::ok, kEvents, text); }
  bool wants_events() const noexcept override { return logs_events_; }

  const std::string name_;
  const std::unique_ptr<const Logger> logger_;
  bool logs_events_;
  Slave slave_;
};

// An instance of this FMU's model (model.h). Whatever an FMU reads, it reads here. `guid` and `resources` (a location)
// are what the master passes, perhaps null. Throws std::exception with one sentence.
std::unique_ptr<Instance> instantiate(const char* name, std::unique_ptr<const Logger> logger, const char* guid,
                                      const char* resources, bool logs_events);

// Runs body(slave) or Status body(instance) if the call is legal now, turns exceptions into a status and one message.
// Nothing is thrown through a C interface. `when_discarded` is the status of a failed computation.
template <typename Body>
Status guarded(Instance* instance, const char* function, unsigned allowed, Body body,
               Status when_discarded = Status::discard) noexcept {
  if (!instance) return Status::error;
  try {
    instance->require_phase(function, allowed);
    if constexpr (std::is_invocable_v<Body, Slave&>) {
      body(instance->slave());
      return Status::ok;
    } else {
      return body(*instance);
    }
  } catch (...) {
    return report_exception(instance->logger(), instance->name(), when_discarded);
  }
}

}  // namespace sigmafmu
