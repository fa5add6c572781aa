// A co-simulation master in sigmafmu._core.
#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>

#include <chrono>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <thread>

namespace nb = nanobind;
using namespace nb::literals;

namespace {

// A master in C++, given the addresses of an instantiated FMU's fmi2DoStep and component: n communication steps of H,
// without Python in between. With a period > 0 step i starts at i periods of the wall clock, or late if the one before
// took longer. `start` is when the first is due by CLOCK_MONOTONIC, which Python's time.monotonic() reads as well; 0:
// at once. Returns per step when it started after its time and how long it took [s].
using Steps = Eigen::Matrix<double, Eigen::Dynamic, 2>;
Steps do_steps(std::uintptr_t do_step, std::uintptr_t component, double t0, double H, int n, double period,
               double start_at) {
  using clock = std::chrono::steady_clock;
  using seconds = std::chrono::duration<double>;
  if (do_step == 0 || component == 0) throw std::invalid_argument("do_step and component must be addresses");
  if (n < 0) throw std::invalid_argument("n is " + std::to_string(n) + "; it must not be negative");
  constexpr double kLongest = 1e8;  // what a clock can count [s]
  if (!(start_at >= 0 && start_at <= kLongest)) {
    throw std::invalid_argument("start is " + std::to_string(start_at) + " s; it must be 0 to 1e8 s");
  }
  if (!(period >= 0) || !(n * period <= kLongest)) {
    throw std::invalid_argument("period is " + std::to_string(period) +
                                " s; it must not be negative, n periods at most 1e8 s");
  }
  // Python knows addresses as numbers.
  const auto call =
      reinterpret_cast<int (*)(void*, double, double, int)>(do_step);  // NOLINT(performance-no-int-to-ptr)
  void* const instance = reinterpret_cast<void*>(component);           // NOLINT(performance-no-int-to-ptr)
  constexpr seconds kSpin(2e-4);  // sleeping is not exact: the last stretch is waited actively
  Steps result(n, 2);
  const auto start =
      start_at > 0 ? clock::time_point(std::chrono::duration_cast<clock::duration>(seconds(start_at))) : clock::now();
  for (int i = 0; i < n; ++i) {
    auto due = clock::now();
    if (period > 0) {
      due = start + std::chrono::duration_cast<clock::duration>(seconds(i * period));
      std::this_thread::sleep_until(due - std::chrono::duration_cast<clock::duration>(kSpin));
      while (clock::now() < due) {
      }
    }
    const auto begin = clock::now();
    if (call(instance, t0 + i * H, H, 1) != 0) {
      throw std::runtime_error("fmi2DoStep failed in step " + std::to_string(i));
    }
    result(i, 0) = seconds(begin - due).count();
    result(i, 1) = seconds(clock::now() - begin).count();
  }
  return result;
}

}  // namespace

void bind_master(nb::module_& m) {
  m.def("do_steps", &do_steps, nb::call_guard<nb::gil_scoped_release>(), "do_step"_a, "component"_a, "t0"_a, "H"_a,
        "n"_a, "period"_a = 0.0, "start"_a = 0.0, "(n, 2): delay of the start and duration [s] of every fmi2DoStep.");
}
