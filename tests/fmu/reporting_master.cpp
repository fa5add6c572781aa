// A master that makes an FMU report whatever it can, with a logger that formats what it gets, as FMI allows:
//
//   reporting_master MODE LIBRARY GUID RESOURCES
//                    STEPSIZE SPECTRALRADIUS FORMULATION MAXHALVINGS STEPS TORQUE QUATERNION OUTPUT BAD_RESOURCES...
//
// Capitals from STEPSIZE to OUTPUT are value references, QUATERNION the first of a body's initial orientation. The MODE
// `reports` goes through every kind of report and prints a line `instance|status|category|message` for each; `locale`
// does the same as a master whose C and C++ locales group digits and have a decimal comma; `allocation` has the n-th
// allocation fail and `memory` all after it, too, for n = 1, 2, ... until an instance can be made, initialized and
// stepped, and prints the different reports; `allocation-calls` and `memory-calls` do so in each function by itself,
// where it succeeds and where it is refused, and print a line `name|allocations` for each.
#include <dlfcn.h>
#include <fmi2Functions.h>

#include <algorithm>
#include <clocale>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>
#include <locale>
#include <set>
#include <string>
#include <vector>

extern "C" {
void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* old, size_t size);
}

namespace {

constexpr long kMany = std::numeric_limits<long>::max();
long allocations_left = kMany;
bool one_fails_alone = false, any_failed = false;

bool granted() {
  if (allocations_left > 0) return allocations_left-- > 0;
  any_failed = true;
  if (one_fails_alone) allocations_left = kMany;
  return false;
}

// The linker prefers these to the C library's own, also in the FMU.
extern "C" void* malloc(size_t size) { return granted() ? __libc_malloc(size) : nullptr; }
extern "C" void* calloc(size_t count, size_t size) { return granted() ? __libc_calloc(count, size) : nullptr; }
extern "C" void* realloc(void* old, size_t size) { return granted() ? __libc_realloc(old, size) : nullptr; }

struct DecimalComma : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

char last_report[2000];
int reports_made = 0;
fmi2Status last_status = fmi2OK;
bool printing = true;

void logger(void*, fmi2String instance, fmi2Status status, fmi2String category, fmi2String message, ...) {
  ++reports_made;
  last_status = status;
  va_list arguments;
  va_start(arguments, message);
  std::vsnprintf(last_report, sizeof last_report, message, arguments);
  va_end(arguments);
  if (printing) std::printf("%s|%d|%s|%s\n", instance, static_cast<int>(status), category, last_report);
}

const fmi2CallbackFunctions kCallbacks = {logger, std::calloc, std::free, nullptr, nullptr};

struct Fmu {
  void* library;
  const char* guid;
  const char* resources;
  std::vector<fmi2ValueReference> references;

  template <typename Function>
  Function* find(const char* name) const {
    void* symbol = dlsym(library, name);
    if (!symbol) std::fprintf(stderr, "%s is missing\n", name), std::exit(2);
    return reinterpret_cast<Function*>(symbol);
  }
  fmi2Component instantiate(const char* name) const {
    return find<fmi2InstantiateTYPE>("fmi2Instantiate")(name, fmi2CoSimulation, guid, resources, &kCallbacks, fmi2False,
                                                        fmi2True);
  }
};

#define CALL(function, ...) fmu.find<function##TYPE>(#function)(__VA_ARGS__)

enum Reference { kStepSize, kSpectralRadius, kFormulation, kMaxHalvings, kSteps, kTorque, kQuaternion, kOutput };
constexpr int kReferences = kOutput + 1;

void set(const Fmu& fmu, fmi2Component c, Reference r, double value) {
  const fmi2Integer integer = static_cast<fmi2Integer>(value);
  if (r == kFormulation || r == kMaxHalvings || r == kSteps) {
    CALL(fmi2SetInteger, c, &fmu.references[r], 1, &integer);
  } else {
    CALL(fmi2SetReal, c, &fmu.references[r], 1, &value);
  }
}

bool start(const Fmu& fmu, fmi2Component c) {
  return CALL(fmi2SetupExperiment, c, fmi2False, 0, 0, fmi2False, 0) == fmi2OK &&
         CALL(fmi2EnterInitializationMode, c) == fmi2OK && CALL(fmi2ExitInitializationMode, c) < fmi2Discard;
}

void reports(const Fmu& fmu, const std::vector<const char*>& bad_resources) {
  const double big = 1234567.5;
  const fmi2ValueReference unknown = 1234567;
  auto* instantiate = fmu.find<fmi2InstantiateTYPE>("fmi2Instantiate");
  auto* free_instance = fmu.find<fmi2FreeInstanceTYPE>("fmi2FreeInstance");
  fmu.instantiate("");
  instantiate("100%s", fmi2ModelExchange, fmu.guid, fmu.resources, &kCallbacks, fmi2False, fmi2False);
  instantiate("100%s", fmi2CoSimulation, "100%s%n", fmu.resources, &kCallbacks, fmi2False, fmi2False);
  for (const char* resources : bad_resources) {
    free_instance(instantiate("it", fmi2CoSimulation, fmu.guid, resources, &kCallbacks, fmi2False, fmi2False));
  }
  free_instance(instantiate("it", fmi2CoSimulation, fmu.guid, nullptr, &kCallbacks, fmi2False, fmi2False));

  fmi2Component c = fmu.instantiate("50%s");
  const char* category = "100%s%n";
  CALL(fmi2SetDebugLogging, c, fmi2True, 1, &category);
  CALL(fmi2SetReal, c, &unknown, 1, &big);
  CALL(fmi2SetReal, c, nullptr, unknown, &big);
  set(fmu, c, kStepSize, -big);
  set(fmu, c, kFormulation, unknown);
  set(fmu, c, kSteps, 1);
  CALL(fmi2SetString, c, &unknown, 1, &category);
  CALL(fmi2SetupExperiment, c, fmi2False, 0, big, fmi2True, 0);
  CALL(fmi2DoStep, c, 0, 1, fmi2True);
  CALL(fmi2GetStatus, c, fmi2DoStepStatus, nullptr);

  std::vector<char> garbage(1234567, '%');
  fmi2FMUstate state = nullptr;
  CALL(fmi2DeSerializeFMUstate, c, garbage.data(), garbage.size(), &state);
  CALL(fmi2GetFMUstate, c, &state);
  CALL(fmi2SerializeFMUstate, c, state, garbage.data(), 3);
  CALL(fmi2FreeFMUstate, c, &state);

  set(fmu, c, kFormulation, 1);
  set(fmu, c, kSpectralRadius, 1);
  set(fmu, c, kStepSize, 1234.5);
  start(fmu, c);  // with a warning or two
  CALL(fmi2CancelStep, c);
  CALL(fmi2DoStep, c, big, 1, fmi2True);
  const fmi2Integer order = 1234567;
  CALL(fmi2SetRealInputDerivatives, c, &fmu.references[kTorque], 1, &order, &big);

  CALL(fmi2Reset, c);
  set(fmu, c, kStepSize, 2e-3);
  start(fmu, c);
  set(fmu, c, kTorque, 1e6);
  CALL(fmi2DoStep, c, 0, 4e-3, fmi2True);  // steps are repeated, which is an event
  CALL(fmi2Reset, c);
  set(fmu, c, kMaxHalvings, 0);
  start(fmu, c);
  set(fmu, c, kTorque, 1e12);
  CALL(fmi2DoStep, c, 0, 1, fmi2True);  // cannot be finished
  free_instance(c);
}

bool survives(const Fmu& fmu) {
  fmi2Component c = fmu.instantiate("it");
  fmi2FMUstate state = nullptr;
  const bool good = c && start(fmu, c) && CALL(fmi2DoStep, c, 0, 1e-3, fmi2True) == fmi2OK &&
                    CALL(fmi2GetFMUstate, c, &state) == fmi2OK;
  if (c) CALL(fmi2FreeFMUstate, c, &state);
  CALL(fmi2FreeInstance, c);
  return good;
}

// A first exception: for its thread-local data in a library that was loaded late glibc allocates at first use, and ends
// the process if it cannot.
void throw_once(const Fmu& fmu) {
  fmi2Component c = fmu.instantiate("it");
  set(fmu, c, kStepSize, -1);
  CALL(fmi2FreeInstance, c);
}

void memory(const Fmu& fmu) {
  printing = false;
  throw_once(fmu);
  std::set<std::string> different;
  bool good = false;
  long n = 0;
  for (; !good; n += 1 + n / 50) {
    last_report[0] = '\0';
    allocations_left = n;
    good = survives(fmu);
    allocations_left = kMany;
    if (!good) different.insert(last_report);
  }
  for (const std::string& report : different) std::printf("%s\n", report.c_str());
  std::printf("allocations: %ld\n", n);
}

// --- every function by itself ----------------------------------------------------------------------------------------

// What calls need beside the instance.
struct Scene {
  const Fmu& fmu;
  fmi2Component c = nullptr;
  fmi2FMUstate state = nullptr, other = nullptr;
  std::vector<char> bytes = std::vector<char>(1000000);
  size_t size = 0;

  const fmi2ValueReference* reference(Reference r) const { return &fmu.references[r]; }
};

struct Scenario {
  const char* name;
  fmi2Status expected;
  std::function<void(Scene&)> prepare;
  std::function<fmi2Status(Scene&)> call;
};

void nothing(Scene&) {}
void initialization(Scene& s) {
  const Fmu& fmu = s.fmu;
  CALL(fmi2SetupExperiment, s.c, fmi2False, 0, 0, fmi2False, 0);
  CALL(fmi2EnterInitializationMode, s.c);
}
void bad_start(Scene& s) {
  const Fmu& fmu = s.fmu;
  const fmi2ValueReference q = *s.reference(kQuaternion), all[] = {q, q + 1, q + 2, q + 3};
  const double zero[4] = {};
  initialization(s);
  CALL(fmi2SetReal, s.c, all, 4, zero);
}
void warned_start(Scene& s) {
  set(s.fmu, s.c, kFormulation, 1);
  set(s.fmu, s.c, kSpectralRadius, 1);
  set(s.fmu, s.c, kStepSize, 1234.5);
  initialization(s);
}
void step_mode(Scene& s) { start(s.fmu, s.c); }
void step_without_halving(Scene& s) {
  set(s.fmu, s.c, kMaxHalvings, 0);
  start(s.fmu, s.c);
  set(s.fmu, s.c, kTorque, 1e12);
}
void hard_step(Scene& s) {
  set(s.fmu, s.c, kStepSize, 2e-3);
  start(s.fmu, s.c);
  set(s.fmu, s.c, kTorque, 1e6);
}
void saved(Scene& s) {
  const Fmu& fmu = s.fmu;
  start(fmu, s.c);
  CALL(fmi2GetFMUstate, s.c, &s.state);
  CALL(fmi2SerializedFMUstateSize, s.c, s.state, &s.size);
  CALL(fmi2SerializeFMUstate, s.c, s.state, s.bytes.data(), s.size);
}
void saved_with_other_parameters(Scene& s) {
  const Fmu& fmu = s.fmu;
  saved(s);
  CALL(fmi2Reset, s.c);
  set(fmu, s.c, kStepSize, 1.5e-3);
  start(fmu, s.c);
}

#define SCENARIO(function, status, prepare, ...)        \
  {#function " " #prepare " " #status, status, prepare, \
   [](Scene& s) { return s.fmu.find<function##TYPE>(#function)(s.c, __VA_ARGS__); }}

constexpr fmi2ValueReference kUnknown = 1234567;
const char* const kCategories[] = {"logStatusWarning", "logStatusDiscard"};
const char* const kNoCategories[] = {"100%s %n is no category"};
const double kBig = 1234567.5, kOne = 1, kHalf = 0.5, kNegative = -1234567.5;
const fmi2Integer kFirst = 1, kSecond = 2, kNone = 1234567;
double value;
fmi2Integer integer;

std::vector<Scenario> scenarios() {
  return {
      {"fmi2Instantiate", fmi2Error, nothing,
       [](Scene& s) {
         auto* instantiate = s.fmu.find<fmi2InstantiateTYPE>("fmi2Instantiate");
         const bool made =
             instantiate("it", fmi2CoSimulation, "100%s%n", s.fmu.resources, &kCallbacks, fmi2False, fmi2False);
         return made ? fmi2OK : fmi2Error;
       }},
      SCENARIO(fmi2SetDebugLogging, fmi2OK, nothing, fmi2True, 2, kCategories),
      SCENARIO(fmi2SetDebugLogging, fmi2Error, nothing, fmi2True, 1, kNoCategories),
      SCENARIO(fmi2SetupExperiment, fmi2OK, nothing, fmi2True, 1e-3, 0, fmi2False, 0),
      SCENARIO(fmi2SetupExperiment, fmi2Error, nothing, fmi2False, 0, kBig, fmi2True, 0),
      {"fmi2EnterInitializationMode refused", fmi2Error, step_mode,
       [](Scene& s) { return s.fmu.find<fmi2EnterInitializationModeTYPE>("fmi2EnterInitializationMode")(s.c); }},
      {"fmi2ExitInitializationMode", fmi2OK, initialization,
       [](Scene& s) { return s.fmu.find<fmi2ExitInitializationModeTYPE>("fmi2ExitInitializationMode")(s.c); }},
      {"fmi2ExitInitializationMode warned", fmi2OK, warned_start,
       [](Scene& s) { return s.fmu.find<fmi2ExitInitializationModeTYPE>("fmi2ExitInitializationMode")(s.c); }},
      {"fmi2ExitInitializationMode refused", fmi2Error, bad_start,
       [](Scene& s) { return s.fmu.find<fmi2ExitInitializationModeTYPE>("fmi2ExitInitializationMode")(s.c); }},
      {"fmi2Terminate refused", fmi2Error, nothing,
       [](Scene& s) { return s.fmu.find<fmi2TerminateTYPE>("fmi2Terminate")(s.c); }},
      {"fmi2Reset", fmi2OK, warned_start, [](Scene& s) { return s.fmu.find<fmi2ResetTYPE>("fmi2Reset")(s.c); }},
      {"fmi2Reset from step mode", fmi2OK, step_mode,
       [](Scene& s) { return s.fmu.find<fmi2ResetTYPE>("fmi2Reset")(s.c); }},

      SCENARIO(fmi2GetReal, fmi2OK, initialization, s.reference(kOutput), 1, &value),
      SCENARIO(fmi2GetReal, fmi2OK, step_mode, s.reference(kOutput), 1, &value),
      SCENARIO(fmi2GetReal, fmi2Discard, bad_start, s.reference(kOutput), 1, &value),
      SCENARIO(fmi2GetReal, fmi2Error, step_mode, &kUnknown, 1, &value),
      SCENARIO(fmi2SetReal, fmi2OK, nothing, s.reference(kQuaternion), 1, &kHalf),
      SCENARIO(fmi2SetReal, fmi2OK, step_mode, s.reference(kTorque), 1, &kOne),
      SCENARIO(fmi2SetReal, fmi2Error, nothing, s.reference(kStepSize), 1, &kNegative),
      SCENARIO(fmi2SetReal, fmi2Error, step_mode, s.reference(kStepSize), 1, &kOne),
      SCENARIO(fmi2SetReal, fmi2Error, step_mode, nullptr, 1, &kOne),
      SCENARIO(fmi2GetInteger, fmi2OK, step_mode, s.reference(kSteps), 1, &integer),
      SCENARIO(fmi2GetInteger, fmi2Error, step_mode, s.reference(kOutput), 1, &integer),
      SCENARIO(fmi2SetInteger, fmi2OK, nothing, s.reference(kFormulation), 1, &kSecond),
      SCENARIO(fmi2SetInteger, fmi2Error, nothing, s.reference(kFormulation), 1, &kNone),
      SCENARIO(fmi2GetBoolean, fmi2Error, step_mode, s.reference(kSteps), 1, &integer),
      SCENARIO(fmi2SetBoolean, fmi2Error, step_mode, s.reference(kSteps), 1, &kFirst),
      SCENARIO(fmi2GetString, fmi2Error, step_mode, s.reference(kSteps), 1, nullptr),
      SCENARIO(fmi2SetString, fmi2Error, step_mode, s.reference(kSteps), 1, kCategories),

      SCENARIO(fmi2GetFMUstate, fmi2OK, step_mode, &s.state),
      SCENARIO(fmi2GetFMUstate, fmi2OK, saved, &s.state),
      SCENARIO(fmi2GetFMUstate, fmi2Error, step_mode, nullptr),
      SCENARIO(fmi2SetFMUstate, fmi2OK, saved, s.state),
      SCENARIO(fmi2SetFMUstate, fmi2OK, saved_with_other_parameters, s.state),
      SCENARIO(fmi2SetFMUstate, fmi2Error, step_mode, nullptr),
      SCENARIO(fmi2FreeFMUstate, fmi2OK, saved, &s.state),
      SCENARIO(fmi2SerializedFMUstateSize, fmi2OK, saved, s.state, &s.size),
      SCENARIO(fmi2SerializeFMUstate, fmi2OK, saved, s.state, s.bytes.data(), s.size),
      SCENARIO(fmi2SerializeFMUstate, fmi2Error, saved, s.state, s.bytes.data(), 3),
      SCENARIO(fmi2DeSerializeFMUstate, fmi2OK, saved, s.bytes.data(), s.size, &s.state),
      SCENARIO(fmi2DeSerializeFMUstate, fmi2OK, saved_with_other_parameters, s.bytes.data(), s.size, &s.other),
      SCENARIO(fmi2DeSerializeFMUstate, fmi2Error, saved, s.bytes.data(), s.size / 2, &s.other),

      SCENARIO(fmi2GetDirectionalDerivative, fmi2OK, step_mode, s.reference(kOutput), 1, s.reference(kTorque), 1, &kOne,
               &value),
      SCENARIO(fmi2GetDirectionalDerivative, fmi2Error, step_mode, s.reference(kSteps), 1, s.reference(kTorque), 1,
               &kOne, &value),
      SCENARIO(fmi2SetRealInputDerivatives, fmi2OK, step_mode, s.reference(kTorque), 1, &kSecond, &kOne),
      SCENARIO(fmi2SetRealInputDerivatives, fmi2Error, step_mode, s.reference(kTorque), 1, &kNone, &kOne),
      SCENARIO(fmi2GetRealOutputDerivatives, fmi2OK, step_mode, s.reference(kOutput), 1, &kFirst, &value),
      SCENARIO(fmi2GetRealOutputDerivatives, fmi2Error, step_mode, s.reference(kOutput), 1, &kNone, &value),

      SCENARIO(fmi2DoStep, fmi2OK, step_mode, 0, 1e-3, fmi2True),
      SCENARIO(fmi2DoStep, fmi2OK, hard_step, 0, 4e-3, fmi2True),
      SCENARIO(fmi2DoStep, fmi2Error, step_mode, kBig, 1, fmi2True),
      SCENARIO(fmi2DoStep, fmi2Discard, step_without_halving, 0, 1, fmi2True),
      {"fmi2CancelStep", fmi2Error, step_mode,
       [](Scene& s) { return s.fmu.find<fmi2CancelStepTYPE>("fmi2CancelStep")(s.c); }},
      SCENARIO(fmi2GetStatus, fmi2Discard, step_mode, fmi2DoStepStatus, nullptr),
      SCENARIO(fmi2GetRealStatus, fmi2OK, step_mode, fmi2LastSuccessfulTime, &value),
      SCENARIO(fmi2GetRealStatus, fmi2Error, step_mode, fmi2LastSuccessfulTime, nullptr),
      SCENARIO(fmi2GetIntegerStatus, fmi2Discard, step_mode, fmi2DoStepStatus, &integer),
      SCENARIO(fmi2GetBooleanStatus, fmi2Error, nothing, fmi2Terminated, &integer),
      SCENARIO(fmi2GetStringStatus, fmi2Discard, step_mode, fmi2PendingStatus, nullptr),
  };
}

void fail(const Scenario& scenario, long n, const char* what, fmi2Status status) {
  std::printf("%s, allocation %ld: %s; status %d, last report \"%s\"\n", scenario.name, n, what,
              static_cast<int>(status), last_report);
  std::exit(1);
}

// The call of a scenario with memory for n allocations; whether that was enough.
bool enough(const Fmu& fmu, const Scenario& scenario, long n) {
  Scene s{fmu};
  s.c = fmu.instantiate("it");
  scenario.prepare(s);
  reports_made = 0;
  last_report[0] = '\0';
  any_failed = false;
  allocations_left = n;
  fmi2Status status = scenario.call(s);
  allocations_left = kMany;
  const bool failed = any_failed;
  if (status != scenario.expected && !(failed && status == fmi2Error)) fail(scenario, n, "wrong status", status);
  if (status >= fmi2Discard) {
    if (reports_made != 1) fail(scenario, n, "there must be one report", status);
    if (last_status != status || !last_report[0]) fail(scenario, n, "the report does not fit", status);
  }
  if (failed && status != scenario.expected) {  // as if it had not been called
    if (!std::strstr(last_report, "not enough memory")) fail(scenario, n, "the report does not say why", status);
    status = scenario.call(s);
    if (status != scenario.expected) fail(scenario, n, "wrong status when it is called again", status);
  }
  CALL(fmi2FreeFMUstate, s.c, &s.state);
  CALL(fmi2FreeFMUstate, s.c, &s.other);
  CALL(fmi2Reset, s.c);
  set(fmu, s.c, kTorque, 0);
  if (!start(fmu, s.c) || CALL(fmi2DoStep, s.c, 0, 1e-3, fmi2True) != fmi2OK) {
    fail(scenario, n, "the instance is of no use afterwards", status);
  }
  CALL(fmi2FreeInstance, s.c);
  return !failed;
}

void calls(const Fmu& fmu) {
  printing = false;
  throw_once(fmu);
  for (const Scenario& scenario : scenarios()) {
    long n = 0;
    while (!enough(fmu, scenario, n)) n += 1 + n / 20;
    std::printf("%s|%ld\n", scenario.name, n);
  }
}

}  // namespace

int main(int argc, char** argv) {
  constexpr int kFirstReference = 5, kEnd = kFirstReference + kReferences;
  if (argc < kEnd) return 2;
  const std::string mode = argv[1];
  if (mode == "locale") {
    std::setlocale(LC_ALL, "");
    std::locale::global(std::locale(std::locale::classic(), new DecimalComma));
  }
  Fmu fmu{dlopen(argv[2], RTLD_NOW | RTLD_LOCAL), argv[3], argv[4], {}};
  if (!fmu.library) return std::fprintf(stderr, "%s\n", dlerror()), 2;
  for (int i = kFirstReference; i < kEnd; ++i)
    fmu.references.push_back(static_cast<fmi2ValueReference>(std::atoi(argv[i])));
  if (mode == "allocation" || mode == "memory") {
    one_fails_alone = mode == "allocation";
    memory(fmu);
  } else if (mode == "allocation-calls" || mode == "memory-calls") {
    one_fails_alone = mode == "allocation-calls";
    calls(fmu);
  } else {
    reports(fmu, {argv + kEnd, argv + argc});
  }
  return 0;
}
