// Random numbers without a state: each is a function of its purpose. So a sample does not depend on the machine, the
// order or the number of threads. Philox 4x64-10 of Salmon et al. (2011), as in Random123.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace quoin::random {

// Four words of 64 random bits.
std::array<std::uint64_t, 4> philox(const std::array<std::uint64_t, 4>& counter,
                                    const std::array<std::uint64_t, 2>& key);

// Purpose of a random number.
struct Quantity {
  std::uint64_t seed = 1;    // seed of the study
  std::uint64_t sample = 0;  // number of the sample
  std::uint64_t name = 0;    // name_of() of the quantity
};

// Hash of a name: FNV-1a.
std::uint64_t name_of(std::string_view text);

// Number in (0, 1) with 53 bits for one element (a joint, a unit) of a quantity; never 0 or 1.
double uniform(const Quantity& quantity, std::uint64_t element);
// Normal number of mean 0 and scatter 1.
double normal(const Quantity& quantity, std::uint64_t element);

}  // namespace quoin::random
