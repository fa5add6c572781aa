// A master that counts heap allocations and locks inside the functions of an FMU, and forbids system calls in its loop:
//
//   real_time_master LIBRARY GUID RESOURCES H STEPS INPUT,... OUTPUT,... TUNABLE,... AMPLITUDE [VR=INTEGER ...]
//
// takes STEPS communication steps of H, with all inputs (value references) set to values up to AMPLITUDE before each
// and all outputs read after it, once the integers VR have been set; then changes the tunable parameters and goes back
// to an earlier state, ten times. Prints a line `name allocations` for every function and `locks`, those taken in the
// loops.
//
// Every allocation of the process, `operator new` of the FMU included, ends up in the malloc family defined here, since
// the dynamic linker prefers the symbols of the executable; so does every mutex. In the loop the kernel kills the
// process at a system call (seccomp's strict mode, which allows to write and to end).
#include <dlfcn.h>
#include <fmi2Functions.h>
#include <linux/seccomp.h>
#include <pthread.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

extern "C" {
void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* old, size_t size);
void* __libc_memalign(size_t alignment, size_t size);
void __libc_free(void* memory);
}

namespace {

long allocations = 0, locks = 0;
int (*real_lock)(pthread_mutex_t*) = nullptr;

template <typename Function>
Function* find(void* library, const char* name) {
  void* symbol = dlsym(library, name);
  if (!symbol) std::fprintf(stderr, "%s is missing\n", name), std::exit(2);
  return reinterpret_cast<Function*>(symbol);
}

std::vector<unsigned> numbers(const char* text) {
  std::vector<unsigned> result;
  for (char* end = nullptr; *text; text = *end ? end + 1 : end) {
    result.push_back(static_cast<unsigned>(std::strtoul(text, &end, 10)));
  }
  return result;
}

void logger(void*, fmi2String, fmi2Status, fmi2String category, fmi2String message, ...) {
  std::fprintf(stderr, "%s: %s\n", category, message);
}

// Runs a call, adds what it allocates to `count` and gives up if it fails.
template <typename Call>
void counted(long& count, const char* name, Call call) {
  const long before = allocations;
  const fmi2Status status = call();
  count += allocations - before;
  if (status == fmi2OK) return;
  char text[100];
  const int length = std::snprintf(text, sizeof text, "%s failed\n", name);
  syscall(SYS_exit, write(STDERR_FILENO, text, length) == length ? 1 : 2);
}

}  // namespace

extern "C" {

void* malloc(size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
void* calloc(size_t count, size_t size) {
  ++allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* old, size_t size) {
  ++allocations;
  return __libc_realloc(old, size);
}
void* memalign(size_t alignment, size_t size) {
  ++allocations;
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(size_t alignment, size_t size) { return memalign(alignment, size); }
int posix_memalign(void** memory, size_t alignment, size_t size) {
  *memory = memalign(alignment, size);
  return *memory ? 0 : 12;
}
void free(void* memory) { __libc_free(memory); }

int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  ++locks;
  if (!real_lock) real_lock = reinterpret_cast<decltype(real_lock)>(dlsym(RTLD_NEXT, "pthread_mutex_lock"));
  return real_lock(mutex);
}

}  // extern "C"

int main(int argc, char** argv) {
  if (argc < 10) return 2;
  void* library = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL);
  if (!library) return std::fprintf(stderr, "%s\n", dlerror()), 2;
  const double H = std::atof(argv[4]);
  const int steps = std::atoi(argv[5]);
  const std::vector<unsigned> inputs = numbers(argv[6]), outputs = numbers(argv[7]), tunables = numbers(argv[8]);
  std::vector<double> input_values(inputs.size()), output_values(outputs.size()), tunable_values(tunables.size());
  const std::vector<int> orders(inputs.size(), 1);

  auto* instantiate = find<fmi2InstantiateTYPE>(library, "fmi2Instantiate");
  auto* set_integer = find<fmi2SetIntegerTYPE>(library, "fmi2SetInteger");
  auto* enter = find<fmi2EnterInitializationModeTYPE>(library, "fmi2EnterInitializationMode");
  auto* leave = find<fmi2ExitInitializationModeTYPE>(library, "fmi2ExitInitializationMode");
  auto* set_real = find<fmi2SetRealTYPE>(library, "fmi2SetReal");
  auto* set_derivatives = find<fmi2SetRealInputDerivativesTYPE>(library, "fmi2SetRealInputDerivatives");
  auto* get_real = find<fmi2GetRealTYPE>(library, "fmi2GetReal");
  auto* do_step = find<fmi2DoStepTYPE>(library, "fmi2DoStep");
  auto* get_state = find<fmi2GetFMUstateTYPE>(library, "fmi2GetFMUstate");
  auto* set_state = find<fmi2SetFMUstateTYPE>(library, "fmi2SetFMUstate");

  const fmi2CallbackFunctions callbacks = {logger, nullptr, nullptr, nullptr, nullptr};
  fmi2Component c = nullptr;
  long instantiating = 0, stepping = 0, setting = 0, getting = 0, tuning = 0, restoring = 0;
  counted(instantiating, "fmi2Instantiate", [&] {
    c = instantiate("counted", fmi2CoSimulation, argv[2], argv[3], &callbacks, fmi2False, fmi2False);
    return c ? fmi2OK : fmi2Error;
  });
  const double amplitude = std::atof(argv[9]);
  for (int i = 10; i < argc; ++i) {
    unsigned reference = 0;
    int value = 0;
    if (std::sscanf(argv[i], "%u=%d", &reference, &value) != 2) return 2;
    counted(instantiating, "fmi2SetInteger", [&] { return set_integer(c, &reference, 1, &value); });
  }
  counted(instantiating, "fmi2EnterInitializationMode", [&] { return enter(c); });
  counted(instantiating, "fmi2ExitInitializationMode", [&] { return leave(c); });

  fmi2FMUstate state = nullptr;
  counted(instantiating, "fmi2GetFMUstate", [&] { return get_state(c, &state); });
  counted(instantiating, "fmi2GetReal",
          [&] { return get_real(c, tunables.data(), tunables.size(), tunable_values.data()); });

  pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
  pthread_mutex_lock(&mutex);
  if (locks == 0) return std::fprintf(stderr, "locks are not counted\n"), 2;
  locks = 0;
  if (prctl(PR_SET_SECCOMP, SECCOMP_MODE_STRICT) != 0) return std::perror("prctl"), 2;

  for (int i = 0; i < steps; ++i) {
    for (std::size_t k = 0; k < inputs.size(); ++k)
      input_values[k] = amplitude * std::sin(0.1 * i + static_cast<double>(k));
    counted(setting, "fmi2SetReal", [&] { return set_real(c, inputs.data(), inputs.size(), input_values.data()); });
    counted(setting, "fmi2SetRealInputDerivatives",
            [&] { return set_derivatives(c, inputs.data(), inputs.size(), orders.data(), input_values.data()); });
    counted(stepping, "fmi2DoStep", [&] { return do_step(c, i * H, H, fmi2True); });
    counted(getting, "fmi2GetReal", [&] { return get_real(c, outputs.data(), outputs.size(), output_values.data()); });
  }
  for (int i = 0; i < 10; ++i) {
    for (double& value : tunable_values) value += 1e-9;
    counted(tuning, "fmi2SetReal",
            [&] { return set_real(c, tunables.data(), tunables.size(), tunable_values.data()); });
    counted(restoring, "fmi2SetFMUstate", [&] { return set_state(c, state); });
  }
  // What usually ends a program makes system calls.
  char text[200];
  const int length = std::snprintf(text, sizeof text,
                                   "instantiate %ld\nset %ld\ndoStep %ld\nget %ld\ntune %ld\nrestore %ld\nlocks %ld\n",
                                   instantiating, setting, stepping, getting, tuning, restoring, locks);
  syscall(SYS_exit, write(STDOUT_FILENO, text, length) == length ? 0 : 1);
}
