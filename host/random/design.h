// Designs of experiments: positions of a study's samples in the unit cube.
#pragma once

#include <cstdint>
#include <string>

namespace quoin::random {

// monte_carlo: independent samples. latin_hypercube: of N samples one in each N-th of every quantity. sobol: the
// sequence of Sobol (directions of Joe and Kuo), shifted by a random vector (modulo 1) so that its mean has no bias.
enum class Method { monte_carlo, latin_hypercube, sobol };

const char* method_name(Method method);  // "latin_hypercube"

struct Design {
  Method method = Method::monte_carlo;
  std::uint64_t seed = 1;
  std::uint64_t samples = 0;  // N of latin_hypercube, 1e6 at most
  std::uint64_t dimensions = 0;

  // Coordinate in (0, 1) of sample 1, 2, ... in dimension 0, 1, ... It does not depend on the order of calls.
  double at(std::uint64_t sample, std::uint64_t dimension) const;
};

inline constexpr std::uint64_t kMostSobolDimensions = 1000;

}  // namespace quoin::random
