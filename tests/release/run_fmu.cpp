// run_fmu LIBRARY GUID STEPS H N: runs an FMU without any tool and prints the Real outputs 0 to N-1 after each step.
// Compiled for Windows, it shows under wine what the DLL does there.
#include <fmi2FunctionTypes.h>

#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <vector>

#ifdef _WIN32
#include <windows.h>
static void* symbol(void* library, const char* name) {
  return reinterpret_cast<void*>(GetProcAddress(static_cast<HMODULE>(library), name));
}
static void* open(const char* path) { return LoadLibraryA(path); }
static bool close(void* library) { return FreeLibrary(static_cast<HMODULE>(library)); }
#else
#include <dlfcn.h>
static void* symbol(void* library, const char* name) { return dlsym(library, name); }
static void* open(const char* path) { return dlopen(path, RTLD_NOW | RTLD_LOCAL); }
static bool close(void* library) { return dlclose(library) == 0; }
#endif

static void logger(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String message, ...) {
  std::fprintf(stderr, "%s\n", message);
}

static void expect_ok(fmi2Status status, const char* function) {
  if (status == fmi2OK) return;
  std::fprintf(stderr, "%s: status %d\n", function, static_cast<int>(status));
  std::exit(1);
}

int main(int argc, char** argv) {
  if (argc != 7) return 2;
  void* library = open(argv[1]);
  if (!library) {
    std::fprintf(stderr, "cannot load %s\n", argv[1]);
    return 1;
  }
#define LOAD(name) const auto name = reinterpret_cast<name##TYPE*>(symbol(library, #name))
  LOAD(fmi2Instantiate);
  LOAD(fmi2SetupExperiment);
  LOAD(fmi2EnterInitializationMode);
  LOAD(fmi2ExitInitializationMode);
  LOAD(fmi2DoStep);
  LOAD(fmi2GetReal);
  LOAD(fmi2Terminate);
  LOAD(fmi2FreeInstance);
  const int steps = std::atoi(argv[4]), outputs = std::atoi(argv[6]);
  const double H = std::atof(argv[5]);
  const fmi2CallbackFunctions callbacks = {logger, std::calloc, std::free, nullptr, nullptr};
  const fmi2Component c = fmi2Instantiate("it", fmi2CoSimulation, argv[2], argv[3], &callbacks, fmi2False, fmi2False);
  if (!c) return 1;
  expect_ok(fmi2SetupExperiment(c, fmi2False, 0, 0, fmi2False, 0), "fmi2SetupExperiment");
  expect_ok(fmi2EnterInitializationMode(c), "fmi2EnterInitializationMode");
  expect_ok(fmi2ExitInitializationMode(c), "fmi2ExitInitializationMode");
  std::vector<fmi2ValueReference> references(outputs);
  for (int i = 0; i < outputs; ++i) references[i] = i;
  std::vector<double> values(outputs);
  for (int i = 0; i < steps; ++i) {
    expect_ok(fmi2DoStep(c, i * H, H, fmi2True), "fmi2DoStep");
    expect_ok(fmi2GetReal(c, references.data(), references.size(), values.data()), "fmi2GetReal");
    for (int k = 0; k < outputs; ++k) std::printf(k + 1 < outputs ? "%.17g " : "%.17g\n", values[k]);
  }
  expect_ok(fmi2Terminate(c), "fmi2Terminate");
  fmi2FreeInstance(c);
  return close(library) ? 0 : 1;  // what is left of the library would crash from here on
}
