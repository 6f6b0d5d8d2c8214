// Designs of experiments: positions of a study's samples in the unit cube.
#pragma once

#include <cstdint>
#include <vector>

namespace quoin::random {

// monte_carlo: independent samples. latin_hypercube: of N samples one in each N-th of every quantity. sobol: the
// sequence of Sobol (directions of Joe and Kuo), shifted by a random vector (modulo 1) so that its mean has no bias.
enum class Method { monte_carlo, latin_hypercube, sobol };

const char* method_name(Method method);  // "latin_hypercube"

class Design {
 public:
  // samples: N of latin_hypercube, 1e6 at most, whose ranks take N log N in each dimension.
  Design(Method method, std::uint64_t seed, std::uint64_t samples, std::uint64_t dimensions);

  // Coordinate in (0, 1) of sample 1, 2, ... in dimension 0, 1, ... It does not depend on the order of calls.
  double at(std::uint64_t sample, std::uint64_t dimension) const;

 private:
  Method method_;
  std::uint64_t seed_, samples_, dimensions_;
  std::vector<std::vector<std::uint32_t>> rank_;  // of latin_hypercube, by dimension and sample
};

inline constexpr std::uint64_t kMostSobolDimensions = 1000;

}  // namespace quoin::random
