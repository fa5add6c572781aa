// write_model_description MODEL FOLDER RESOURCES SOURCE...: writes modelDescription.xml of a mechanism, with an empty
// GUID, mechanism.json, the mechanism itself, and elements.json, what its variables belong to, into FOLDER. Its modal
// data are in the folder RESOURCES. The SOURCEs are the files to compile, as they are named in the FMU's folder
// `sources`.
#include <tinyxml2.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <string>

#include "dependencies.h"
#include "fmi/variables.h"
#include "model/json.h"
#include "model/mechanisms.h"
#include "model/modal_file.h"
#include "multibody/input_signal.h"
#include "solve/start/assembly.h"
#include "solve/start/dependent_equations.h"

namespace {

using namespace sigmafmu;
using tinyxml2::XMLElement;

// The shortest text that reads back as the same number; no negative zero.
std::string text(double x) {
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, x + 0.0).ptr;
  return {buffer, end};
}

void set(XMLElement* e, const char* name, const std::string& value) { e->SetAttribute(name, value.c_str()); }
void set(XMLElement* e, const char* name, double value) { set(e, name, text(value)); }

void write_units(XMLElement* root, const std::vector<Port>& variables) {
  XMLElement* definitions = root->InsertNewChildElement("UnitDefinitions");
  for (const Unit& u : units()) {
    const auto measured = [&](const Port& v) { return v.unit && std::string(v.unit) == u.name; };
    if (std::none_of(variables.begin(), variables.end(), measured)) continue;
    XMLElement* unit = definitions->InsertNewChildElement("Unit");
    set(unit, "name", u.name);
    XMLElement* base = unit->InsertNewChildElement("BaseUnit");
    const std::pair<const char*, int> exponents[] = {{"kg", u.kg}, {"m", u.m}, {"s", u.s}, {"rad", u.rad}};
    for (auto [name, exponent] : exponents) {
      if (exponent != 0) base->SetAttribute(name, exponent);
    }
    for (const Unit::Display& d : u.displays) {
      XMLElement* display = unit->InsertNewChildElement("DisplayUnit");
      set(display, "name", d.name);
      set(display, "factor", d.factor);
    }
  }
}

// A nominal value is a size, not a measurement: two digits.
double two_digits(double x) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.1e", x);
  return std::strtod(buffer, nullptr);
}

void write_types(XMLElement* root, const std::vector<Port>& variables, const Scales& scales) {
  XMLElement* definitions = root->InsertNewChildElement("TypeDefinitions");
  for (const RealType& t : real_types()) {
    if (std::none_of(variables.begin(), variables.end(), [&](const Port& v) { return v.type == &t; })) continue;
    XMLElement* type = definitions->InsertNewChildElement("SimpleType");
    set(type, "name", t.name);
    XMLElement* real = type->InsertNewChildElement("Real");
    set(real, "quantity", t.quantity);
    set(real, "unit", t.unit);
    if (t.display_unit) set(real, "displayUnit", t.display_unit);
    if (std::isfinite(t.min)) set(real, "min", t.min);
    if (std::isfinite(t.max)) set(real, "max", t.max);
    if (t.nominal && scales.*t.nominal > 0) set(real, "nominal", two_digits(scales.*t.nominal));
  }
  for (const Enumeration& e : enumerations()) {
    XMLElement* type = definitions->InsertNewChildElement("SimpleType");
    set(type, "name", e.name);
    set(type, "description", e.description);
    XMLElement* enumeration = type->InsertNewChildElement("Enumeration");
    for (std::size_t i = 0; i < e.items.size(); ++i) {
      XMLElement* item = enumeration->InsertNewChildElement("Item");
      set(item, "name", e.items[i].name);
      item->SetAttribute("value", static_cast<int>(i + 1));
      set(item, "description", e.items[i].description);
    }
  }
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

void write_variable(XMLElement* parent, const Port& v, unsigned reference, const Mechanism& mechanism) {
  XMLElement* scalar = parent->InsertNewChildElement("ScalarVariable");
  set(scalar, "name", v.name);
  scalar->SetAttribute("valueReference", reference);
  set(scalar, "description", v.description);
  set(scalar, "causality", name(v.causality));
  set(scalar, "variability", name(v.variability));
  set(scalar, "initial", v.output ? "calculated" : "exact");
  if (v.is_input()) scalar->DeleteAttribute("initial");  // inputs must not have it

  XMLElement* type = scalar->InsertNewChildElement(v.enumeration ? "Enumeration" : v.integer ? "Integer" : "Real");
  if (v.enumeration) set(type, "declaredType", v.enumeration->name);
  if (v.type) {  // what the type says is repeated: many masters look no further than here
    set(type, "declaredType", v.type->name);
    set(type, "unit", v.type->unit);
    if (v.type->display_unit) set(type, "displayUnit", v.type->display_unit);
  }
  if (std::isfinite(v.min)) set(type, "min", v.min);
  if (std::isfinite(v.max)) set(type, "max", v.max);
  if (v.is_input()) set(type, "start", v.start);
  if (v.causality == Causality::parameter) set(type, "start", v.value(mechanism));
}

void write_structure(XMLElement* root, const std::vector<Port>& variables, const Mechanism& mechanism) {
  const auto depends = probe_dependencies(mechanism);
  XMLElement* structure = root->InsertNewChildElement("ModelStructure");
  XMLElement* outputs = structure->InsertNewChildElement("Outputs");
  XMLElement* initial = structure->InsertNewChildElement("InitialUnknowns");
  for (std::size_t i = 0; i < variables.size(); ++i) {
    if (variables[i].causality != Causality::output) continue;
    XMLElement* output = outputs->InsertNewChildElement("Unknown");
    output->SetAttribute("index", static_cast<unsigned>(i + 1));
    if (!depends.empty()) {  // without a list an output may depend on all inputs
      std::string list;
      for (std::size_t j = 0; j < variables.size(); ++j) {
        if (depends[i][j]) list += (list.empty() ? "" : " ") + std::to_string(j + 1);
      }
      set(output, "dependencies", list);
    }
    // No list here: after projection and consistent accelerations an initial value depends on all parameters.
    initial->InsertNewChildElement("Unknown")->SetAttribute("index", static_cast<unsigned>(i + 1));
  }
}

// Degrees of freedom, for the reader of the build's output and for `sigmafmu info`. Throws when nothing can move.
void write_freedom(XMLElement* root, const Mechanism& mechanism) {
  const Freedom f = initial_freedom(mechanism.multibody);
  std::printf("%s: degrees of freedom: %s\n", mechanism.name.c_str(), summary(f).c_str());
  if (f.degrees() == 0 && mechanism.multibody.drives.empty())
    throw std::runtime_error(mechanism.name + " cannot move: degrees of freedom: " + summary(f));
  XMLElement* tool = root->InsertNewChildElement("VendorAnnotations")->InsertNewChildElement("Tool");
  set(tool, "name", "sigmafmu");
  set(tool->InsertNewChildElement("DegreesOfFreedom"), "value", summary(f));
}

void write(const Mechanism& mechanism, const Variables& of_mechanism, const std::string& file,
           const std::vector<const char*>& sources) {
  const std::vector<Port>& variables = of_mechanism.list;

  tinyxml2::XMLDocument document;
  document.InsertEndChild(document.NewDeclaration());
  XMLElement* root = document.NewElement("fmiModelDescription");
  document.InsertEndChild(root);
  set(root, "fmiVersion", "2.0");
  set(root, "modelName", mechanism.name);
  set(root, "guid", "");
  set(root, "description", mechanism.description);
  set(root, "author", "sigmafmu authors");
  set(root, "version", SIGMAFMU_VERSION);
  set(root, "license", "BSD-3-Clause");
  set(root, "generationTool", "sigmafmu " SIGMAFMU_VERSION);
  set(root, "variableNamingConvention", "structured");
  root->SetAttribute("numberOfEventIndicators", 0);

  XMLElement* capabilities = root->InsertNewChildElement("CoSimulation");
  set(capabilities, "modelIdentifier", mechanism.name);
  for (const char* yes : {"canHandleVariableCommunicationStepSize", "canInterpolateInputs"}) {
    capabilities->SetAttribute(yes, true);
  }
  capabilities->SetAttribute("maxOutputDerivativeOrder", 1);
  for (const char* yes : {"canGetAndSetFMUstate", "canSerializeFMUstate", "providesDirectionalDerivative",
                          "canNotUseMemoryManagementFunctions"}) {
    capabilities->SetAttribute(yes, true);
  }
  XMLElement* files = capabilities->InsertNewChildElement("SourceFiles");
  for (const char* source : sources) set(files->InsertNewChildElement("File"), "name", source);

  write_units(root, variables);
  write_types(root, variables, scales(mechanism.multibody));
  XMLElement* categories = root->InsertNewChildElement("LogCategories");
  const std::pair<const char*, const char*> all[] = {
      {"logStatusError", "Refused calls and failed computations"},
      {"logStatusDiscard", "Communication steps that could not be finished"},
      {"logStatusWarning", "Settings that deserve a second thought"},
      {"logEvents", "Repeated internal steps"},
  };
  for (auto [category, description] : all) {
    XMLElement* e = categories->InsertNewChildElement("Category");
    set(e, "name", category);
    set(e, "description", description);
  }
  XMLElement* experiment = root->InsertNewChildElement("DefaultExperiment");
  set(experiment, "startTime", 0.0);
  set(experiment, "stopTime", mechanism.stop_time);
  // What a master that passes it on asks for: the start values of the tolerances, so that it changes nothing.
  set(experiment, "tolerance", mechanism.integrator.error_tolerance);
  set(experiment, "stepSize", mechanism.communication_step);
  write_freedom(root, mechanism);

  XMLElement* list = root->InsertNewChildElement("ModelVariables");
  for (unsigned i = 0; i < variables.size(); ++i) write_variable(list, variables[i], i, mechanism);
  write_structure(root, variables, mechanism);

  if (document.SaveFile(file.c_str()) != tinyxml2::XML_SUCCESS) throw std::runtime_error("cannot write " + file);
}

// Which variables belong to which element, and which of them other FMUs connect to: what the FMU's documentation and
// terminals are made from. Names have no character that JSON escapes.
void write_elements(const Variables& variables, const std::string& file) {
  std::ofstream stream(file, std::ios::binary);
  const char* comma = "";
  stream << "[";
  for (std::size_t i = 0; i < variables.owners.size(); ++i) {
    const Owner& owner = variables.owners[i];
    stream << comma << "\n  {\"name\": \"" << owner.name << "\", \"kind\": \"" << owner.kind << "\", \"type\": \""
           << owner.type << "\", \"terminal\": \"" << owner.terminal << '"';
    for (const bool members : {false, true}) {
      stream << ",\n   \"" << (members ? "members" : "variables") << "\": [";
      comma = "";
      for (const Port& v : variables.list) {
        if (v.owner != static_cast<int>(i) || (members && !v.in_terminal)) continue;
        stream << comma << '"' << v.name << '"';
        comma = ", ";
      }
      stream << "]";
    }
    stream << "}";
    comma = ",";
  }
  stream << "\n]\n";
  if (!stream.flush()) throw std::runtime_error("cannot write " + file);
}

void write_json(const Mechanism& mechanism, const std::string& file) {
  std::ofstream stream(file, std::ios::binary);
  stream << to_json(mechanism);
  if (!stream.flush()) throw std::runtime_error("cannot write " + file);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    for (Mechanism& mechanism : mechanisms()) {
      if (argc > 4 && mechanism.name == argv[1]) {
        load_modal_files(mechanism, argv[3]);
        validate(mechanism);
        const std::string folder = argv[2];
        write_json(mechanism, folder + "/mechanism.json");
        find_joint_values(mechanism.multibody);
        const Variables variables =
            make_variables(mechanism, System(mechanism.multibody, find_compliance(mechanism.multibody)));
        write_elements(variables, folder + "/elements.json");
        write(mechanism, variables, folder + "/modelDescription.xml", {argv + 4, argv + argc});
        return 0;
      }
    }
    std::fprintf(stderr, "usage: write_model_description MODEL FOLDER RESOURCES SOURCE..., with a MODEL of models/\n");
  } catch (const std::exception& e) {
    std::fprintf(stderr, "write_model_description: %s\n", e.what());
  }
  return 1;
}
