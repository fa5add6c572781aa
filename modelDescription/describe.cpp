#include "describe.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <vector>

#include "dependencies.h"
#include "fmi/definition_checksum.h"
#include "fmi/variables.h"
#include "model/json.h"
#include "solve/start/assembly.h"
#include "solve/start/dependent_equations.h"

namespace sigmafmu {
namespace {

using Json = nlohmann::ordered_json;

// The shortest text that reads back as the same number; no negative zero.
std::string number(double x) {
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, x + 0.0).ptr;
  return {buffer, end};
}

void limits(Json& attributes, double min, double max) {
  if (std::isfinite(min)) attributes["min"] = number(min);
  if (std::isfinite(max)) attributes["max"] = number(max);
}

template <typename Uses>
bool any(const std::vector<Port>& variables, const Uses& uses) {
  return std::any_of(variables.begin(), variables.end(), uses);
}

Json describe_units(const std::vector<Port>& variables) {
  Json list = Json::array();
  for (const Unit& u : units()) {
    if (!any(variables, [&](const Port& v) { return v.unit && std::string(v.unit) == u.name; })) continue;
    Json unit = {{"name", u.name}, {"base", Json::object()}, {"displays", Json::array()}};
    const std::pair<const char*, int> exponents[] = {{"kg", u.kg}, {"m", u.m}, {"s", u.s}, {"rad", u.rad}};
    for (auto [name, exponent] : exponents) {
      if (exponent != 0) unit["base"][name] = std::to_string(exponent);
    }
    for (const Unit::Display& d : u.displays)
      unit["displays"].push_back({{"name", d.name}, {"factor", number(d.factor)}});
    list.push_back(std::move(unit));
  }
  return list;
}

// A nominal value is a size, not a measurement: two digits.
double two_digits(double x) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.1e", x);
  return std::strtod(buffer, nullptr);
}

Json describe_types(const std::vector<Port>& variables, const Scales& scales) {
  Json list = Json::array();
  for (const RealType& t : real_types()) {
    if (!any(variables, [&](const Port& v) { return v.type == &t; })) continue;
    Json type = {{"name", t.name}, {"quantity", t.quantity}, {"unit", t.unit}};
    if (t.display_unit) type["displayUnit"] = t.display_unit;
    limits(type, t.min, t.max);
    if (t.nominal && scales.*t.nominal > 0) type["nominal"] = number(two_digits(scales.*t.nominal));
    list.push_back(std::move(type));
  }
  return list;
}

Json describe_enumerations() {
  Json list = Json::array();
  for (const Enumeration& e : enumerations()) {
    Json items = Json::array();
    for (std::size_t i = 0; i < e.items.size(); ++i) {
      items.push_back(
          {{"name", e.items[i].name}, {"value", std::to_string(i + 1)}, {"description", e.items[i].description}});
    }
    list.push_back({{"name", e.name}, {"description", e.description}, {"items", std::move(items)}});
  }
  return list;
}

const char* name(Causality c) {
  switch (c) {
    case Causality::input:
      return "input";
    case Causality::output:
      return "output";
    case Causality::local:
      return "local";
    default:
      return "parameter";
  }
}

const char* name(Variability v) {
  switch (v) {
    case Variability::fixed:
      return "fixed";
    case Variability::tunable:
      return "tunable";
    case Variability::discrete:
      return "discrete";
    default:
      return "continuous";
  }
}

// `attributes` are those of its type in XML.
Json describe_variable(const Port& v, const Mechanism& mechanism) {
  Json attributes = Json::object();
  if (v.enumeration) attributes["declaredType"] = v.enumeration->name;
  if (v.type) {  // what the type says is repeated: many masters look no further than here
    attributes["declaredType"] = v.type->name;
    attributes["unit"] = v.type->unit;
    if (v.type->display_unit) attributes["displayUnit"] = v.type->display_unit;
  }
  limits(attributes, v.min, v.max);
  if (v.is_input()) attributes["start"] = number(v.start);
  if (v.causality == Causality::parameter) attributes["start"] = number(v.value(mechanism));
  return {{"name", v.name},
          {"description", v.description},
          {"causality", name(v.causality)},
          {"variability", name(v.variability)},
          {"type", v.enumeration ? "Enumeration"
                   : v.integer   ? "Integer"
                                 : "Real"},
          {"attributes", std::move(attributes)}};
}

// Numbers of outputs and of the inputs that they depend on, from 1.
Json describe_dependencies(const std::vector<Port>& variables, const Mechanism& mechanism) {
  const auto depends = probe_dependencies(mechanism);
  Json list = Json::array();
  for (std::size_t i = 0; i < variables.size(); ++i) {
    if (variables[i].causality != Causality::output) continue;
    Json output = {{"index", std::to_string(i + 1)}};
    if (!depends.empty()) {  // without a list an output may depend on all inputs
      std::string inputs;
      for (std::size_t j = 0; j < variables.size(); ++j) {
        if (depends[i][j]) inputs += (inputs.empty() ? "" : " ") + std::to_string(j + 1);
      }
      output["dependencies"] = std::move(inputs);
    }
    list.push_back(std::move(output));
  }
  return list;
}

// What variables belong to, and which of them other FMUs connect to.
Json describe_elements(const Variables& variables) {
  Json list = Json::array();
  for (const Owner& owner : variables.owners) {
    list.push_back({{"name", owner.name},
                    {"kind", owner.kind},
                    {"type", owner.type},
                    {"terminal", owner.terminal},
                    {"variables", Json::array()},
                    {"members", Json::array()}});
  }
  for (const Port& v : variables.list) {
    Json& element = list[static_cast<std::size_t>(v.owner)];
    element["variables"].push_back(v.name);
    if (v.in_terminal) element["members"].push_back(v.name);
  }
  return list;
}

std::string describe_freedom(const Mechanism& mechanism) {
  const Freedom f = initial_freedom(mechanism.multibody);
  if (f.degrees() == 0 && mechanism.multibody.drives.empty())
    throw std::runtime_error(mechanism.name + " cannot move: degrees of freedom: " + summary(f));
  return summary(f);
}

}  // namespace

std::string describe(Mechanism mechanism) {
  validate(mechanism);
  const std::string definition = to_json(mechanism);
  find_joint_values(mechanism.multibody);
  const Variables variables =
      make_variables(mechanism, System(mechanism.multibody, find_compliance(mechanism.multibody)));
  Json list = Json::array();
  for (const Port& v : variables.list) list.push_back(describe_variable(v, mechanism));
  const Json description = {
      {"name", mechanism.name},
      {"description", mechanism.description},
      {"generationTool", "sigmafmu " SIGMAFMU_VERSION},
      {"version", SIGMAFMU_VERSION},
      {"degreesOfFreedom", describe_freedom(mechanism)},
      // The tolerance that a master passes on is the start value of the tolerances, so that it changes nothing.
      {"experiment",
       {{"startTime", number(0)},
        {"stopTime", number(mechanism.stop_time)},
        {"tolerance", number(mechanism.integrator.error_tolerance)},
        {"stepSize", number(mechanism.communication_step)}}},
      {"units", describe_units(variables.list)},
      {"types", describe_types(variables.list, scales(mechanism.multibody))},
      {"enumerations", describe_enumerations()},
      {"variables", std::move(list)},
      {"outputs", describe_dependencies(variables.list, mechanism)},
      {"elements", describe_elements(variables)},
      {"checksums",
       {{"variables", variables_checksum(variables.list)}, {"definition", definition_checksum(mechanism)}}},
      {"mechanism", definition},  // the text of mechanism.json
  };
  return description.dump(1) + "\n";
}

}  // namespace sigmafmu
