#include "random/counter.h"

#include <Random123/philox.h>

#include "base/fnv_hash.h"
#include "random/distribution.h"

namespace quoin::random {

std::array<std::uint64_t, 4> philox(const std::array<std::uint64_t, 4>& counter,
                                    const std::array<std::uint64_t, 2>& key) {
  const r123::Philox4x64::ctr_type c{{counter[0], counter[1], counter[2], counter[3]}};
  const r123::Philox4x64::key_type k{{key[0], key[1]}};
  const r123::Philox4x64::ctr_type r = r123::Philox4x64()(c, k);
  return {r[0], r[1], r[2], r[3]};
}

std::uint64_t name_of(std::string_view text) {
  FnvHash hash;
  hash.add(text);
  return hash.value();
}

double uniform(const Quantity& quantity, std::uint64_t element) {
  constexpr std::uint64_t kOfThisProject = 0x51554f494eu;  // "QUOIN"
  const std::uint64_t bits = philox({element, quantity.name, quantity.sample, 0}, {quantity.seed, kOfThisProject})[0];
  return (static_cast<double>(bits >> 11) + 0.5) * 0x1p-53;
}

double normal(const Quantity& quantity, std::uint64_t element) { return normal_quantile(uniform(quantity, element)); }

}  // namespace quoin::random
