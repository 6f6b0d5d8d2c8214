// A law replaced by another one in mid-run, with the traction of every contact point kept.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "law/law_library.h"
#include "scene/scene.h"
#include "step/simulation.h"

namespace quoin {

// Contact points of one joint family, all or some, as their law has left them; borrowed. Lattice and blocks of any
// shape keep them in different places, but both as plain columns.
struct FamilyColumns {
  std::size_t count = 0;
  const double* opening = nullptr;          // opening at the standing tractions, m
  std::array<const double*, 3> traction{};  // Pa
  std::vector<const double*> state;         // states of the old law, in its order
  const double* area = nullptr;             // m2
};

// Sums over points that have changed their law.
struct SwapSums {
  long points = 0, limited = 0;
  double stored_before = 0.0, energy_jump = 0.0;  // J
  void add(const SwapSums& more) {
    points += more.points, limited += more.limited;
    stored_before += more.stored_before, energy_jump += more.energy_jump;
  }
};
LawSwap report_of(const std::string& family, const Material& from, const Material& to, const SwapSums& sums);

// What the new law makes of them.
struct MigratedFamily {
  std::vector<double> state;          // columns of the new law, one after the other
  std::vector<double> opening_shift;  // by point, m: added to the opening of the new law from now on
  std::vector<SwapSums> terms;        // by point
  SwapSums sums(std::size_t first, std::size_t count) const;  // sums over contiguous points, in their order
};

// The material of the law that takes over a family, with those of the family's properties that the law has. Throws
// Error(law_refused): no such law, properties that it refuses, or a law that cannot take over the state of another one.
std::shared_ptr<const Material> successor(const JointFamily& family, const std::string& law);

// Hands the points of a family over. Throws Error(law_refused) with the law's reason and the number of points that it
// refuses; nothing has changed then.
MigratedFamily migrate(const JointFamily& family, const Material& from, const Material& to,
                       const FamilyColumns& points);

}  // namespace quoin
