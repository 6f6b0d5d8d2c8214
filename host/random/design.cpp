#include "random/design.h"

#include <boost/random/sobol.hpp>
#include <cmath>

#include "random/counter.h"

namespace quoin::random {

namespace {

// Rank of `sample` among all samples, ordered by a random number each: a permutation without a stored list.
std::uint64_t rank(std::uint64_t seed, std::uint64_t dimension, std::uint64_t sample, std::uint64_t samples) {
  const auto number = [&](std::uint64_t i) { return uniform({seed, i, name_of("latin hypercube")}, dimension); };
  const double own = number(sample);
  std::uint64_t before = 0;
  for (std::uint64_t i = 1; i <= samples; ++i) {
    const double other = number(i);
    before += other < own || (other == own && i < sample) ? 1 : 0;
  }
  return before;
}

}  // namespace

const char* method_name(Method method) {
  switch (method) {
    case Method::monte_carlo:
      return "monte_carlo";
    case Method::latin_hypercube:
      return "latin_hypercube";
    case Method::sobol:
      return "sobol";
  }
  return "?";
}

double Design::at(std::uint64_t sample, std::uint64_t dimension) const {
  switch (method) {
    case Method::monte_carlo:
      break;
    case Method::latin_hypercube: {
      const double within = uniform({seed, sample, name_of("within a stratum")}, dimension);
      const double place = static_cast<double>(rank(seed, dimension, sample, samples)) + within;
      return place / static_cast<double>(samples);
    }
    case Method::sobol: {
      boost::random::sobol sequence(dimensions);
      sequence.discard((sample - 1) * dimensions + dimension);
      const double point = (static_cast<double>(sequence() >> 11) + 0.5) * 0x1p-53;
      const double moved = point + uniform({seed, 0, name_of("shift of the sequence")}, dimension);
      return moved < 1.0 ? moved : std::fmax(moved - 1.0, 0x1p-54);
    }
  }
  return uniform({seed, sample, name_of("monte carlo")}, dimension);
}

}  // namespace quoin::random
