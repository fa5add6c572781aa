// The library of the Python package that describes mechanisms of files: a C interface of JSON texts.
#include <cstdlib>
#include <cstring>
#include <exception>
#include <nlohmann/json.hpp>
#include <string>

#include "describe.h"
#include "model/json.h"
#include "model/modal_file.h"

#if defined _WIN32
#define SIGMAFMU_EXPORT __declspec(dllexport)
#else
#define SIGMAFMU_EXPORT __attribute__((visibility("default")))
#endif

namespace {

using namespace sigmafmu;

std::string error(const char* sentence) { return nlohmann::json({{"error", utf8(sentence)}}).dump(); }

std::string answer(const char* mechanism_json, const char* resources) {
  try {
    Mechanism mechanism = from_json(mechanism_json);
    load_modal_files(mechanism, resources);
    return describe(std::move(mechanism));
  } catch (const std::exception& e) {
    return error(e.what());
  }
}

}  // namespace

extern "C" {

// The description of a mechanism whose modal data are in a folder (UTF-8), or {"error": sentence}. The caller gives the
// text back to sigmafmu_free; null when there is no memory.
SIGMAFMU_EXPORT char* sigmafmu_describe(const char* mechanism_json, const char* resources) noexcept {
  try {
    const std::string text = answer(mechanism_json, resources);
    char* result = static_cast<char*>(std::malloc(text.size() + 1));
    if (result) std::memcpy(result, text.c_str(), text.size() + 1);
    return result;
  } catch (...) {
    return nullptr;
  }
}

SIGMAFMU_EXPORT void sigmafmu_free(char* text) noexcept { std::free(text); }

}  // extern "C"
