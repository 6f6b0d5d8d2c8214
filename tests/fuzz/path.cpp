// Path tests: the file, its formulas, and the path of one point if it is short.
#include <numeric>

#include "input.h"
#include "judge.h"
#include "law/path_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quoin;
  judge({Exit::bad_input, Exit::law_refused, Exit::numerical}, [&] {
    const PathFile path = read_path_file(file_of(data, size, ".toml"));
    const double steps = std::accumulate(path.points.begin(), path.points.end(), 0.0,
                                         [](double sum, const PathPoint& point) { return sum + point.steps; });
    if (steps < 50) run_path(path);
  });
  return 0;
}
