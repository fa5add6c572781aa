// The model of an FMU whose mechanism is a file: resources/mechanism.json, with what the build knew of it in
// resources/identity.json.
#include "fmi/definition_checksum.h"
#include "fmi/model.h"
#include "fmi/resources.h"
#include "fmi/slave.h"
#include "model/json.h"
#include "model/modal_file.h"
#include "text/file.h"
#include "text/text.h"

namespace sigmafmu {
namespace {

constexpr char kMechanism[] = "mechanism.json", kIdentity[] = "identity.json";

// What `parse` makes of a file; its messages get the file's path.
template <typename Parse>
auto read(const std::string& folder, const char* name, Parse parse) {
  const std::string path = path_in(folder, name);
  try {
    const auto text = read_file(path);
    if (!text) throw std::runtime_error("it cannot be opened; the FMU is made of this file.");
    return parse(*text);
  } catch (const std::exception& e) {
    fail<Refused>(utf8(path), ": ", e.what());
  }
}

const std::string& entry(const std::map<std::string, std::string>& texts, const std::string& key) {
  const auto found = texts.find(key);
  if (found == texts.end()) throw std::runtime_error(key + " is missing.");
  return found->second;
}

}  // namespace

Model make_model(const char* location) {
  const std::string folder = resources_folder(location, kMechanism);
  Model model;
  std::string definition;
  read(folder, kIdentity, [&](const std::string& text) {
    const auto identity = texts_from_json(text);
    model.guid = entry(identity, "guid");
    model.variables = entry(identity, "variables");
    definition = entry(identity, "definition");
  });
  read(folder, kMechanism, [&](const std::string& text) {
    model.mechanism = from_json(text);
    model.resources = checksum(text);
    if (definition_checksum(model.mechanism) != definition) {
      throw std::runtime_error(
          "it has been edited since the build in more than values; names, connections, geometry and the choice of "
          "variables need a new build.");
    }
  });
  return model;
}

}  // namespace sigmafmu
