// describe_model MODEL RESOURCES FILE: writes the description of a mechanism of models/, whose modal data are in the
// folder RESOURCES, into a file.
#include <cstdio>
#include <exception>
#include <fstream>
#include <stdexcept>

#include "describe.h"
#include "model/mechanisms.h"
#include "model/modal_file.h"

int main(int argc, char** argv) {
  using namespace sigmafmu;
  try {
    for (Mechanism& mechanism : mechanisms()) {
      if (argc != 4 || mechanism.name != argv[1]) continue;
      load_modal_files(mechanism, argv[2]);
      std::ofstream file(argv[3], std::ios::binary);
      file << describe(mechanism);
      if (!file.flush()) throw std::runtime_error(std::string("cannot write ") + argv[3]);
      return 0;
    }
    std::fprintf(stderr, "usage: describe_model MODEL RESOURCES FILE, with a MODEL of models/\n");
  } catch (const std::exception& e) {
    std::fprintf(stderr, "describe_model: %s\n", e.what());
  }
  return 1;
}
