// Nanoseconds per contact point of the fracture-energy law, through the C ABI: by population of states, batch size and
// instruction set. For comparison in the same run: the equations compiled as scalar code, and the cyclic joint law.
#include <benchmark/benchmark.h>
#include <dlfcn.h>
#include <fmt/format.h>

#include <deque>
#include <string>
#include <string_view>
#include <vector>

#include "hwy/highway.h"
#include "hwy/targets.h"
#include "machine_limits.h"
#include "points.h"

namespace {

using quoin::api::Material;
using quoin::benchmarks::mortar_joint;
using quoin::benchmarks::Points;
using quoin::benchmarks::Population;

// Operations and bytes of a point, counted by hand in equations.h and kernel.cpp. The case is linear softening, shared,
// with crushing, without dilation; outputs are not in place. An addition, multiplication, minimum, maximum, comparison,
// division or root is one operation, a multiply-add two; selections and masks do not count.
//   elastic     e 2, sigma 1, trial 4, f 2, mu 2, S 3, squares 5, F 5, limits 6
//   softening   the elastic test 30, and the step: sliding 75, opening 67, half of the points each
// Bytes: 8 columns in, then 1 more in and 7 out; softening reads its columns a second time, sliding the old sigma too.
struct Work {
  double operations, bytes;
};
constexpr Work kElasticWork{30.0, 8.0 * (8 + 1 + 7)}, kSofteningWork{30.0 + 0.5 * (75.0 + 67.0), 8.0 * (8 + 9.5 + 7)};

void measure(benchmark::State& state, const Material& loaded, Population population,
             const quoin::benchmarks::Limits& limits) {
  Points points(loaded, static_cast<std::size_t>(state.range(0)), population);
  for (auto _ : state) {
    loaded.evaluate(points.batch);
    benchmark::ClobberMemory();
  }
  if (points.batch.failed_count != 0) state.SkipWithError("failed points");
  if (state.range(0) >= 64 && (population == Population::elastic) == (points.batch.any_yielding != 0))
    state.SkipWithError("wrong population");
  state.counters["ns/point"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * 1e-9 * static_cast<double>(state.range(0)),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  if (std::string_view(loaded.law().id) != "fracture_energy") return;
  if (population != Population::elastic && population != Population::softening) return;
  // Fractions of the machine's limits, which are measured in this run.
  const Work work = population == Population::elastic ? kElasticWork : kSofteningWork;
  const double done = static_cast<double>(state.iterations()) * static_cast<double>(state.range(0));
  state.counters["of_peak"] = benchmark::Counter(done * work.operations / limits.flops, benchmark::Counter::kIsRate);
  state.counters["of_L1"] = benchmark::Counter(done * work.bytes / limits.level_1, benchmark::Counter::kIsRate);
}

}  // namespace

int main(int argc, char** argv) {
  const quoin::benchmarks::Limits limits = quoin::benchmarks::measure_limits();
  fmt::print("{}\n", quoin::benchmarks::describe(limits));
  std::fflush(stdout);
  const std::string shipped = quoin::test::law_file("fracture_energy");
  const Material scalar = mortar_joint(QUOIN_SCALAR_LAW);
  std::deque<Material> laws;  // a deque, since benchmarks have references to its elements
  const std::pair<const char*, Population> populations[] = {
      {"elastic", Population::elastic}, {"softening", Population::softening}, {"crushing", Population::crushing},
      {"corner", Population::corner},   {"damaged", Population::damaged},     {"mixed", Population::mixed},
      {"random", Population::random}};
  const auto add = [&](const std::string& name, const Material& law, bool all_sizes) {
    for (const auto& [population_name, population] : populations) {
      auto* entry = benchmark::RegisterBenchmark(
          (name + "/" + population_name).c_str(),
          [&law, &limits, kind = population](benchmark::State& state) { measure(state, law, kind, limits); });
      for (const long count : {1L, 8L, 64L, 256L, 500L, 4000L, 60000L, 1000000L}) {
        if (all_sizes || count == 256) entry->Arg(count);
      }
    }
  };
  add("scalar -O2", scalar, false);
  // A material has the kernels of the best instruction set at its creation.
  const std::int64_t supported = hwy::SupportedTargets();
  for (const std::int64_t target : {std::int64_t{HWY_SSE4}, std::int64_t{HWY_AVX2}, std::int64_t{HWY_AVX3}}) {
    if ((supported & target) == 0) {
      fmt::print("{}: not on this machine, not measured\n", hwy::TargetName(target));
      continue;
    }
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    const bool all_sizes = target == HWY_AVX2 || target == HWY_AVX3;
    laws.push_back(mortar_joint(shipped));
    add(hwy::TargetName(target), laws.back(), all_sizes);
    laws.push_back(mortar_joint(quoin::test::law_file("cyclic_joint")));
    add(std::string(hwy::TargetName(target)) + " cyclic_joint", laws.back(), all_sizes);
  }
  hwy::SetSupportedTargetsForTest(0);
  // A second build of the law for comparison in the same run: law_benchmark --beside=FILE.so
  const std::string_view beside = "--beside=";
  for (int k = 1; k < argc; ++k) {
    if (!std::string_view(argv[k]).starts_with(beside)) continue;
    laws.push_back(mortar_joint(std::string(argv[k]).substr(beside.size())));
    add("beside", laws.back(), true);
  }
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
