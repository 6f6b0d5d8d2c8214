#include "scene/masonry_place.h"

#include <algorithm>

#include "random/counter.h"

namespace quoin {

std::uint64_t unit_key(int block, const PlacedBlock& placed) {
  return placed.unit >= 0 ? static_cast<std::uint64_t>(placed.unit) : (1u << 31) + static_cast<std::uint64_t>(block);
}

std::uint64_t joint_key(std::uint64_t unit_a, std::uint64_t unit_b) {
  return (std::min(unit_a, unit_b) << 32) | std::max(unit_a, unit_b);
}

bool lacks_mortar(const JointFamily& family, int block_a, const PlacedBlock& a, int block_b, const PlacedBlock& b) {
  if (family.missing_mortar == 0.0 || family.random.sample == 0) return false;
  const random::Quantity quantity{family.random.seed, family.random.sample,
                                  random::name_of("joints." + family.name + ".missing_mortar")};
  return random::uniform(quantity, joint_key(unit_key(block_a, a), unit_key(block_b, b))) < family.missing_mortar;
}

}  // namespace quoin
