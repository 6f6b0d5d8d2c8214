// Random numbers without a state: each is a function of what it is for. So a sample is the same whichever machine draws
// it, in any order, by any number of threads. Philox 4x64-10 of Salmon et al. (2011), as Random123 has it.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace quoin::random {

// 4 words of 64 random bits.
std::array<std::uint64_t, 4> philox(const std::array<std::uint64_t, 4>& counter,
                                    const std::array<std::uint64_t, 2>& key);

// What a number is for.
struct Quantity {
  std::uint64_t seed = 1;    // seed of the study
  std::uint64_t sample = 0;  // its number
  std::uint64_t name = 0;    // name_of() the quantity
};

// A name as a number: FNV-1a.
std::uint64_t name_of(std::string_view text);

// In (0, 1), 53 bits, for one element (a joint, a unit) of a quantity; never 0 or 1.
double uniform(const Quantity& quantity, std::uint64_t element);
// A normal number of mean 0 and scatter 1.
double normal(const Quantity& quantity, std::uint64_t element);

}  // namespace quoin::random
