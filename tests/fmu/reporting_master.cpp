// A master that makes an FMU report whatever it can, with a logger that formats what it gets, as FMI allows:
//
//   reporting_master reports|locale|allocation|memory LIBRARY GUID RESOURCES
//                    STEPSIZE SPECTRALRADIUS FORMULATION MAXHALVINGS STEPS TORQUE BAD_RESOURCES...
//
// Capitals from STEPSIZE to TORQUE are value references. `reports` goes through every kind of report and prints a line
// `instance|status|category|message` for each; `locale` does the same as a master whose C and C++ locales group digits
// and have a decimal comma; `allocation` has the n-th allocation fail and `memory` all after it, too, for n = 1, 2, ...
// until an instance can be made, initialized and stepped, and prints the different reports.
#include <dlfcn.h>
#include <fmi2Functions.h>

#include <clocale>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
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
bool one_fails_alone = false;

bool granted() {
  if (allocations_left > 0) return allocations_left-- > 0;
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
bool printing = true;

void logger(void*, fmi2String instance, fmi2Status status, fmi2String category, fmi2String message, ...) {
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

enum Reference { kStepSize, kSpectralRadius, kFormulation, kMaxHalvings, kSteps, kTorque };

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

void memory(const Fmu& fmu) {
  printing = false;
  // A first exception: for its thread-local data in a library that was loaded late glibc allocates at first use, and
  // ends the process if it cannot.
  fmi2Component c = fmu.instantiate("it");
  set(fmu, c, kStepSize, -1);
  CALL(fmi2FreeInstance, c);
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

}  // namespace

int main(int argc, char** argv) {
  if (argc < 11) return 2;
  const std::string mode = argv[1];
  if (mode == "locale") {
    std::setlocale(LC_ALL, "");
    std::locale::global(std::locale(std::locale::classic(), new DecimalComma));
  }
  Fmu fmu{dlopen(argv[2], RTLD_NOW | RTLD_LOCAL), argv[3], argv[4], {}};
  if (!fmu.library) return std::fprintf(stderr, "%s\n", dlerror()), 2;
  for (int i = 5; i < 11; ++i) fmu.references.push_back(static_cast<fmi2ValueReference>(std::atoi(argv[i])));
  if (mode == "allocation" || mode == "memory") {
    one_fails_alone = mode == "allocation";
    memory(fmu);
  } else {
    reports(fmu, {argv + 11, argv + argc});
  }
  return 0;
}
