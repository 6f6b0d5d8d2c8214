// Law swap: another law replaces that of a joint family in mid-run, and every contact point keeps its traction.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "law/at_rest.h"
#include "law/law_library.h"
#include "scene/scene.h"
#include "step/state.h"

namespace quoin {

// Columns of the contact points of one joint family, all or some, after the old law's last call; borrowed. The lattice
// and large motion hold them in different places, both as plain columns.
struct FamilyColumns : RestingPoints {  // without properties that scatter
  const double* area = nullptr;         // m2
};

// Sums over contact points of a swap.
struct SwapSums {
  long points = 0, limited = 0;  // number of points; of points that the new law represents in part alone
  double stored_before = 0.0, energy_jump = 0.0;  // J
  void add(const SwapSums& more) {
    points += more.points, limited += more.limited;
    stored_before += more.stored_before, energy_jump += more.energy_jump;
  }
};
LawSwap report_of(const std::string& family, const Material& from, const Material& to, const SwapSums& sums);

// States and openings of these points under the new law.
struct MigratedFamily {
  std::vector<double> state;          // one column a state of the new law, column after column
  std::vector<double> opening_shift;  // by point, m: added to the opening that the new law receives
  std::vector<SwapSums> terms;        // by point
  SwapSums sums(std::size_t first, std::size_t count) const;  // sums over contiguous points, in their order
};

// The material of the law that replaces that of a family, with those of the family's properties that it has. Throws
// Error(law_refused): no such law, refused properties, or a law that cannot take states of another one.
std::shared_ptr<const Material> successor(const JointFamily& family, const std::string& law);

// Converts the states of the old law to those of the new one. Throws Error(law_refused), with the law's reason and the
// number of points that it refuses; nothing has changed then.
MigratedFamily migrate(const JointFamily& family, const Material& from, const Material& to,
                       const FamilyColumns& points);

// On the lattice, where each rank swaps its own contact points: a law evaluates each point independently.
// Takes the bounds of the law's stiffness for a joint family where they are larger than those so far, which choose the
// time step. Returns whether one is.
bool take_stiffness(Simulation::Impl& s, std::size_t f, const Material& material);
void swap_lattice_law(Simulation::Impl& s, std::size_t f, std::shared_ptr<const Material> material);

}  // namespace quoin
