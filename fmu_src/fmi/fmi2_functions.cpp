// Every function of FMI 2.0 for co-simulation. Each goes through one guard, which checks the instance and the order of
// calls and turns exceptions into a status and one log message; nothing throws through the C interface.
#include <fmi2Functions.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "fmi/model.h"
#include "fmi/resources.h"
#include "fmi/slave.h"
#include "model/modal_file.h"

namespace {

using sigmafmu::Phase;
using sigmafmu::Slave;

constexpr char kError[] = "logStatusError", kWarning[] = "logStatusWarning", kDiscard[] = "logStatusDiscard",
               kEvents[] = "logEvents";

// Phases in which a function may be called (FMI 2.0, section 4.2.4), as a bit mask.
constexpr unsigned kInstantiated = 1u << static_cast<unsigned>(Phase::instantiated);
constexpr unsigned kInitialization = 1u << static_cast<unsigned>(Phase::initialization);
constexpr unsigned kStep = 1u << static_cast<unsigned>(Phase::step);
constexpr unsigned kTerminated = 1u << static_cast<unsigned>(Phase::terminated);
constexpr unsigned kAny = kInstantiated | kInitialization | kStep | kTerminated;
constexpr unsigned kReadable = kInitialization | kStep | kTerminated;
constexpr unsigned kWritable = kInstantiated | kInitialization | kStep;

const char* name(Phase phase) {
  switch (phase) {
    case Phase::instantiated:
      return "instantiated";
    case Phase::initialization:
      return "initialization mode";
    case Phase::step:
      return "step mode";
    default:
      return "terminated";
  }
}

constexpr char kNoMemory[] = "There is not enough memory.";

// The one way to the master's logger. It is variadic like printf and formats what it gets, so a percent sign comes
// doubled. Throws nothing: it reports from handlers of exceptions, too.
void report(const fmi2CallbackFunctions& callbacks, const char* instance, fmi2Status status, const char* category,
            const char* message) noexcept {
  if (!callbacks.logger) return;
  std::string text;
  try {
    for (const char* c = message; *c; ++c) text.append(*c == '%' ? 2 : 1, *c);
    message = text.c_str();
  } catch (...) {
    message = kNoMemory;
  }
  callbacks.logger(callbacks.componentEnvironment, instance, status, category, message);
}

struct Component {
  std::string instance;
  fmi2CallbackFunctions callbacks;
  bool logs_events;
  Slave slave;

  Component(const char* instance_name, sigmafmu::Mechanism mechanism, const fmi2CallbackFunctions& functions,
            bool logging)
      : instance(instance_name),
        callbacks(functions),
        logs_events(logging),
        slave(std::move(mechanism), sigmafmu::kGuid, [this](Slave::Report report, const std::string& text) {
          if (report == Slave::Report::warning) {
            log(fmi2Warning, kWarning, text.c_str());
          } else if (logs_events) {
            log(fmi2OK, kEvents, text.c_str());
          }
        }) {
    slave.reports_events = logging;
  }

  // Warnings and errors are always passed on; logging on or off concerns events alone.
  void log(fmi2Status status, const char* category, const char* message) const noexcept {
    report(callbacks, instance.c_str(), status, category, message);
  }
};

// Reports the exception that is being handled.
fmi2Status failed(const fmi2CallbackFunctions& callbacks, const char* instance) noexcept {
  try {
    throw;
  } catch (const std::bad_alloc&) {
    report(callbacks, instance, fmi2Error, kError, kNoMemory);
  } catch (const std::exception& e) {
    report(callbacks, instance, fmi2Error, kError, e.what());
  } catch (...) {
    report(callbacks, instance, fmi2Error, kError, "An error without a description.");
  }
  return fmi2Error;
}

fmi2Status refuse(const Component& c, const std::string& text) {
  c.log(fmi2Error, kError, text.c_str());
  return fmi2Error;
}

// Runs body(component) if the call is legal now. `when_discarded` is the status of a failed computation.
template <typename Body>
fmi2Status guarded(fmi2Component c, const char* function, unsigned allowed, Body body,
                   fmi2Status when_discarded = fmi2Discard) {
  auto* component = static_cast<Component*>(c);
  if (!component) return fmi2Error;
  try {
    const Phase phase = component->slave.phase();
    if (!(allowed & (1u << static_cast<unsigned>(phase)))) {
      return refuse(*component, std::string(function) + " is not allowed in the state \"" + name(phase) + "\".");
    }
    return body(*component);
  } catch (const sigmafmu::Discarded& e) {
    component->log(when_discarded, when_discarded == fmi2Error ? kError : kDiscard, e.what());
    return when_discarded;
  } catch (...) {
    return failed(component->callbacks, component->instance.c_str());
  }
}

template <typename... Pointers>
void require(const char* function, std::size_t count, Pointers... pointers) {
  if (count > 0 && (... || (pointers == nullptr))) {
    throw sigmafmu::Refused(std::string(function) + " got a null pointer for " + std::to_string(count) + " values.");
  }
}

fmi2Status unsupported_type(fmi2Component c, const char* function, unsigned allowed, std::size_t count) {
  return guarded(c, function, allowed, [&](Component& component) {
    if (count == 0) return fmi2OK;
    return refuse(component, std::string(function) + ": this FMU has no variables of that type.");
  });
}

fmi2Status no_status(fmi2Component c, const char* function) {
  return guarded(c, function, kAny, [&](Component& component) {
    const std::string text =
        std::string(function) +
        ": this information exists for asynchronous steps alone; steps here end before fmi2DoStep returns.";
    component.log(fmi2Discard, kDiscard, text.c_str());
    return fmi2Discard;
  });
}

// The mechanism with its modal data. Only mechanisms that have such files look at the resource location.
sigmafmu::Mechanism load_mechanism(fmi2String resources) {
  sigmafmu::Mechanism mechanism = sigmafmu::make_mechanism();
  const auto files = sigmafmu::modal_files(mechanism);
  if (files.empty()) return mechanism;
  if (!resources || !*resources) {
    throw sigmafmu::Refused("The resource location is missing; this FMU reads " + files[0] + " from there.");
  }
  sigmafmu::load_modal_files(mechanism, sigmafmu::folder_of_uri(resources));
  return mechanism;
}

}  // namespace

extern "C" {

const char* fmi2GetTypesPlatform() { return fmi2TypesPlatform; }
const char* fmi2GetVersion() { return fmi2Version; }

fmi2Component fmi2Instantiate(fmi2String instance, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions* functions, fmi2Boolean, fmi2Boolean logging) {
  if (!functions) return nullptr;
  try {
    using sigmafmu::Refused;
    if (!instance || !*instance) throw Refused("The instance name is missing; it must not be empty.");
    if (type != fmi2CoSimulation) throw Refused("This FMU is for co-simulation alone.");
    if (!guid || std::strcmp(guid, sigmafmu::kGuid) != 0) {
      throw Refused(std::string("The GUID does not fit; it must be ") + sigmafmu::kGuid + ".");
    }
    return new Component(instance, load_mechanism(resources), *functions, logging != fmi2False);
  } catch (...) {
    failed(*functions, instance ? instance : "");
    return nullptr;
  }
}

void fmi2FreeInstance(fmi2Component c) { delete static_cast<Component*>(c); }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String categories[]) {
  return guarded(c, "fmi2SetDebugLogging", kAny, [&](Component& component) {
    bool events = count == 0;
    require("fmi2SetDebugLogging", count, categories);
    for (size_t i = 0; i < count; ++i) {
      const std::string category = categories[i] ? categories[i] : "";
      if (category == kEvents || category == "logAll") {
        events = true;
      } else if (category != kError && category != kWarning && category != kDiscard) {
        return refuse(component, "The log category \"" + category + "\" is unknown.");
      }
    }
    component.slave.reports_events = component.logs_events = on != fmi2False && events;
    return fmi2OK;
  });
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean has_stop, fmi2Real stop) {
  return guarded(c, "fmi2SetupExperiment", kInstantiated, [&](Component& component) {
    component.slave.setup_experiment(start, has_stop != fmi2False, stop, has_tolerance != fmi2False ? tolerance : 0.0);
    return fmi2OK;
  });
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
  return guarded(c, "fmi2EnterInitializationMode", kInstantiated, [](Component& component) {
    component.slave.enter_initialization();
    return fmi2OK;
  });
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
  return guarded(
      c, "fmi2ExitInitializationMode", kInitialization,
      [](Component& component) {
        component.slave.exit_initialization();
        return fmi2OK;
      },
      fmi2Error);
}

fmi2Status fmi2Terminate(fmi2Component c) {
  return guarded(c, "fmi2Terminate", kStep, [](Component& component) {
    component.slave.terminate();
    return fmi2OK;
  });
}

fmi2Status fmi2Reset(fmi2Component c) {
  return guarded(c, "fmi2Reset", kAny, [](Component& component) {
    component.slave.reset();
    return fmi2OK;
  });
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference references[], size_t count, fmi2Real values[]) {
  return guarded(c, "fmi2GetReal", kReadable, [&](Component& component) {
    require("fmi2GetReal", count, references, values);
    component.slave.get(references, count, false, values);
    return fmi2OK;
  });
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference references[], size_t count, const fmi2Real values[]) {
  return guarded(c, "fmi2SetReal", kWritable, [&](Component& component) {
    require("fmi2SetReal", count, references, values);
    component.slave.set(references, count, false, values);
    return fmi2OK;
  });
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference references[], size_t count, fmi2Integer values[]) {
  return guarded(c, "fmi2GetInteger", kReadable, [&](Component& component) {
    require("fmi2GetInteger", count, references, values);
    for (size_t i = 0; i < count; ++i) {
      double value = 0;
      component.slave.get(references + i, 1, true, &value);
      // counters are 64 bit inside
      values[i] = static_cast<fmi2Integer>(std::fmin(value, std::numeric_limits<fmi2Integer>::max()));
    }
    return fmi2OK;
  });
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference references[], size_t count,
                          const fmi2Integer values[]) {
  return guarded(c, "fmi2SetInteger", kWritable, [&](Component& component) {
    require("fmi2SetInteger", count, references, values);
    const std::vector<double> numbers(values, values + count);
    component.slave.set(references, count, true, numbers.data());
    return fmi2OK;
  });
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference[], size_t count, fmi2Boolean[]) {
  return unsupported_type(c, "fmi2GetBoolean", kReadable, count);
}
fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference[], size_t count, const fmi2Boolean[]) {
  return unsupported_type(c, "fmi2SetBoolean", kWritable, count);
}
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference[], size_t count, fmi2String[]) {
  return unsupported_type(c, "fmi2GetString", kReadable, count);
}
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference[], size_t count, const fmi2String[]) {
  return unsupported_type(c, "fmi2SetString", kWritable, count);
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate* state) {
  return guarded(c, "fmi2GetFMUstate", kAny, [&](Component& component) {
    require("fmi2GetFMUstate", 1, state);
    if (*state) {
      *static_cast<sigmafmu::Snapshot*>(*state) = component.slave.save();
    } else {
      *state = new sigmafmu::Snapshot(component.slave.save());
    }
    return fmi2OK;
  });
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
  return guarded(c, "fmi2SetFMUstate", kAny, [&](Component& component) {
    require("fmi2SetFMUstate", 1, state);
    component.slave.restore(*static_cast<const sigmafmu::Snapshot*>(state));
    return fmi2OK;
  });
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate* state) {
  return guarded(c, "fmi2FreeFMUstate", kAny, [&](Component&) {
    if (state) {
      delete static_cast<sigmafmu::Snapshot*>(*state);
      *state = nullptr;
    }
    return fmi2OK;
  });
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t* size) {
  return guarded(c, "fmi2SerializedFMUstateSize", kAny, [&](Component& component) {
    require("fmi2SerializedFMUstateSize", 1, state, size);
    *size = serialize(*static_cast<const sigmafmu::Snapshot*>(state), component.slave.identity()).size();
    return fmi2OK;
  });
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
  return guarded(c, "fmi2SerializeFMUstate", kAny, [&](Component& component) {
    require("fmi2SerializeFMUstate", 1, state, bytes);
    const auto serialized = serialize(*static_cast<const sigmafmu::Snapshot*>(state), component.slave.identity());
    if (size < serialized.size()) {
      return refuse(component, "The buffer for the serialized FMU state has " + std::to_string(size) + " bytes; " +
                                   std::to_string(serialized.size()) + " are needed.");
    }
    std::memcpy(bytes, serialized.data(), serialized.size());
    return fmi2OK;
  });
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate* state) {
  return guarded(c, "fmi2DeSerializeFMUstate", kAny, [&](Component& component) {
    require("fmi2DeSerializeFMUstate", 1, bytes, state);
    auto snapshot =
        std::make_unique<sigmafmu::Snapshot>(sigmafmu::deserialize(bytes, size, component.slave.identity()));
    if (*state) {
      *static_cast<sigmafmu::Snapshot*>(*state) = std::move(*snapshot);
    } else {
      *state = snapshot.release();
    }
    return fmi2OK;
  });
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknowns[], size_t unknown_count,
                                        const fmi2ValueReference knowns[], size_t known_count,
                                        const fmi2Real direction[], fmi2Real derivative[]) {
  return guarded(c, "fmi2GetDirectionalDerivative", kReadable, [&](Component& component) {
    require("fmi2GetDirectionalDerivative", unknown_count, unknowns, derivative);
    require("fmi2GetDirectionalDerivative", known_count, knowns, direction);
    component.slave.directional_derivative(unknowns, unknown_count, knowns, known_count, direction, derivative);
    return fmi2OK;
  });
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference references[], size_t count,
                                       const fmi2Integer orders[], const fmi2Real values[]) {
  return guarded(c, "fmi2SetRealInputDerivatives", kWritable, [&](Component& component) {
    require("fmi2SetRealInputDerivatives", count, references, orders, values);
    component.slave.set_input_derivatives(references, count, orders, values);
    return fmi2OK;
  });
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference references[], size_t count,
                                        const fmi2Integer orders[], fmi2Real values[]) {
  return guarded(c, "fmi2GetRealOutputDerivatives", kStep | kTerminated, [&](Component& component) {
    require("fmi2GetRealOutputDerivatives", count, references, orders, values);
    component.slave.get_output_derivatives(references, count, orders, values);
    return fmi2OK;
  });
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real H, fmi2Boolean) {
  return guarded(c, "fmi2DoStep", kStep, [&](Component& component) {
    if (component.slave.do_step(t, H)) return fmi2OK;
    component.log(fmi2Discard, kDiscard, component.slave.message().c_str());
    return fmi2Discard;
  });
}

fmi2Status fmi2CancelStep(fmi2Component c) {
  return guarded(c, "fmi2CancelStep", kStep, [](Component& component) {
    return refuse(component, "fmi2CancelStep: no step is pending; steps end before fmi2DoStep returns.");
  });
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind, fmi2Status*) { return no_status(c, "fmi2GetStatus"); }

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real* value) {
  if (kind != fmi2LastSuccessfulTime) return no_status(c, "fmi2GetRealStatus");
  return guarded(c, "fmi2GetRealStatus", kStep | kTerminated, [&](Component& component) {
    require("fmi2GetRealStatus", 1, value);
    *value = component.slave.time();
    return fmi2OK;
  });
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind, fmi2Integer*) {
  return no_status(c, "fmi2GetIntegerStatus");
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean* value) {
  if (kind != fmi2Terminated) return no_status(c, "fmi2GetBooleanStatus");
  return guarded(c, "fmi2GetBooleanStatus", kStep | kTerminated, [&](Component&) {
    require("fmi2GetBooleanStatus", 1, value);
    *value = fmi2False;  // the FMU never asks the master to end the simulation
    return fmi2OK;
  });
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind, fmi2String*) {
  return no_status(c, "fmi2GetStringStatus");
}

}  // extern "C"
