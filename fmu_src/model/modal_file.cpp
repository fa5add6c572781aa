#include "model/modal_file.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "model/json_values.h"
#include "model/validation.h"
#include "text/file.h"
#include "text/text.h"

namespace sigmafmu {
namespace {

using namespace json;

template <typename... Parts>
[[noreturn]] void fail(const Parts&... parts) {
  sigmafmu::fail<std::runtime_error>(parts...);
}

constexpr const char* kFormat = "sigmafmu modes";
constexpr int kVersion = 1;
constexpr const char* kKeys[] = {"format", "version", "units", "note", "names", "frequencies", "X", "m",
                                 "M",      "Phi",     "Theta", "K",    "D"};

VectorXd read_vector(const Json& value, const std::string& name, std::size_t size) {
  list(value, name, size);
  VectorXd result(static_cast<Eigen::Index>(size));
  for (std::size_t i = 0; i < size; ++i) result[static_cast<Eigen::Index>(i)] = number(value[i], at(name, i));
  return result;
}

MatrixXd read_matrix(const Json& value, const std::string& name, std::size_t rows, std::size_t columns) {
  list(value, name, rows);
  MatrixXd result(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(columns));
  for (std::size_t i = 0; i < rows; ++i) {
    result.row(static_cast<Eigen::Index>(i)) = read_vector(value[i], at(name, i), columns);
  }
  return result;
}

// n x 3 x f -> 3n x f.
MatrixXd read_shapes(const Json& value, const std::string& name, std::size_t nodes, std::size_t modes) {
  list(value, name, nodes);
  MatrixXd result(static_cast<Eigen::Index>(3 * nodes), static_cast<Eigen::Index>(modes));
  for (std::size_t i = 0; i < nodes; ++i) {
    result.middleRows<3>(static_cast<Eigen::Index>(3 * i)) = read_matrix(value[i], at(name, i), 3, modes);
  }
  return result;
}

// Dense, or sparse with its upper triangle as {"rows": [], "columns": [], "values": []}.
MatrixXd read_mass_matrix(const Json& value, std::size_t n) {
  if (value.is_array()) return read_matrix(value, "M", n, n);
  for (const char* key : {"rows", "columns", "values"}) {
    if (!value.is_object() || !value.contains(key) || value.size() != 3) {
      fail("M must be a list of rows, or have the keys rows, columns and values.");
    }
  }
  const std::size_t count = value["values"].size();
  const VectorXd rows = read_vector(value["rows"], "M.rows", count);
  const VectorXd columns = read_vector(value["columns"], "M.columns", count);
  const VectorXd values = read_vector(value["values"], "M.values", count);
  MatrixXd M = MatrixXd::Zero(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(n));
  for (Eigen::Index k = 0; k < rows.size(); ++k) {
    if (!(rows[k] >= 0 && rows[k] <= columns[k] && columns[k] < static_cast<double>(n)) ||
        rows[k] != std::floor(rows[k]) || columns[k] != std::floor(columns[k])) {
      fail("M has an entry at [", rows[k], ", ", columns[k], "]; allowed are whole numbers with 0 <= row <= column < ",
           n, ".");
    }
    const auto i = static_cast<Eigen::Index>(rows[k]), j = static_cast<Eigen::Index>(columns[k]);
    M(i, j) += values[k];
    if (i != j) M(j, i) += values[k];
  }
  return M;
}

void check_keys(const Json& content) {
  if (!content.is_object()) fail("it must hold an object, with the keys X, Phi, K and m or M.");
  for (const auto& item : content.items()) {
    if (std::find(std::begin(kKeys), std::end(kKeys), item.key()) == std::end(kKeys)) {
      fail("the key ", item.key(), " is unknown.");
    }
  }
  for (const char* key : {"X", "Phi", "K"}) {
    if (!content.contains(key)) fail("the key ", key, " is missing; X, Phi, K and m or M are needed.");
  }
  if (content.contains("m") == content.contains("M")) {
    fail("there must be either m (a mass for each node) or M (a mass matrix).");
  }
  const std::pair<const char*, Json> expected[] = {{"format", kFormat}, {"version", kVersion}, {"units", "SI"}};
  for (const auto& [key, allowed] : expected) {
    if (content.contains(key) && content[key] != allowed) {
      fail(key, " is ", content[key].dump().substr(0, 40), "; it must be ", allowed.dump(), ".");
    }
  }
}

ModalDef read(const Json& content, int modes) {
  check_keys(content);
  const Json& K = content["K"];
  if (!K.is_array() || K.size() != static_cast<std::size_t>(modes)) {
    fail("it has ", K.size(), " modes (rows of K); this mechanism has variables for ", modes, ".");
  }
  const std::size_t n = content["X"].is_array() ? content["X"].size() : 0, f = K.size();
  ModalDef modal;
  modal.nodes = read_matrix(content["X"], "X", n, 3);
  if (content.contains("m")) {
    modal.masses = read_vector(content["m"], "m", n);
  } else {
    modal.mass_matrix = read_mass_matrix(content["M"], n);
  }
  modal.shapes = read_shapes(content["Phi"], "Phi", n, f);
  if (content.contains("Theta")) modal.rotations = read_shapes(content["Theta"], "Theta", n, f);
  modal.stiffness = read_matrix(K, "K", f, f);
  if (content.contains("D")) modal.damping = read_matrix(content["D"], "D", f, f);
  modal.initial_coordinates = modal.initial_rates = VectorXd::Zero(modes);
  return modal;
}

// Reads what the file is for; damping and initial values stay those of the definition.
void load(RigidBodyDef& body, const std::string& text) {
  ModalDef modal = read(parse_json(text, "it is no JSON file: "), body.modal->modes);
  const ModalDef& own = *body.modal;
  modal.file = own.file;
  modal.modes = own.modes;
  modal.mass_damping = own.mass_damping;
  modal.stiffness_damping = own.stiffness_damping;
  if (own.initial_coordinates.size() > 0) modal.initial_coordinates = own.initial_coordinates;
  if (own.initial_rates.size() > 0) modal.initial_rates = own.initial_rates;
  body.modal = std::move(modal);
  validation::validate_modal(body.name, *body.modal);
}

void check_stations(const Mechanism& mechanism, int body) {
  const int nodes = mechanism.multibody.bodies[body].modal->node_count();
  for (const StationDef& station : mechanism.stations) {
    if (station.body != body) continue;
    for (int node : station.nodes) {
      if (node >= nodes) fail("it has ", nodes, " nodes; ", station.name, " is at node ", node, " (counted from 0).");
    }
  }
}

}  // namespace

std::string utf8(const std::string& text) { return with_replacements(text); }

std::vector<std::string> modal_files(const Mechanism& mechanism) {
  std::vector<std::string> files;
  for (const RigidBodyDef& body : mechanism.multibody.bodies) {
    if (body.modal && !body.modal->file.empty()) files.push_back(body.modal->file);
  }
  return files;
}

std::uint64_t load_modal_files(Mechanism& mechanism, const std::string& folder, std::uint64_t before) {
  std::uint64_t sum = before;
  auto& bodies = mechanism.multibody.bodies;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (!bodies[i].modal || bodies[i].modal->file.empty()) continue;
    validation::validate_modal_file(bodies[i].name, *bodies[i].modal);
    const std::string path = path_in(folder, bodies[i].modal->file);
    try {
      const auto text = read_file(path);
      if (!text) fail("it cannot be opened; the FMU needs this file with the modal data of a flexible body.");
      load(bodies[i], *text);
      sum = checksum(*text, sum);
      check_stations(mechanism, static_cast<int>(i));
    } catch (const std::exception& e) {
      fail(utf8(path), ": ", e.what());
    }
  }
  return sum;
}

}  // namespace sigmafmu
