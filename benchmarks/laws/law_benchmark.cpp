// Nanoseconds per contact point of the fracture-energy law, through the C ABI: by population of states, batch size and
// instruction set, beside the same equations compiled as scalar code in the same run.
//
// Every iteration starts from the same stored state (old and new columns differ), so that a population stays what it
// is.
#include <benchmark/benchmark.h>
#include <dlfcn.h>
#include <fmt/format.h>

#include <cmath>
#include <deque>
#include <random>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "hwy/aligned_allocator.h"
#include "hwy/highway.h"
#include "hwy/targets.h"
#include "machine_limits.h"
#include "quoin/quoin.h"
#include "tests/kernels/plugin.h"
#include "tests/mortar.h"

namespace {

constexpr int kStates = 5;

// A law of a file with the mortar of Table 1.
struct LoadedLaw : quoin::test::TestMaterial {
  explicit LoadedLaw(const std::string& path)
      : TestMaterial(quoin::test::load_law_file(path),
                     {{quoin::test::mortar::properties.begin(), quoin::test::mortar::properties.end()}, {}, {}}) {
    if (handle == nullptr) throw std::runtime_error(path + ": " + text);
  }
};

enum class Population { elastic, softening, damaged, mixed, random };

// Columns on cache lines, as a host that cares lays them out (a vector that crosses a line costs two accesses), and an
// odd number of lines apart, so that they do not share the sets of a cache.
struct Points {
  static constexpr std::size_t kColumns = 3 + 2 * (3 + kStates);
  std::size_t length;
  hwy::AlignedFreeUniquePtr<double[]> memory;
  double *jump, *slip_s, *slip_t, *traction[3], *traction_new[3], *state[kStates], *state_new[kStates];
  quoin_in old_columns[kStates];
  quoin_out new_columns[kStates];
  quoin_batch batch{};

  Points(std::size_t count, Population population)
      : length(8 * (((count + 7) / 8 | 1) + 4)), memory(hwy::AllocateAligned<double>(kColumns * length)) {
    std::fill_n(memory.get(), kColumns * length, 0.0);
    double* next = memory.get();
    const auto place = [&](double*& column) { column = next, next += length; };
    place(jump), place(slip_s), place(slip_t);
    for (int k = 0; k < 3; ++k) place(traction[k]), place(traction_new[k]);
    for (int k = 0; k < kStates; ++k) place(state[k]), place(state_new[k]);
    std::mt19937_64 random(20261121);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (std::size_t i = 0; i < count; ++i) {
      Population kind = population;
      // mixed: one point in eight softens, the rest is elastic, in blocks as in a wall with a crack; random: any state.
      if (kind == Population::mixed) kind = i / 64 % 8 == 0 ? Population::softening : Population::elastic;
      const double u = unit(random);
      if (kind == Population::elastic) {
        jump[i] = -1e-5 * unit(random);
        slip_s[i] = 1e-9 * u;
        traction[1][i] = 1e4 * unit(random);
      } else if (kind == Population::softening) {
        // closed and slipping with decaying cohesion, or opening on the envelope: joints, eight points each
        state[0][i] = state[1][i] = 0.2 + 0.5 * u;
        if (i / 8 % 2 == 0) {
          jump[i] = -1e-5 * unit(random);
          const double sigma = 82e9 * jump[i];
          traction[1][i] = 0.3e6 * (1.0 - state[1][i]) - 0.7002075382 * sigma;
          slip_s[i] = 1e-7;
        } else {
          jump[i] = 2.44e-6 + (state[0][i] + 1e-3) * 1.4878e-4;
          slip_s[i] = 1e-9;
        }
      } else if (kind == Population::damaged) {
        // A crack after the peak: nothing left but friction; joints of eight points, one in four of them open
        state[0][i] = state[1][i] = 1.0 + u;
        jump[i] = i / 8 % 4 == 0 ? 1e-4 * unit(random) : -1e-5 * unit(random);
        traction[1][i] = std::max(0.0, -0.7002075382 * 82e9 * jump[i]);
        slip_s[i] = 1e-7;
      } else {
        state[0][i] = state[1][i] = unit(random) < 0.5 ? 0.0 : 1.2 * unit(random);
        state[2][i] = unit(random) < 0.9 ? 0.0 : 1e-4 * unit(random);
        jump[i] = unit(random) < 0.5 ? -7e-5 * unit(random) : 1e-4 * unit(random);
        traction[1][i] = 0.2e6 * unit(random);
        slip_s[i] = 1e-6 * (u - 0.5);
        slip_t[i] = 1e-6 * (unit(random) - 0.5);
      }
    }
    for (int k = 0; k < kStates; ++k) {
      const bool history = k < 4;
      old_columns[k] = {history ? state[k] : nullptr, 1};
      new_columns[k] = {history ? state_new[k] : nullptr, 1};
    }
    batch.struct_size = sizeof(quoin_batch);
    batch.count = count;
    batch.normal_jump = {jump, 1};
    batch.slip_increment[0] = {slip_s, 1};
    batch.slip_increment[1] = {slip_t, 1};
    for (int k = 0; k < 3; ++k) {
      batch.traction_old[k] = {traction[k], 1};
      batch.traction_new[k] = {traction_new[k], 1};
    }
    batch.state_old = old_columns;
    batch.state_new = new_columns;
  }
};

// What the equations ask for a point, counted by hand in equations.h and kernel.cpp (linear softening, shared, with
// crushing, without dilation; outputs apart from inputs): an addition, multiplication, minimum, maximum, comparison,
// division or root is one operation, a multiply-add two; selections and masks are none.
//   elastic     e 2, sigma 1, trial 4, f 2, mu 2, S 3, squares 5, F 5, limits 6
//   softening   the elastic test 30, and the step: sliding 73, opening 67, half of the points each
// Bytes: 8 columns in, then 1 more in and 7 out; softening reads its columns a second time.
struct Work {
  double operations, bytes;
};
constexpr Work kElasticWork{30.0, 8.0 * (8 + 1 + 7)}, kSofteningWork{30.0 + 0.5 * (73.0 + 67.0), 8.0 * (8 + 9 + 7)};

void measure(benchmark::State& state, const LoadedLaw& loaded, Population population,
             const quoin::benchmarks::Limits& limits) {
  Points points(static_cast<std::size_t>(state.range(0)), population);
  for (auto _ : state) {
    loaded.law.evaluate(loaded.handle, &points.batch);
    benchmark::ClobberMemory();
  }
  if (points.batch.failed_count != 0) state.SkipWithError("failed points");
  if (state.range(0) >= 64 && (population == Population::elastic) == (points.batch.any_yielding != 0))
    state.SkipWithError("wrong population");
  state.counters["ns/point"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * 1e-9 * static_cast<double>(state.range(0)),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  if (population != Population::elastic && population != Population::softening) return;
  // Fractions of what the machine can do, measured in this run.
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
  const LoadedLaw scalar(QUOIN_SCALAR_LAW);
  std::deque<LoadedLaw> laws;  // materials do not move
  const std::pair<const char*, Population> populations[] = {{"elastic", Population::elastic},
                                                            {"softening", Population::softening},
                                                            {"damaged", Population::damaged},
                                                            {"mixed", Population::mixed},
                                                            {"random", Population::random}};
  const auto add = [&](const std::string& name, const LoadedLaw& law, bool all_sizes) {
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
  // A material keeps the kernels of the instruction set that is the best one when it is made.
  const std::int64_t supported = hwy::SupportedTargets();
  for (const std::int64_t target : {std::int64_t{HWY_SSE4}, std::int64_t{HWY_AVX2}, std::int64_t{HWY_AVX3}}) {
    if ((supported & target) == 0) {
      fmt::print("{}: not on this machine, not measured\n", hwy::TargetName(target));
      continue;
    }
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    laws.emplace_back(shipped);
    add(hwy::TargetName(target), laws.back(), target == HWY_AVX2 || target == HWY_AVX3);
  }
  hwy::SetSupportedTargetsForTest(0);
  // Another build of the law, in the same run: law_benchmark --beside=FILE.so
  const std::string_view beside = "--beside=";
  for (int k = 1; k < argc; ++k) {
    if (!std::string_view(argv[k]).starts_with(beside)) continue;
    laws.emplace_back(std::string(argv[k]).substr(beside.size()));
    add("beside", laws.back(), true);
  }
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
