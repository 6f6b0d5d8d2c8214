// What one core of this machine can do at best (a roofline), at the instruction set that the kernels are dispatched to.
// It is measured in the same run as whatever is compared with it, since machines that are shared drift.
#pragma once

#include <cstddef>
#include <string>

namespace quoin::benchmarks {

// Independent multiply-adds of doubles out of registers, flop/s; a multiply-add counts as two.
double multiply_add_peak();

// y = a x + y over two columns that fill working_set bytes together: bytes loaded and stored a second (24 an element,
// 16 in, 8 out). Choose the working set for the level of memory: half of a cache, or several times the last one.
double bandwidth(std::size_t working_set);

struct Limits {
  std::string instruction_set;
  double flops = 0.0;                                      // flop/s
  double level_1 = 0.0, level_2 = 0.0, main_memory = 0.0;  // bytes/s
};

// All of them, in about a second.
Limits measure_limits();

// One line: instruction set, Gflop/s, GB/s by level.
std::string describe(const Limits& limits);

}  // namespace quoin::benchmarks
