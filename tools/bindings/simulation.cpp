// The integrator of sigmafmu._core.
#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <memory>
#include <stdexcept>
#include <string>

#include "integrator/integrator.h"
#include "integrator/methods/spin_sigma.h"
#include "model/mechanism.h"
#include "solve/start/assembly.h"
#include "solve/start/dependent_equations.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace sigmafmu;

namespace {

// One mechanism with its integrator and state. Settings may go beyond the limits that an FMU has for them.
struct PySimulation {
  explicit PySimulation(const Mechanism& m)
      : mechanism((validate(m.multibody), m)),
        system(mechanism.multibody, find_compliance(mechanism.multibody)),
        solver(system, plans),
        integrator(system, mechanism.integrator, plans),
        state(integrator.make_state()),
        input(system.make_signal()) {
    start_prescribed(mechanism.multibody, system, input);
    assemble(mechanism.multibody, system, solver, state.q, state.v);
    state.turned = coordinates_at_start(mechanism.multibody, system, state.q);
    mesh_couplings(mechanism.multibody, state.turned, input);
    start();
  }
  void start() {
    if (!integrator.initialize(state, input)) throw std::runtime_error("no consistent accelerations");
  }
  // `steps` internal steps of h.
  void advance(double h, int steps) {
    for (int i = 0; i < steps; ++i) {
      StepFailure failure;
      if (!integrator.step(state, h, input, failure)) {
        throw std::runtime_error("step failed at t = " + std::to_string(failure.time));
      }
    }
  }
  // `steps` equal internal steps up to t_end.
  void run(double t_end, int steps) {
    const double length = t_end - state.time, elapsed = state.elapsed + length;
    advance(length / steps, steps);
    state.time = t_end;
    state.elapsed = elapsed;
  }
  // Positions, velocities and multipliers after each of `steps` steps: arrays (steps + 1) x size.
  nb::tuple trajectory(double t_end, int steps) {
    if (steps < 0) throw std::invalid_argument("steps is " + std::to_string(steps) + "; it must not be negative");
    using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Rows q(steps + 1, state.q.size()), v(steps + 1, state.v.size()), lambda(steps + 1, state.lambda.size());
    VectorXd t(steps + 1);
    const double t0 = state.time;
    for (int i = 0; i <= steps; ++i) {
      if (i > 0) run(t0 + (t_end - t0) * i / steps, 1);
      t[i] = state.time, q.row(i) = state.q, v.row(i) = state.v, lambda.row(i) = state.lambda;
    }
    return nb::make_tuple(t, q, v, lambda);
  }
  void set_input(const VectorXd& u0, const VectorXd& u1, double t0) {
    if (u0.size() != system.input_size() || u1.size() != system.input_size()) {
      throw std::invalid_argument("an input vector has the wrong size");
    }
    Inputs before = system.make_inputs(), after = before;
    VectorXd vdot_before, vdot_after, lambda;
    input.value(state.elapsed, state.turned, before);
    state.elapsed = state.time - t0;
    input.start = before.time - state.elapsed;
    input.derivative[0] = u0;
    input.derivative[1] = u1;
    input.drive[0] = before.x - state.elapsed * before.xdot + (0.5 * state.elapsed * state.elapsed) * before.xddot;
    input.drive[1] = before.xdot - state.elapsed * before.xddot;
    input.value(state.elapsed, state.turned, after);
    if (after.u == before.u) return;
    if (!solver.accelerations(state.q, state.v, before, vdot_before, lambda) ||
        !solver.accelerations(state.q, state.v, after, vdot_after, lambda)) {
      throw std::runtime_error("no consistent accelerations");
    }
    integrator.shift_accelerations(state, vdot_after - vdot_before);
  }

  Mechanism mechanism;
  System system;
  KktPlans plans;
  ConsistentSolver solver;
  Integrator integrator;
  State state;
  InputSignal input;
};

}  // namespace

void bind_simulation(nb::module_& m) {
  nb::class_<AlphaParameters>(m, "AlphaParameters")
      .def(nb::init<double>(), "spectral_radius"_a)
      .def_ro("alpha_m", &AlphaParameters::alpha_m)
      .def_ro("alpha_f", &AlphaParameters::alpha_f)
      .def_ro("beta", &AlphaParameters::beta)
      .def_ro("gamma", &AlphaParameters::gamma);

  m.def(
      "spin_sigma",
      [](const MultibodyDef& d, const IntegratorSettings& settings, int body, const Vector3d& w, const Vector3d& wdot,
         double h) {
        const System system((validate(d), d));
        if (body < 0 || body >= system.body_count()) throw std::invalid_argument("there is no such body");
        return SpinSigma(system, settings)(body, w, wdot, h);
      },
      "multibody"_a, "settings"_a, "body"_a, "w"_a, "wdot"_a, "h"_a,
      "sigma that sigma_mode 2 (spinOptimal) gives a body for a step of h [s] that starts with angular velocity w "
      "[rad/s] and its derivative wdot [rad/s2], both in body axes.");

  nb::class_<StepCounters>(m, "StepCounters")
      .def_ro("steps", &StepCounters::steps)
      .def_ro("newton_iterations", &StepCounters::newton_iterations)
      .def_ro("jacobian_evaluations", &StepCounters::jacobian_evaluations)
      .def_ro("retries", &StepCounters::retries);
  nb::class_<State>(m, "State", "Plain value; copy it to save, assign it to restore.")
      .def("__copy__", [](const State& s) { return State(s); })
      .def_rw("time", &State::time)
      .def_rw("q", &State::q)
      .def_rw("v", &State::v)
      .def_rw("vdot", &State::vdot)
      .def_rw("a", &State::a)
      .def_rw("lambda_", &State::lambda)
      .def_ro("turned", &State::turned)
      .def_ro("error", &State::error)
      .def_ro("largest_error", &State::largest_error)
      .def_ro("counters", &State::counters);
  nb::class_<PySimulation>(m, "Simulation", "A mechanism, assembled at its initial values, and its integrator.")
      .def(nb::init<const Mechanism&>())
      .def_rw("state", &PySimulation::state)
      .def("start", &PySimulation::start, "Consistent accelerations at the present q, v.")
      .def("advance", &PySimulation::advance, "h"_a, "steps"_a, "`steps` internal steps of h [s].")
      .def("run", &PySimulation::run, "t_end"_a, "steps"_a)
      .def("trajectory", &PySimulation::trajectory, "t_end"_a, "steps"_a, "(t, q, v, lambda)")
      .def("set_input", &PySimulation::set_input, "u0"_a, "u1"_a, "t0"_a);
}
