// A mechanism as its FMU runs it, in sigmafmu._core.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "fmi/slave.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace sigmafmu;

namespace {

struct PySlave final : Listener {
  explicit PySlave(const Mechanism& mechanism) : slave(mechanism, "", this) {
    for (unsigned i = 0; i < slave.variables().size(); ++i) references[slave.variables()[i].name] = i;
  }
  PySlave(const PySlave&) = delete;
  PySlave& operator=(const PySlave&) = delete;

  void warning(const char* text) noexcept override { messages.emplace_back(text); }
  void event(const char* text) noexcept override { messages.emplace_back(text); }
  bool wants_events() const noexcept override { return true; }

  std::pair<unsigned, bool> reference(const std::string& name) const {
    const auto found = references.find(name);
    if (found == references.end()) throw std::invalid_argument("there is no variable " + name);
    return {found->second, slave.variables()[found->second].integer};
  }
  double get(const std::string& name) {
    const auto [r, integer] = reference(name);
    double value;
    slave.get(&r, 1, integer, &value);
    return value;
  }
  void set(const std::string& name, double value) {
    const auto [r, integer] = reference(name);
    slave.set(&r, 1, integer, &value);
  }
  void set_input_derivative(const std::string& name, int order, double value) {
    const unsigned r = reference(name).first;
    slave.set_input_derivatives(&r, 1, &order, &value);
  }
  double directional_derivative(const std::string& output, const std::string& input) {
    const unsigned of = reference(output).first, by = reference(input).first;
    const double direction = 1.0;
    double result;
    slave.directional_derivative(&of, 1, &by, 1, &direction, &result);
    return result;
  }
  std::vector<double> outputs() {
    std::vector<double> values;
    for (const Port& v : slave.variables()) {
      if (v.output) values.push_back(get(v.name));
    }
    return values;
  }
  std::vector<std::string> names() const {
    std::vector<std::string> result;
    for (const Port& v : slave.variables()) result.push_back(v.name);
    return result;
  }
  void start() {
    slave.enter_initialization();
    slave.exit_initialization();
  }
  void do_step(double t, double H) {
    if (slave.phase() != Phase::step) throw std::runtime_error("the slave has not been started");
    if (!slave.do_step(t, H)) throw std::runtime_error(slave.message());
  }

  std::vector<std::string> messages;
  std::map<std::string, unsigned> references;
  Slave slave;
};

}  // namespace

void bind_slave(nb::module_& m) {
  nb::class_<PySlave>(m, "Slave", "A mechanism as its FMU runs it, by the names of the FMU's variables.")
      .def(nb::init<const Mechanism&>())
      .def_prop_ro("names", &PySlave::names)
      .def_ro("messages", &PySlave::messages, "Warnings and events so far.")
      .def("get", &PySlave::get, "name"_a)
      .def("set", &PySlave::set, "name"_a, "value"_a)
      .def("set_input_derivative", &PySlave::set_input_derivative, "name"_a, "order"_a, "value"_a)
      .def("directional_derivative", &PySlave::directional_derivative, "output"_a, "input"_a)
      .def("outputs", &PySlave::outputs, "All that is calculated, in the order of the names.")
      .def("start", &PySlave::start, "Initialization, with the parameters set so far.")
      .def("do_step", &PySlave::do_step, "t"_a, "H"_a);
}
