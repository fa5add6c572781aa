// The library of the Python package that describes mechanisms of files: a C interface of JSON texts.
#include <cstdlib>
#include <cstring>
#include <exception>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "describe.h"
#include "model/json.h"
#include "model/modal_file.h"
#include "start.h"

#if defined _WIN32
#define SIGMAFMU_EXPORT __declspec(dllexport)
#else
#define SIGMAFMU_EXPORT __attribute__((visibility("default")))
#endif

namespace {

using namespace sigmafmu;

std::string error(const char* kind, const char* sentence) { return nlohmann::json({{kind, utf8(sentence)}}).dump(); }

// A text that Python gives back to sigmafmu_free; null when there is no memory.
template <typename Answer>
char* told(const Answer& answer) noexcept {
  try {
    std::string text;
    try {
      text = answer();
    } catch (const std::runtime_error& e) {
      text = error("failure", e.what());
    } catch (const std::exception& e) {
      text = error("error", e.what());
    }
    char* result = static_cast<char*>(std::malloc(text.size() + 1));
    if (result) std::memcpy(result, text.c_str(), text.size() + 1);
    return result;
  } catch (...) {
    return nullptr;
  }
}

Mechanism read(const char* mechanism_json, const char* resources) {
  Mechanism mechanism = from_json(mechanism_json);
  load_modal_files(mechanism, resources);
  return mechanism;
}

}  // namespace

// Every answer is JSON; {"error": sentence} for a mechanism that is wrong, {"failure": sentence} for one that cannot do
// what is asked, as be assembled. A mechanism is JSON as well; its modal data are in a folder (UTF-8).
extern "C" {

// Its description (describe.h).
SIGMAFMU_EXPORT char* sigmafmu_describe(const char* mechanism_json, const char* resources) noexcept {
  return told([&] { return describe(read(mechanism_json, resources)); });
}

// Whether it is one: nothing else is told.
SIGMAFMU_EXPORT char* sigmafmu_check(const char* mechanism_json, const char* resources) noexcept {
  return told([&] {
    validate(read(mechanism_json, resources));
    return std::string("{}");
  });
}

// Its start (start.h); the values of parameters are an object of numbers.
SIGMAFMU_EXPORT char* sigmafmu_start(const char* mechanism_json, const char* resources, const char* values) noexcept {
  return told([&] {
    return start(read(mechanism_json, resources), nlohmann::json::parse(values).get<std::map<std::string, double>>());
  });
}

// What its joints miss at positions, a list, and coordinates, a list of indices (start.h).
SIGMAFMU_EXPORT char* sigmafmu_closure(const char* mechanism_json, const char* resources, const char* q,
                                       const char* coordinates) noexcept {
  return told([&] {
    return closure(read(mechanism_json, resources), nlohmann::json::parse(q).get<std::vector<double>>(),
                   nlohmann::json::parse(coordinates).get<std::vector<int>>());
  });
}

// How coordinates, a list of indices, yield to forces on them (start.h).
SIGMAFMU_EXPORT char* sigmafmu_mobility(const char* mechanism_json, const char* resources,
                                        const char* coordinates) noexcept {
  return told([&] {
    return mobility(read(mechanism_json, resources), nlohmann::json::parse(coordinates).get<std::vector<int>>());
  });
}

// Poses of a frame that moves as prescribed (start.h), by its index; times and what is added are lists.
SIGMAFMU_EXPORT char* sigmafmu_poses(const char* mechanism_json, const char* motion, const char* times,
                                     const char* added) noexcept {
  return told([&] {
    return poses(from_json(mechanism_json), nlohmann::json::parse(motion).get<int>(),
                 nlohmann::json::parse(times).get<std::vector<double>>(),
                 nlohmann::json::parse(added).get<std::vector<double>>());
  });
}

// Its degrees of freedom and masses (start.h).
SIGMAFMU_EXPORT char* sigmafmu_freedom(const char* mechanism_json, const char* resources) noexcept {
  return told([&] { return freedom_and_masses(read(mechanism_json, resources)); });
}

// The mechanism that has nothing but defaults.
SIGMAFMU_EXPORT char* sigmafmu_default() noexcept {
  return told([] { return to_json(Mechanism()); });
}

SIGMAFMU_EXPORT void sigmafmu_free(char* text) noexcept { std::free(text); }

}  // extern "C"
