// Path tests: the file, its formulas, and their values at one point.
#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "base/error.h"
#include "input.h"
#include "law/path_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quoin;
  try {
    const PathFile path = read_path_file(file_of(data, size, ".toml"));
    const Variables variables{{"dn", 1e-6}, {"part", 0.5}, {"kn", 1e9}};
    for (const PathPoint& point : path.points) {
      for (const auto& [key, formula] : point.targets) {
        try {
          formula(variables);
        } catch (const std::invalid_argument&) {  // a name that nobody knows
        }
      }
    }
  } catch (const Error& error) {
    if (error.exit_code != Exit::bad_input || *error.what() == '\0') std::abort();
  }
  return 0;
}
