// Nanoseconds of a call through the C ABI, for few and many points, by law, shape of softening and state of the points.
// No optional outputs. cyclic_joint and fracture_energy are measured alternately, with states in place and not in
// place. A second build of the laws is measured alternately, too: law_calls [--beside=FOLDER] [--only=LAW].
//
// Other programs add time, in bursts longer than a window: the result is the smallest of many short windows.
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

using quoin::api::Material;
using quoin::benchmarks::mortar_joint;
using quoin::benchmarks::Points;
using quoin::benchmarks::Population;

constexpr int kWindows = 3000;
constexpr double kWindow = 5e-6;  // length of a window, s

double seconds_of(const Material& law, Points& points, int calls) {
  const auto start = std::chrono::steady_clock::now();
  for (int k = 0; k < calls; ++k) law.evaluate(points.batch);
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / calls;
}

struct Case {
  const char* law;
  const char* softening;  // shape; null: the law has no softening
  const char* state;
  Population population;
  const char* beside = nullptr;  // law for comparison, with equal results in this case
  bool in_place = false;
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
                           {"fracture_energy", "exponential", "softening", Population::softening},
                           {"cyclic_joint", "linear", "elastic", Population::elastic, "fracture_energy"},
                           {"cyclic_joint", "linear", "in place", Population::elastic, "fracture_energy", true},
                           {"cyclic_joint", "linear", "sliding", Population::sliding, "fracture_energy"},
                           {"cyclic_joint", "linear", "opening", Population::opening, "fracture_energy"},
                           {"cyclic_joint", "linear", "softening", Population::softening, "fracture_energy"},
                           {"cyclic_joint", "linear", "crushing", Population::crushing, "fracture_energy"},
                           {"cyclic_joint", "linear", "corner", Population::corner, "fracture_energy"},
                           {"cyclic_joint", "linear", "both", Population::both},
                           {"cyclic_joint", "exponential", "in place", Population::elastic, "fracture_energy", true},
                           {"cyclic_joint", "exponential", "sliding", Population::sliding, "fracture_energy"},
                           {"cyclic_joint", "exponential", "opening", Population::opening, "fracture_energy"},
                           {"cyclic_joint", "exponential", "crushing", Population::crushing, "fracture_energy"},
                           {"cyclic_joint", "exponential", "corner", Population::corner, "fracture_energy"},
                           {"cyclic_joint", "exponential", "both", Population::both}};

void measure(const Case& what, const std::vector<std::string>& folders) {
  std::vector<Material> laws;
  for (const std::string& folder : folders) {
    laws.push_back(mortar_joint(folder + "/" + what.law + ".so", what.softening));
  }
  if (what.beside != nullptr) {
    laws.push_back(mortar_joint(folders[0] + "/" + what.beside + ".so", what.softening));
  }
  const bool exponential = what.softening != nullptr && std::string_view(what.softening) == "exponential";
  for (const std::size_t count : {1, 2, 3, 4, 8, 256, 4000}) {
    std::vector<std::unique_ptr<Points>> points;
    for (const auto& law : laws) {
      points.push_back(std::make_unique<Points>(law, count, what.population, exponential, what.in_place));
    }
    std::vector<double> best(laws.size(), 1.0);
    const int calls = std::max(1, static_cast<int>(kWindow / seconds_of(laws[0], *points[0], 100)));
    for (int window = 0; window < kWindows; ++window) {
      for (std::size_t k = 0; k < laws.size(); ++k) best[k] = std::min(best[k], seconds_of(laws[k], *points[k], calls));
    }
    for (const auto& each : points) {
      if (each->batch.failed_count != 0) throw std::runtime_error("failed points");
    }
    const std::string shape = what.softening == nullptr ? "" : what.softening;
    fmt::print("{:16} {:11} {:9} {:5} points {:9.1f} ns", what.law, shape, what.state, count, 1e9 * best[0]);
    for (std::size_t k = 1; k < best.size(); ++k) {
      const char* name = k < folders.size() ? "beside" : what.beside;
      fmt::print("   {} {:9.1f} ns   ratio {:.2f}", name, 1e9 * best[k], best[0] / best[k]);
    }
    fmt::print("\n");
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> folders = {QUOIN_LAWS};
  std::string only;
  const std::string_view beside = "--beside=", one_law = "--only=";
  for (int k = 1; k < argc; ++k) {
    const std::string_view argument = argv[k];
    if (argument.starts_with(beside)) {
      folders.emplace_back(argument.substr(beside.size()));
    } else if (argument.starts_with(one_law)) {
      only = argument.substr(one_law.size());
    } else {
      fmt::print(stderr, "usage: law_calls [--beside=FOLDER] [--only=LAW]\n");
      return 2;
    }
  }
  for (const Case& what : kCases) {
    if (only.empty() || only == what.law) measure(what, folders);
  }
}
