// Limits of one core (a roofline) with the instruction set of the kernels. Measured in the same run as the results that
// are compared with them, since the speed of shared machines drifts.
#pragma once

#include <cstddef>
#include <string>

namespace quoin::benchmarks {

// Returns the rate of independent multiply-adds of doubles in registers, flop/s; a multiply-add counts as two.
double multiply_add_peak();

// Returns the bandwidth of y = a x + y over two columns of working_set bytes together, in bytes/s: 24 for each element,
// 16 loaded and 8 stored. For a cache, working_set is half its size; for main memory, several times the last cache.
double bandwidth(std::size_t working_set);

struct Limits {
  std::string instruction_set;
  double flops = 0.0;                                      // flop/s
  double level_1 = 0.0, level_2 = 0.0, main_memory = 0.0;  // bytes/s
};

// Measures all limits, in about a second.
Limits measure_limits();

// Returns one line: instruction set, Gflop/s, GB/s by level.
std::string describe(const Limits& limits);

}  // namespace quoin::benchmarks
