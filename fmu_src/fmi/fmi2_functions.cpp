// Every function of FMI 2.0 for co-simulation, each a thin shell around one guard. They are `noexcept`, which the
// declarations of fmi2Functions.h are not; its types are checked at the end.
#include <fmi2FunctionTypes.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "fmi/instance.h"
#include "text/text.h"

#if defined _WIN32 || defined __CYGWIN__
#define SIGMAFMU_EXPORT __declspec(dllexport)
#else
#define SIGMAFMU_EXPORT __attribute__((visibility("default")))
#endif

namespace {

using namespace sigmafmu;

// Variadic like printf, the master's logger formats what it gets: a percent sign comes doubled.
class Fmi2Logger final : public Logger {
 public:
  explicit Fmi2Logger(const fmi2CallbackFunctions& callbacks) noexcept : callbacks_(callbacks) {}

  void write(const char* instance, Status status, const char* category, const char* message) const noexcept override {
    if (!callbacks_.logger) return;
    std::string doubled;
    try {
      if (std::strchr(message, '%')) {
        for (const char* c = message; *c; ++c) doubled.append(*c == '%' ? 2 : 1, *c);
        message = doubled.c_str();
      }
    } catch (...) {
      message = kNoMemory;
    }
    callbacks_.logger(callbacks_.componentEnvironment, instance, static_cast<fmi2Status>(status), category, message);
  }

 private:
  fmi2CallbackFunctions callbacks_;
};

template <typename Body>
fmi2Status call(fmi2Component c, const char* function, unsigned allowed, Body body,
                Status when_discarded = Status::discard) noexcept {
  return static_cast<fmi2Status>(guarded(static_cast<Instance*>(c), function, allowed, body, when_discarded));
}

template <typename... Pointers>
void require(const char* function, std::size_t count, Pointers... pointers) {
  if (count > 0 && (... || (pointers == nullptr))) {
    fail<Refused>(function, " got a null pointer for ", count, " values.");
  }
}

fmi2Status unsupported_type(fmi2Component c, const char* function, unsigned allowed, std::size_t count) noexcept {
  return call(c, function, allowed, [&](Slave&) {
    if (count > 0) fail<Refused>(function, ": this FMU has no variables of that type.");
  });
}

fmi2Status no_status(fmi2Component c, const char* function) noexcept {
  return call(c, function, kAny, [&](Slave&) {
    fail<Discarded>(function,
                    ": this information exists for asynchronous steps alone; steps here end before fmi2DoStep ",
                    "returns.");
  });
}

// Whether events are among the categories; none means all.
bool names_events(const fmi2String categories[], std::size_t count) {
  bool events = count == 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::string category = categories[i] ? categories[i] : "";
    if (category == kEvents || category == "logAll") {
      events = true;
    } else if (category != kError && category != kWarning && category != kDiscard) {
      fail<Refused>("The log category \"", category, "\" is unknown.");
    }
  }
  return events;
}

// Counters have 64 bits inside.
fmi2Integer bounded(double value) {
  using Limits = std::numeric_limits<fmi2Integer>;
  return static_cast<fmi2Integer>(std::fmax(Limits::min(), std::fmin(value, Limits::max())));
}

const Snapshot& snapshot_of(fmi2FMUstate state) { return *static_cast<const Snapshot*>(state); }

// Into the snapshot that the master has, or a new one.
void hand_over(Snapshot snapshot, fmi2FMUstate* state) {
  if (*state) {
    *static_cast<Snapshot*>(*state) = std::move(snapshot);
  } else {
    *state = new Snapshot(std::move(snapshot));
  }
}

}  // namespace

extern "C" {

SIGMAFMU_EXPORT const char* fmi2GetTypesPlatform() noexcept { return fmi2TypesPlatform; }
SIGMAFMU_EXPORT const char* fmi2GetVersion() noexcept { return "2.0"; }

SIGMAFMU_EXPORT fmi2Component fmi2Instantiate(fmi2String instance, fmi2Type type, fmi2String guid, fmi2String resources,
                                              const fmi2CallbackFunctions* functions, fmi2Boolean,
                                              fmi2Boolean logging) noexcept {
  if (!functions) return nullptr;
  try {
    if (!instance || !*instance) throw Refused("The instance name is missing; it must not be empty.");
    if (type != fmi2CoSimulation) throw Refused("This FMU is for co-simulation alone.");
    return instantiate(instance, std::make_unique<Fmi2Logger>(*functions), guid, resources, logging != fmi2False)
        .release();
  } catch (...) {
    report_exception(Fmi2Logger(*functions), instance ? instance : "", Status::error);
    return nullptr;
  }
}

SIGMAFMU_EXPORT void fmi2FreeInstance(fmi2Component c) noexcept { delete static_cast<Instance*>(c); }

SIGMAFMU_EXPORT fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count,
                                               const fmi2String categories[]) noexcept {
  return call(c, "fmi2SetDebugLogging", kAny, [&](Instance& instance) {
    require("fmi2SetDebugLogging", count, categories);
    const bool events = names_events(categories, count);
    instance.log_events(on != fmi2False && events);
    return Status::ok;
  });
}

// --- life ------------------------------------------------------------------------------------------------------------

SIGMAFMU_EXPORT fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance,
                                               fmi2Real start, fmi2Boolean has_stop, fmi2Real stop) noexcept {
  return call(c, "fmi2SetupExperiment", kInstantiated, [&](Slave& slave) {
    slave.setup_experiment(start, has_stop != fmi2False, stop, has_tolerance != fmi2False ? tolerance : 0.0);
  });
}

SIGMAFMU_EXPORT fmi2Status fmi2EnterInitializationMode(fmi2Component c) noexcept {
  return call(c, "fmi2EnterInitializationMode", kInstantiated, [](Slave& slave) { slave.enter_initialization(); });
}

SIGMAFMU_EXPORT fmi2Status fmi2ExitInitializationMode(fmi2Component c) noexcept {
  return call(
      c, "fmi2ExitInitializationMode", kInitialization, [](Slave& slave) { slave.exit_initialization(); },
      Status::error);
}

SIGMAFMU_EXPORT fmi2Status fmi2Terminate(fmi2Component c) noexcept {
  return call(c, "fmi2Terminate", kStep, [](Slave& slave) { slave.terminate(); });
}

SIGMAFMU_EXPORT fmi2Status fmi2Reset(fmi2Component c) noexcept {
  return call(c, "fmi2Reset", kAny, [](Slave& slave) { slave.reset(); });
}

SIGMAFMU_EXPORT fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real H, fmi2Boolean) noexcept {
  return call(c, "fmi2DoStep", kStep, [&](Instance& instance) { return instance.do_step(t, H); });
}

// --- values ----------------------------------------------------------------------------------------------------------

SIGMAFMU_EXPORT fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference references[], size_t count,
                                       fmi2Real values[]) noexcept {
  return call(c, "fmi2GetReal", kReadable, [&](Slave& slave) {
    require("fmi2GetReal", count, references, values);
    slave.get(references, count, false, values);
  });
}

SIGMAFMU_EXPORT fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference references[], size_t count,
                                       const fmi2Real values[]) noexcept {
  return call(c, "fmi2SetReal", kWritable, [&](Slave& slave) {
    require("fmi2SetReal", count, references, values);
    slave.set(references, count, false, values);
  });
}

SIGMAFMU_EXPORT fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference references[], size_t count,
                                          fmi2Integer values[]) noexcept {
  return call(c, "fmi2GetInteger", kReadable, [&](Slave& slave) {
    require("fmi2GetInteger", count, references, values);
    for (size_t i = 0; i < count; ++i) {
      double value = 0;
      slave.get(references + i, 1, true, &value);
      values[i] = bounded(value);
    }
  });
}

SIGMAFMU_EXPORT fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference references[], size_t count,
                                          const fmi2Integer values[]) noexcept {
  return call(c, "fmi2SetInteger", kWritable, [&](Slave& slave) {
    require("fmi2SetInteger", count, references, values);
    const std::vector<double> numbers(values, values + count);
    slave.set(references, count, true, numbers.data());
  });
}

SIGMAFMU_EXPORT fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference[], size_t count,
                                          fmi2Boolean[]) noexcept {
  return unsupported_type(c, "fmi2GetBoolean", kReadable, count);
}
SIGMAFMU_EXPORT fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference[], size_t count,
                                          const fmi2Boolean[]) noexcept {
  return unsupported_type(c, "fmi2SetBoolean", kWritable, count);
}
SIGMAFMU_EXPORT fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference[], size_t count,
                                         fmi2String[]) noexcept {
  return unsupported_type(c, "fmi2GetString", kReadable, count);
}
SIGMAFMU_EXPORT fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference[], size_t count,
                                         const fmi2String[]) noexcept {
  return unsupported_type(c, "fmi2SetString", kWritable, count);
}

// --- derivatives -----------------------------------------------------------------------------------------------------

SIGMAFMU_EXPORT fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknowns[],
                                                        size_t unknown_count, const fmi2ValueReference knowns[],
                                                        size_t known_count, const fmi2Real direction[],
                                                        fmi2Real derivative[]) noexcept {
  return call(c, "fmi2GetDirectionalDerivative", kReadable, [&](Slave& slave) {
    require("fmi2GetDirectionalDerivative", unknown_count, unknowns, derivative);
    require("fmi2GetDirectionalDerivative", known_count, knowns, direction);
    slave.directional_derivative(unknowns, unknown_count, knowns, known_count, direction, derivative);
  });
}

SIGMAFMU_EXPORT fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference references[],
                                                       size_t count, const fmi2Integer orders[],
                                                       const fmi2Real values[]) noexcept {
  return call(c, "fmi2SetRealInputDerivatives", kWritable, [&](Slave& slave) {
    require("fmi2SetRealInputDerivatives", count, references, orders, values);
    slave.set_input_derivatives(references, count, orders, values);
  });
}

SIGMAFMU_EXPORT fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference references[],
                                                        size_t count, const fmi2Integer orders[],
                                                        fmi2Real values[]) noexcept {
  return call(c, "fmi2GetRealOutputDerivatives", kStep | kTerminated, [&](Slave& slave) {
    require("fmi2GetRealOutputDerivatives", count, references, orders, values);
    slave.get_output_derivatives(references, count, orders, values);
  });
}

// --- states ----------------------------------------------------------------------------------------------------------

SIGMAFMU_EXPORT fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate* state) noexcept {
  return call(c, "fmi2GetFMUstate", kAny, [&](Slave& slave) {
    require("fmi2GetFMUstate", 1, state);
    hand_over(slave.save(), state);
  });
}

SIGMAFMU_EXPORT fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) noexcept {
  return call(c, "fmi2SetFMUstate", kAny, [&](Slave& slave) {
    require("fmi2SetFMUstate", 1, state);
    slave.restore(snapshot_of(state));
  });
}

SIGMAFMU_EXPORT fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate* state) noexcept {
  return call(c, "fmi2FreeFMUstate", kAny, [&](Slave&) {
    if (!state) return;
    delete static_cast<Snapshot*>(*state);
    *state = nullptr;
  });
}

SIGMAFMU_EXPORT fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t* size) noexcept {
  return call(c, "fmi2SerializedFMUstateSize", kAny, [&](Slave& slave) {
    require("fmi2SerializedFMUstateSize", 1, state, size);
    *size = slave.serialize(snapshot_of(state)).size();
  });
}

SIGMAFMU_EXPORT fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[],
                                                 size_t size) noexcept {
  return call(c, "fmi2SerializeFMUstate", kAny, [&](Slave& slave) {
    require("fmi2SerializeFMUstate", 1, state, bytes);
    const std::vector<char> serialized = slave.serialize(snapshot_of(state));
    if (size < serialized.size()) {
      fail<Refused>("The buffer for the serialized FMU state has ", size, " bytes; ", serialized.size(),
                    " are needed.");
    }
    std::copy(serialized.begin(), serialized.end(), bytes);
  });
}

SIGMAFMU_EXPORT fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                                   fmi2FMUstate* state) noexcept {
  return call(c, "fmi2DeSerializeFMUstate", kAny, [&](Slave& slave) {
    require("fmi2DeSerializeFMUstate", 1, bytes, state);
    hand_over(slave.deserialize(bytes, size), state);
  });
}

// --- asynchronous steps, which there are none of ---------------------------------------------------------------------

SIGMAFMU_EXPORT fmi2Status fmi2CancelStep(fmi2Component c) noexcept {
  return call(c, "fmi2CancelStep", kStep, [](Slave&) {
    throw Refused("fmi2CancelStep: no step is pending; steps end before fmi2DoStep returns.");
  });
}

SIGMAFMU_EXPORT fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind, fmi2Status*) noexcept {
  return no_status(c, "fmi2GetStatus");
}

SIGMAFMU_EXPORT fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real* value) noexcept {
  if (kind != fmi2LastSuccessfulTime) return no_status(c, "fmi2GetRealStatus");
  return call(c, "fmi2GetRealStatus", kStep | kTerminated, [&](Slave& slave) {
    require("fmi2GetRealStatus", 1, value);
    *value = slave.time();
  });
}

SIGMAFMU_EXPORT fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind, fmi2Integer*) noexcept {
  return no_status(c, "fmi2GetIntegerStatus");
}

SIGMAFMU_EXPORT fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind,
                                                fmi2Boolean* value) noexcept {
  if (kind != fmi2Terminated) return no_status(c, "fmi2GetBooleanStatus");
  return call(c, "fmi2GetBooleanStatus", kStep | kTerminated, [&](Slave&) {
    require("fmi2GetBooleanStatus", 1, value);
    *value = fmi2False;  // the FMU never asks the master to end the simulation
  });
}

SIGMAFMU_EXPORT fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind, fmi2String*) noexcept {
  return no_status(c, "fmi2GetStringStatus");
}

}  // extern "C"

// What is exported is what the standard's header declares.
template <typename Declared, typename... Arguments, typename Result>
constexpr bool is(Result (*)(Arguments...) noexcept) {
  return std::is_same_v<Result (*)(Arguments...), Declared*>;
}
static_assert(is<fmi2GetTypesPlatformTYPE>(fmi2GetTypesPlatform));
static_assert(is<fmi2GetVersionTYPE>(fmi2GetVersion));
static_assert(is<fmi2InstantiateTYPE>(fmi2Instantiate));
static_assert(is<fmi2FreeInstanceTYPE>(fmi2FreeInstance));
static_assert(is<fmi2SetDebugLoggingTYPE>(fmi2SetDebugLogging));
static_assert(is<fmi2SetupExperimentTYPE>(fmi2SetupExperiment));
static_assert(is<fmi2EnterInitializationModeTYPE>(fmi2EnterInitializationMode));
static_assert(is<fmi2ExitInitializationModeTYPE>(fmi2ExitInitializationMode));
static_assert(is<fmi2TerminateTYPE>(fmi2Terminate));
static_assert(is<fmi2ResetTYPE>(fmi2Reset));
static_assert(is<fmi2DoStepTYPE>(fmi2DoStep));
static_assert(is<fmi2GetRealTYPE>(fmi2GetReal));
static_assert(is<fmi2SetRealTYPE>(fmi2SetReal));
static_assert(is<fmi2GetIntegerTYPE>(fmi2GetInteger));
static_assert(is<fmi2SetIntegerTYPE>(fmi2SetInteger));
static_assert(is<fmi2GetBooleanTYPE>(fmi2GetBoolean));
static_assert(is<fmi2SetBooleanTYPE>(fmi2SetBoolean));
static_assert(is<fmi2GetStringTYPE>(fmi2GetString));
static_assert(is<fmi2SetStringTYPE>(fmi2SetString));
static_assert(is<fmi2GetDirectionalDerivativeTYPE>(fmi2GetDirectionalDerivative));
static_assert(is<fmi2SetRealInputDerivativesTYPE>(fmi2SetRealInputDerivatives));
static_assert(is<fmi2GetRealOutputDerivativesTYPE>(fmi2GetRealOutputDerivatives));
static_assert(is<fmi2GetFMUstateTYPE>(fmi2GetFMUstate));
static_assert(is<fmi2SetFMUstateTYPE>(fmi2SetFMUstate));
static_assert(is<fmi2FreeFMUstateTYPE>(fmi2FreeFMUstate));
static_assert(is<fmi2SerializedFMUstateSizeTYPE>(fmi2SerializedFMUstateSize));
static_assert(is<fmi2SerializeFMUstateTYPE>(fmi2SerializeFMUstate));
static_assert(is<fmi2DeSerializeFMUstateTYPE>(fmi2DeSerializeFMUstate));
static_assert(is<fmi2CancelStepTYPE>(fmi2CancelStep));
static_assert(is<fmi2GetStatusTYPE>(fmi2GetStatus));
static_assert(is<fmi2GetRealStatusTYPE>(fmi2GetRealStatus));
static_assert(is<fmi2GetIntegerStatusTYPE>(fmi2GetIntegerStatus));
static_assert(is<fmi2GetBooleanStatusTYPE>(fmi2GetBooleanStatus));
static_assert(is<fmi2GetStringStatusTYPE>(fmi2GetStringStatus));
