#include "fmi/modal_file.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <vector>

#include "text/text.h"

namespace sigmafmu {
namespace {

using Json = nlohmann::json;

template <typename... Parts>
[[noreturn]] void fail(const Parts&... parts) {
  sigmafmu::fail<std::runtime_error>(parts...);
}

constexpr const char* kFormat = "sigmafmu modes";
constexpr int kVersion = 1;
constexpr const char* kKeys[] = {"format", "version", "units", "note", "names", "frequencies", "X", "m",
                                 "M",      "Phi",     "Theta", "K",    "D"};

double number(const Json& value, const std::string& name) {
  if (!value.is_number()) fail(name, " is ", value.dump().substr(0, 40), "; it must be a number.");
  return value.get<double>();
}

const Json& list(const Json& value, const std::string& name, std::size_t size) {
  if (!value.is_array()) fail(name, " must be a list.");
  if (value.size() != size) fail(name, " has ", value.size(), " entries; it must have ", size, ".");
  return value;
}

std::string at(const std::string& name, std::size_t i) { return name + "[" + std::to_string(i) + "]"; }

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
    const auto i = static_cast<Eigen::Index>(rows[k]), j = static_cast<Eigen::Index>(columns[k]);
    if (!(rows[k] >= 0 && rows[k] <= columns[k] && columns[k] < static_cast<double>(n)) ||
        static_cast<double>(i) != rows[k] || static_cast<double>(j) != columns[k]) {
      fail("M has an entry at [", rows[k], ", ", columns[k], "]; allowed are whole numbers with 0 <= row <= column < ",
           n, ".");
    }
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

void load(Mechanism& mechanism, const ModalFileDef& definition, const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) fail("it cannot be opened; the FMU needs this file with the modal data of a flexible body.");
  Json content;
  try {
    content = Json::parse(file);
  } catch (const Json::exception& e) {
    fail("it is no JSON file: ", e.what(), ".");
  }
  RigidBodyDef& body = mechanism.multibody.bodies[definition.body];
  body.modal = read(content, definition.modes);
  MultibodyDef alone;
  alone.add(body);
  validate(alone);
  for (const StationDef& station : mechanism.stations) {
    if (station.body != definition.body) continue;
    for (int node : station.nodes) {
      if (node >= body.modal->node_count()) {
        fail("it has ", body.modal->node_count(), " nodes; ", station.name, " is at node ", node, " (counted from 0).");
      }
    }
  }
}

// FMI's strings are UTF-8; bytes that are not are shown as replacement characters.
std::string utf8(const std::string& text) {
  try {
    Json(text).dump();
    return text;
  } catch (const Json::exception&) {
    const std::string quoted = Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
    return quoted.substr(1, quoted.size() - 2);
  }
}

std::string decode_percent(const std::string& text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '%' && i + 2 < text.size() && std::isxdigit(static_cast<unsigned char>(text[i + 1])) &&
        std::isxdigit(static_cast<unsigned char>(text[i + 2]))) {
      result += static_cast<char>(std::stoi(text.substr(i + 1, 2), nullptr, 16));
      i += 2;
    } else {
      result += text[i];
    }
  }
  return result;
}

std::string lower_case(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

// What a URI has before its first colon; empty for a path, perhaps one that starts with a drive.
std::string scheme_of(const std::string& uri) {
  const std::size_t colon = uri.find(':');
  if (colon == std::string::npos || colon < 2 || uri.find_first_of("/\\") < colon) return {};
  return uri.substr(0, colon);
}

bool is_this_machine(const std::string& host) {
  return host.empty() || host == "localhost" || host == "127.0.0.1" || host == "[::1]";
}

}  // namespace

void load_modal_files(Mechanism& mechanism, const std::string& folder) {
  for (const ModalFileDef& definition : mechanism.modal_files) {
    const auto path = std::filesystem::u8path(folder) / definition.file;
    try {
      load(mechanism, definition, path);
    } catch (const std::exception& e) {
      fail(utf8(path.u8string()), ": ", e.what());
    }
  }
}

std::string folder_of_uri(const std::string& uri) {
  const std::string scheme = scheme_of(uri);
  if (scheme.empty()) return uri;
  if (lower_case(scheme) != "file") {
    fail("The resource location is ", utf8(uri), "; it must be a file URI, as file:///folder.");
  }
  std::string path = uri.substr(scheme.size() + 1);
  if (path.rfind("//", 0) == 0) {  // another machine's name stays: //host/folder is how Windows names it
    const std::size_t end = std::min(path.find('/', 2), path.size());
    if (is_this_machine(lower_case(path.substr(2, end - 2)))) path.erase(0, end);
  }
  path = decode_percent(path);
  if (path.find('\0') != std::string::npos) {
    fail("The resource location is ", utf8(uri), "; %00 is not possible in a path.");
  }
  const bool drive =
      path.size() > 2 && path[0] == '/' && std::isalpha(static_cast<unsigned char>(path[1])) && path[2] == ':';
  return drive ? path.substr(1) : path;
}

}  // namespace sigmafmu
