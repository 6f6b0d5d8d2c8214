#include "random/design.h"

#include <algorithm>
#include <boost/random/sobol.hpp>
#include <cmath>
#include <utility>

#include "random/counter.h"

namespace quoin::random {

namespace {

// Rank of each sample among all, ordered by a random number each.
std::vector<std::uint32_t> ranks(std::uint64_t seed, std::uint64_t dimension, std::uint64_t samples) {
  std::vector<std::pair<double, std::uint32_t>> order(samples);
  for (std::uint32_t i = 0; i < samples; ++i)
    order[i] = {uniform({seed, i + 1, name_of("latin hypercube")}, dimension), i};
  std::sort(order.begin(), order.end());
  std::vector<std::uint32_t> rank(samples);
  for (std::uint32_t before = 0; before < samples; ++before) rank[order[before].second] = before;
  return rank;
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

Design::Design(Method method, std::uint64_t seed, std::uint64_t samples, std::uint64_t dimensions)
    : method_(method), seed_(seed), samples_(samples), dimensions_(dimensions) {
  if (method != Method::latin_hypercube) return;
  for (std::uint64_t d = 0; d < dimensions; ++d) rank_.push_back(ranks(seed, d, samples));
}

double Design::at(std::uint64_t sample, std::uint64_t dimension) const {
  switch (method_) {
    case Method::monte_carlo:
      break;
    case Method::latin_hypercube: {
      const double within = uniform({seed_, sample, name_of("within a stratum")}, dimension);
      const double place = rank_[dimension][sample - 1] + within;
      return place / static_cast<double>(samples_);
    }
    case Method::sobol: {
      boost::random::sobol sequence(dimensions_);
      sequence.discard((sample - 1) * dimensions_ + dimension);
      const double point = (static_cast<double>(sequence() >> 11) + 0.5) * 0x1p-53;
      const double moved = point + uniform({seed_, 0, name_of("shift of the sequence")}, dimension);
      return moved < 1.0 ? moved : std::fmax(moved - 1.0, 0x1p-54);
    }
  }
  return uniform({seed_, sample, name_of("monte carlo")}, dimension);
}

}  // namespace quoin::random
