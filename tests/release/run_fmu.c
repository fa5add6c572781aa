/* run_fmu LIBRARY GUID RESOURCES STEPS H N INPUT: runs an FMU without any tool and prints the Real outputs 0 to N-1
 * after each step. The Real input with value reference INPUT is 1 all the time. Compiled for Windows, it shows under
 * wine what the DLL does there. C, which needs no library but the system's. */
#include <fmi2FunctionTypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "dynamic_library.h"

#define MOST_OUTPUTS 64

static void logger(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                   fmi2String message, ...) {
  (void)environment, (void)name, (void)status, (void)category;
  fprintf(stderr, "%s\n", message);
}

static void expect_ok(fmi2Status status, const char* function) {
  if (status == fmi2OK) return;
  fprintf(stderr, "%s: status %d\n", function, (int)status);
  exit(1);
}

int main(int argc, char** argv) {
  if (argc != 8) return 2;
  void* library = open_library(argv[1]);
  if (!library) {
    fprintf(stderr, "cannot load %s\n", argv[1]);
    return 1;
  }
#define LOAD(name) name##TYPE* name = (name##TYPE*)symbol(library, #name)
  LOAD(fmi2Instantiate);
  LOAD(fmi2SetupExperiment);
  LOAD(fmi2EnterInitializationMode);
  LOAD(fmi2ExitInitializationMode);
  LOAD(fmi2SetReal);
  LOAD(fmi2DoStep);
  LOAD(fmi2GetReal);
  LOAD(fmi2Terminate);
  LOAD(fmi2FreeInstance);
  const int steps = atoi(argv[4]), outputs = atoi(argv[6]);
  const double H = atof(argv[5]);
  const fmi2ValueReference input = (fmi2ValueReference)atoi(argv[7]);
  const fmi2Real one = 1;
  fmi2ValueReference references[MOST_OUTPUTS];
  fmi2Real values[MOST_OUTPUTS];
  if (outputs > MOST_OUTPUTS) return 2;
  for (int i = 0; i < outputs; ++i) references[i] = (fmi2ValueReference)i;

  const fmi2CallbackFunctions callbacks = {logger, calloc, free, NULL, NULL};
  fmi2Component c = fmi2Instantiate("it", fmi2CoSimulation, argv[2], argv[3], &callbacks, fmi2False, fmi2False);
  if (!c) return 1;
  expect_ok(fmi2SetupExperiment(c, fmi2False, 0, 0, fmi2False, 0), "fmi2SetupExperiment");
  expect_ok(fmi2EnterInitializationMode(c), "fmi2EnterInitializationMode");
  expect_ok(fmi2SetReal(c, &input, 1, &one), "fmi2SetReal");
  expect_ok(fmi2ExitInitializationMode(c), "fmi2ExitInitializationMode");
  for (int i = 0; i < steps; ++i) {
    expect_ok(fmi2DoStep(c, i * H, H, fmi2True), "fmi2DoStep");
    expect_ok(fmi2GetReal(c, references, (size_t)outputs, values), "fmi2GetReal");
    for (int k = 0; k < outputs; ++k) printf(k + 1 < outputs ? "%.17g " : "%.17g\n", values[k]);
  }
  expect_ok(fmi2Terminate(c), "fmi2Terminate");
  fmi2FreeInstance(c);
  return close_library(library) ? 0 : 1; /* what is left of the library would crash from here on */
}
