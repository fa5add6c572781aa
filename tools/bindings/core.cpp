// Python module sigmafmu._core: the integrator core without an FMU around it, for tests and studies.
#include <nanobind/nanobind.h>

namespace nb = nanobind;

// Each in the file of its name.
void bind_lie(nb::module_& lie);
void bind_definitions(nb::module_& m);
void bind_system(nb::module_& m);
void bind_outputs(nb::module_& m);
void bind_simulation(nb::module_& m);
void bind_slave(nb::module_& m);
void bind_solve(nb::module_& m);
void bind_master(nb::module_& m);

NB_MODULE(_core, m) {  // NOLINT(bugprone-signed-bitwise): in nanobind's macro
  m.doc() = "Core of sigmafmu: Lie group functions, equations of motion, integrator.";
  nb::set_leak_warnings(false);
  auto lie = m.def_submodule("lie", "SO(3) and R^3 x SO(3).");
  bind_lie(lie);
  bind_definitions(m);
  bind_system(m);
  bind_outputs(m);
  bind_simulation(m);
  bind_slave(m);
  bind_solve(m);
  bind_master(m);
}
