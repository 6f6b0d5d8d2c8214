#include "machine_limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "hwy/aligned_allocator.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "machine_limits.cpp"
#include "hwy/foreach_target.h"  // IWYU pragma: keep

// After foreach_target.h, which includes this file once for every instruction set.
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::benchmarks::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<double, 8>;
using V = hn::Vec<D>;

// Number of independent sums: enough to hide the latency of two units, few enough for sixteen registers.
constexpr int kChains = 10;

// Computes `rounds` multiply-adds in each chain. Returns the number of operations.
double multiply_adds(std::size_t rounds, double factor, double term, double* sum) {
  const D d;
  const V a = hn::Set(d, factor), b = hn::Set(d, term);
  V c0 = hn::Iota(d, 0), c1 = hn::Iota(d, 1), c2 = hn::Iota(d, 2), c3 = hn::Iota(d, 3), c4 = hn::Iota(d, 4);
  V c5 = hn::Iota(d, 5), c6 = hn::Iota(d, 6), c7 = hn::Iota(d, 7), c8 = hn::Iota(d, 8), c9 = hn::Iota(d, 9);
  for (std::size_t k = 0; k < rounds; ++k) {
    c0 = hn::MulAdd(a, c0, b), c1 = hn::MulAdd(a, c1, b), c2 = hn::MulAdd(a, c2, b), c3 = hn::MulAdd(a, c3, b);
    c4 = hn::MulAdd(a, c4, b), c5 = hn::MulAdd(a, c5, b), c6 = hn::MulAdd(a, c6, b), c7 = hn::MulAdd(a, c7, b);
    c8 = hn::MulAdd(a, c8, b), c9 = hn::MulAdd(a, c9, b);
  }
  const V all = hn::Add(hn::Add(hn::Add(c0, c1), hn::Add(c2, c3)),
                        hn::Add(hn::Add(c4, c5), hn::Add(hn::Add(c6, c7), hn::Add(c8, c9))));
  *sum = hn::GetLane(hn::SumOfLanes(d, all));
  return 2.0 * kChains * static_cast<double>(rounds * hn::Lanes(d));
}

// Computes y += a x, four vectors in each round of the loop; count is a multiple of four vectors.
void scaled_sum(double a, const double* x, double* y, std::size_t count) {
  const D d;
  const V factor = hn::Set(d, a);
  const std::size_t lanes = hn::Lanes(d);
  const auto one = [&](std::size_t k) {
    hn::StoreU(hn::MulAdd(factor, hn::LoadU(d, x + k), hn::LoadU(d, y + k)), d, y + k);
  };
  for (std::size_t i = 0; i < count; i += 4 * lanes) {
    one(i), one(i + lanes), one(i + 2 * lanes), one(i + 3 * lanes);
  }
}

const char* instruction_set() { return hwy::TargetName(HWY_TARGET); }

}  // namespace quoin::benchmarks::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace quoin::benchmarks {

HWY_EXPORT(multiply_adds);
HWY_EXPORT(scaled_sum);
HWY_EXPORT(instruction_set);

namespace {

// Returns the best rate of many short runs: the limit without the influence of other programs.
template <class Work>
double best_rate(const Work& work) {
  double best = 0.0;
  for (int run = 0; run < 25; ++run) {
    const auto start = std::chrono::steady_clock::now();
    const double amount = work();
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    best = std::max(best, amount / seconds.count());
  }
  return best;
}

}  // namespace

double multiply_add_peak() {
  // Volatile, so that the compiler does not remove a run. The sequence c = a c + b converges to 1: no denormal numbers.
  volatile double factor = 0.5, term = 0.5, sum = 0.0;
  return best_rate([&] {
    double total = 0.0;
    const double operations = HWY_DYNAMIC_DISPATCH(multiply_adds)(1000000, factor, term, &total);
    sum = total;
    return operations;
  });
}

double bandwidth(std::size_t working_set) {
  constexpr std::size_t kTurn = 32;  // four of the widest vectors
  const std::size_t count = std::max<std::size_t>(1, working_set / (2 * sizeof(double)) / kTurn) * kTurn;
  // Aligned to cache lines, with an extra quarter of a page between the columns: they use different sets of a cache.
  const auto memory = hwy::AllocateAligned<double>(2 * count + 128);
  std::fill_n(memory.get(), 2 * count + 128, 1.0);
  const double* x = memory.get();
  double* y = memory.get() + count + 128;
  const std::size_t passes = std::max<std::size_t>(1, (std::size_t{1} << 22) / count);
  volatile double factor = 0.0;
  return best_rate([&] {
    for (std::size_t pass = 0; pass < passes; ++pass) HWY_DYNAMIC_DISPATCH(scaled_sum)(factor, x, y, count);
    return 3.0 * sizeof(double) * static_cast<double>(count * passes);
  });
}

Limits measure_limits() {
  return {HWY_DYNAMIC_DISPATCH(instruction_set)(), multiply_add_peak(), bandwidth(std::size_t{1} << 14),
          bandwidth(std::size_t{1} << 18), bandwidth(std::size_t{1} << 28)};
}

std::string describe(const Limits& limits) {
  return fmt::format(
      "{}, one core: {:.1f} Gflop/s (multiply-add), {:.0f} GB/s in L1 (16 KiB), {:.0f} in L2 (256 KiB), "
      "{:.1f} in memory (256 MiB)",
      limits.instruction_set, 1e-9 * limits.flops, 1e-9 * limits.level_1, 1e-9 * limits.level_2,
      1e-9 * limits.main_memory);
}

}  // namespace quoin::benchmarks
#endif
