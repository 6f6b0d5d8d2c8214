// Prints the limits of one core of this machine.
#include <fmt/core.h>

#include "machine_limits.h"

int main() { fmt::print("{}\n", quoin::benchmarks::describe(quoin::benchmarks::measure_limits())); }
