// Prints what one core of this machine can do now.
#include <fmt/core.h>

#include "machine_limits.h"

int main() { fmt::print("{}\n", quoin::benchmarks::describe(quoin::benchmarks::measure_limits())); }
