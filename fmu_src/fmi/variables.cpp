#include "fmi/variables.h"

#include <algorithm>
#include <stdexcept>

#include "text/checksum.h"
#include "text/glob.h"

namespace sigmafmu {
namespace {

const State& state(const View& view) { return static_cast<const SlaveView&>(view).state; }

template <typename Row>
int row_of(const std::vector<Row>& table, const std::string& name) {
  for (std::size_t i = 0; i < table.size(); ++i) {
    if (table[i].name == name) return static_cast<int>(i);
  }
  throw std::logic_error("no row " + name);
}

void integrator_ports(Ports& ports) {
  ports.owner("integrator", "", "");
  const std::string n = "integrator.";
  auto real = [&](const char* name, const char* type, const char* description) {
    const int row = row_of(real_settings(), name);
    const RealSetting& setting = real_settings()[row];
    Port& v = ports.parameter(
        row, n + name, type, description,
        [](Mechanism& m, int o, int, int) -> double& { return m.integrator.*real_settings()[o].value; },
        Variability::fixed);
    v.min = setting.min;
    v.max = setting.max;
    v.above_min = setting.above_min;
  };
  real("stepSize", "Time", "Largest internal step");
  real("spectralRadius", "Fraction", "Spectral radius at infinite frequency: 1 no damping, 0 strongest");
  real("sigma", "Number", "Sigma modification: 0 geom1, 1 tangent-free, any real value");
  real("absoluteTolerance", "Tolerance",
       "Allowed velocity increment of Newton's method, error of a step of rkmk54 (m/s and rad/s)");
  real("relativeTolerance", "Tolerance", "The same, relative to a body's velocity");
  real("errorTolerance", "Tolerance",
       "With stepControl error: allowed position error of an internal step, relative to the mechanism's size; of "
       "rotations in rad");

  auto integer = [&](const char* name, const char* description) {
    const int row = row_of(integer_settings(), name);
    const IntegerSetting& setting = integer_settings()[row];
    Port& v = ports.add(n + name, nullptr, description);
    v.causality = Causality::parameter;
    v.variability = Variability::fixed;
    v.integer = true;
    v.object = row;
    v.option = [](Mechanism& m, int o) -> int& { return m.integrator.*integer_settings()[o].value; };
    v.min = setting.min;
    v.max = setting.max;
    v.enumeration = setting.enumeration;
  };
  integer("maxNewtonIterations", "Newton iterations in one attempt at an internal step");
  integer("maxHalvings",
          "How often an internal step that fails is halved before fmi2DoStep gives up; 0 bounds the time of a step");
  for (const IntegerSetting& setting : integer_settings()) {
    if (setting.enumeration) integer(setting.name, setting.enumeration->description);
  }

  ports.output(
      0, n + "errorEstimate", "Estimate",
      "Estimated position error of the last internal step, relative to the mechanism's size; of rotations in rad",
      [](const View& v, int, int, double* x) { *x = state(v).error; });
  ports.output(0, n + "largestErrorEstimate", "Estimate", "Largest estimate of all internal steps since the start",
               [](const View& v, int, int, double* x) { *x = state(v).largest_error; });

  auto counter = [&](const char* name, const char* description, Ports::Output output) {
    Port& v = ports.output(0, n + name, nullptr, description, output);
    v.causality = Causality::local;  // some importers read every output as Real
    v.integer = true;
    v.variability = Variability::discrete;
  };
  counter("steps", "Internal steps since the start",
          [](const View& v, int, int, double* x) { *x = static_cast<double>(state(v).counters.steps); });
  counter("newtonIterations", "Newton iterations since the start (rkmk: of projections)",
          [](const View& v, int, int, double* x) { *x = static_cast<double>(state(v).counters.newton_iterations); });
  counter("jacobianEvaluations", "Matrices factorized since the start",
          [](const View& v, int, int, double* x) { *x = static_cast<double>(state(v).counters.jacobian_evaluations); });
  counter("retries", "Internal steps repeated with half the step since the start",
          [](const View& v, int, int, double* x) { *x = static_cast<double>(state(v).counters.retries); });
}

// Whether the FMU has a variable.
class Exposure {
 public:
  Exposure(const Mechanism& mechanism, const std::vector<Owner>& owners)
      : chosen_(mechanism.expose),
        owners_(owners),
        small_(static_cast<int>(mechanism.multibody.bodies.size()) <= kFewBodies) {}

  bool operator()(const Port& port) const {
    if (!chosen_) return small_ || owners_[port.owner].kind != "body";
    switch (port.causality) {
      case Causality::input:
        return matches(chosen_->inputs, port.name);
      case Causality::parameter:
        return matches(chosen_->parameters, port.name);
      default:
        return matches(chosen_->outputs, port.name);
    }
  }

 private:
  static constexpr int kFewBodies = 20;

  static bool matches(const std::vector<std::string>& patterns, const std::string& name) {
    const std::string vector = name.substr(0, name.find('['));
    return std::any_of(patterns.begin(), patterns.end(), [&](const std::string& pattern) {
      return pattern == name || glob_matches(pattern, name) || glob_matches(pattern, vector);
    });
  }

  const std::optional<ExposureDef>& chosen_;
  const std::vector<Owner>& owners_;
  const bool small_;
};

}  // namespace

Variables make_all_variables(const Mechanism& mechanism, const System& system) {
  Ports ports(mechanism, system);
  for (int i = 0; i < system.body_count(); ++i) body_ports(ports, i);
  for (int j = 0; j < system.joint_count(); ++j) joint_ports(ports, j);
  for (int d = 0; d < system.drive_count(); ++d) drive_ports(ports, d);
  for (int c = 0; c < system.coupling_count(); ++c) coupling_ports(ports, c);
  for (std::size_t m = 0; m < mechanism.multibody.motions.size(); ++m) motion_ports(ports, static_cast<int>(m));
  force_ports(ports);
  for (std::size_t s = 0; s < mechanism.stations.size(); ++s) station_ports(ports, static_cast<int>(s));
  for (std::size_t s = 0; s < mechanism.sensors.size(); ++s) sensor_ports(ports, static_cast<int>(s));
  system_ports(ports);
  integrator_ports(ports);
  std::vector<Owner> owners = ports.owners();
  return {ports.take(), std::move(owners)};
}

Variables make_variables(const Mechanism& mechanism, const System& system) {
  Variables all = make_all_variables(mechanism, system);
  const Exposure exposed(mechanism, all.owners);
  const auto hidden = [&](const Port& port) { return !exposed(port); };
  all.list.erase(std::remove_if(all.list.begin(), all.list.end(), hidden), all.list.end());
  return all;
}

std::string variables_checksum(const std::vector<Port>& variables) {
  std::uint64_t sum = kNoChecksum;
  for (const Port& v : variables) {
    const char* type = v.enumeration ? v.enumeration->name : v.type ? v.type->name : "";
    for (const std::string& word : {v.name, std::string(type), std::to_string(static_cast<int>(v.causality)),
                                    std::to_string(static_cast<int>(v.variability))}) {
      sum = checksum(word + "\n", sum);
    }
  }
  return hexadecimal(sum);
}

}  // namespace sigmafmu
