// A Quoin law as a cohesive zone model of MFront's generic interface. The gradient is the total opening displacement
// (n, t1, t2), Quoin's d_n, d_s, d_t. The thermodynamic force is the cohesive force (n, t1, t2), tension positive,
// Quoin's sigma, tau_s, tau_t. The slip of a step is the difference of the total displacements. In plane strain there
// is no slip out of the plane: both are (n, t1), and K has 2 x 2 numbers.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "mgis/behaviour_data.h"
#include "shared/material.h"

namespace quoin::mgis {

enum class Hypothesis { plane_strain = 2, tridimensional = 3 };  // the number of components

// One behaviour of a generated library. The law is loaded at the first call and kept.
class Behaviour {
 public:
  // state_schema, properties: those of the law when the symbols were generated. energies: true if energies are computed
  // where the host provides memory for them.
  constexpr Behaviour(const char* law, std::uint64_t state_schema, const char* const* properties,
                      std::size_t property_count, bool energies)
      : law_name_(law),
        state_schema_(state_schema),
        properties_(properties),
        property_count_(property_count),
        energies_(energies) {}

  // Computes one step; may be called from several threads with different data.
  int integrate(BehaviourData& data, Hypothesis hypothesis) const noexcept;
  // Fills in the internal state variables of data.s1.
  int initialize(BehaviourData& data, const char* initial_state) const noexcept;

 private:
  const quoin_law& law() const;
  const quoin_law& find_law() const;

  const char* law_name_;
  std::uint64_t state_schema_;
  const char* const* properties_;
  std::size_t property_count_;
  bool energies_;
  mutable std::atomic<const quoin_law*> law_{nullptr};
};

}  // namespace quoin::mgis
