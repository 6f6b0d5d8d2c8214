// Nanoseconds of a call through the C ABI, few points and many, by law, shape of softening and state of the points; no
// optional output. With another build of the laws beside it, both in turn: law_calls [--beside=FOLDER]
//
// A neighbour only ever adds time, in bursts longer than these windows: the smallest of many short windows counts.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "points.h"

namespace {

using quoin::benchmarks::LoadedLaw;
using quoin::benchmarks::Points;
using quoin::benchmarks::Population;

constexpr int kWindows = 3000;
constexpr double kWindow = 5e-6;  // s

double seconds_of(const LoadedLaw& law, Points& points, int calls) {
  const auto start = std::chrono::steady_clock::now();
  for (int k = 0; k < calls; ++k) law.law.evaluate(law.handle, &points.batch);
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / calls;
}

struct Case {
  const char* law;
  const char* softening;  // null: the law has none
  const char* state;
  Population population;
};
constexpr Case kCases[] = {{"elastic", nullptr, "elastic", Population::elastic},
                           {"coulomb_slip", nullptr, "elastic", Population::elastic},
                           {"coulomb_slip", nullptr, "sliding", Population::damaged},
                           {"fracture_energy", "linear", "elastic", Population::elastic},
                           {"fracture_energy", "linear", "sliding", Population::sliding},
                           {"fracture_energy", "linear", "opening", Population::opening},
                           {"fracture_energy", "linear", "softening", Population::softening},
                           {"fracture_energy", "exponential", "elastic", Population::elastic},
                           {"fracture_energy", "exponential", "sliding", Population::sliding},
                           {"fracture_energy", "exponential", "opening", Population::opening},
                           {"fracture_energy", "exponential", "softening", Population::softening}};

void measure(const Case& what, const std::vector<std::string>& folders) {
  std::vector<std::unique_ptr<LoadedLaw>> laws;
  for (const std::string& folder : folders) {
    laws.push_back(std::make_unique<LoadedLaw>(folder + "/" + what.law + ".so", what.softening));
  }
  const bool exponential = what.softening != nullptr && std::string_view(what.softening) == "exponential";
  for (const std::size_t count : {1, 2, 3, 4, 8, 256, 4000}) {
    Points points(count, what.population, exponential);
    std::vector<double> best(laws.size(), 1.0);
    const int calls = std::max(1, static_cast<int>(kWindow / seconds_of(*laws[0], points, 100)));
    for (int window = 0; window < kWindows; ++window) {
      for (std::size_t k = 0; k < laws.size(); ++k) best[k] = std::min(best[k], seconds_of(*laws[k], points, calls));
    }
    if (points.batch.failed_count != 0) throw std::runtime_error("failed points");
    const std::string shape = what.softening == nullptr ? "" : what.softening;
    fmt::print("{:16} {:11} {:9} {:5} points {:9.1f} ns", what.law, shape, what.state, count, 1e9 * best[0]);
    if (best.size() > 1) fmt::print("   beside {:9.1f} ns   ratio {:.2f}", 1e9 * best[1], best[1] / best[0]);
    fmt::print("\n");
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> folders = {QUOIN_LAWS};
  const std::string_view beside = "--beside=";
  for (int k = 1; k < argc; ++k) {
    if (!std::string_view(argv[k]).starts_with(beside)) {
      fmt::print(stderr, "usage: law_calls [--beside=FOLDER]\n");
      return 2;
    }
    folders.emplace_back(std::string(argv[k]).substr(beside.size()));
  }
  for (const Case& what : kCases) measure(what, folders);
}
