// The outputs of an FMU in sigmafmu._core.
#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "fmi/variables.h"
#include "solve/index1.h"
#include "solve/start/assembly.h"
#include "solve/start/dependent_equations.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace sigmafmu;

namespace {

// The real outputs of a mechanism's FMU as functions of (q, v, u).
struct PyOutputs {
  explicit PyOutputs(const Mechanism& m)
      : mechanism((validate(m), m)),
        system(m.multibody, find_compliance(m.multibody)),
        solver(system),
        inputs_(inputs_at_start(m.multibody, system)),
        e(system.make_evaluation()) {
    for (const Port& v : make_variables(m, system).list) {
      if (v.output && !v.integer) variables.push_back(v);
      if (v.is_input()) inputs.push_back(v.name);
    }
  }
  VectorXd values(const VectorXd& q, const VectorXd& v, const VectorXd& u, const std::optional<VectorXd>& turned) {
    inputs_.turned = turned.value_or(VectorXd::Zero(system.coordinate_count()));
    if (inputs_.turned.size() != system.coordinate_count()) throw std::invalid_argument("turned has the wrong size");
    VectorXd vdot(system.velocity_size()), lambda(system.constraint_size());
    inputs_.u = u;
    if (!solver.accelerations(q, v, inputs_, vdot, lambda)) {
      throw std::runtime_error(solver.singular() ? describe_singularity(mechanism.multibody, system, q)
                                                 : "a value overflows");
    }
    system.evaluate(q, v, inputs_, e);
    const SlaveView view{{mechanism, system, q, v, inputs_, e, vdot, lambda}, state};
    VectorXd y(static_cast<Eigen::Index>(variables.size()));
    OutputValues output(variables);
    for (std::size_t i = 0; i < variables.size(); ++i) y[static_cast<Eigen::Index>(i)] = output(variables[i], view);
    return y;
  }
  // Of the outputs that may jump, their continuous derivatives along the motion v, and which ones these are.
  VectorXd rates(const VectorXd& q, const VectorXd& v) {
    const VectorXd vdot = VectorXd::Zero(system.velocity_size()), lambda = VectorXd::Zero(system.constraint_size());
    system.evaluate(q, v, inputs_, e);
    const SlaveView view{{mechanism, system, q, v, inputs_, e, vdot, lambda}, state};
    const std::vector<int> chosen = jumping();
    VectorXd y(static_cast<Eigen::Index>(chosen.size()));
    for (Eigen::Index i = 0; i < y.size(); ++i) {
      const Port& variable = variables[chosen[i]];
      y[i] = variable.rate(view, variable.object, variable.component);
    }
    return y;
  }
  std::vector<int> jumping() const {
    std::vector<int> result;
    for (std::size_t i = 0; i < variables.size(); ++i) {
      if (variables[i].rate) result.push_back(static_cast<int>(i));
    }
    return result;
  }
  std::vector<int> powers() const {
    std::vector<int> result;
    for (std::size_t i = 0; i < variables.size(); ++i) {
      if (variables[i].times_velocity) result.push_back(static_cast<int>(i));
    }
    return result;
  }
  std::vector<std::string> names() const {
    std::vector<std::string> result;
    result.reserve(variables.size());
    for (const Port& v : variables) result.push_back(v.name);
    return result;
  }

  Mechanism mechanism;
  System system;
  ConsistentSolver solver;
  Inputs inputs_;
  Evaluation e;
  State state;
  std::vector<Port> variables;
  std::vector<std::string> inputs;
};

}  // namespace

void bind_outputs(nb::module_& m) {
  nb::class_<PyOutputs>(m, "Outputs", "Real outputs of a mechanism's FMU as functions of (q, v, u).")
      .def(nb::init<const Mechanism&>())
      .def_prop_ro("names", &PyOutputs::names)
      .def_ro("inputs", &PyOutputs::inputs, "Names of the entries of u.")
      .def("values", &PyOutputs::values, "q"_a, "v"_a, "u"_a, "turned"_a = nb::none(),
           "Angles are those nearest to `turned`, one for each coordinate of a joint; default: zero.")
      .def_prop_ro("jumping", &PyOutputs::jumping, "Indices of the outputs that may jump while the mechanism does not.")
      .def_prop_ro("powers", &PyOutputs::powers, "Indices of the outputs that depend on u as velocities tell.")
      .def("rates", &PyOutputs::rates, "q"_a, "v"_a, "Derivatives of these along v.");
}
