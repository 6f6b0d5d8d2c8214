// Random joints and steps for tests of the cyclic joint law, and evaluation of the law at many points.
#pragma once

#include <random>
#include <string>
#include <vector>

#include "page_update.h"
#include "rates.h"
#include "tests/kernels/plugin.h"

namespace quoin::cyclic {

using Random = std::mt19937_64;

inline double uniform(Random& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
}
inline double log_uniform(Random& random, double low, double high) {
  return std::exp(uniform(random, std::log(low), std::log(high)));
}
inline bool chance(Random& random, double probability) { return uniform(random, 0.0, 1.0) < probability; }

// Returns the factor on numbers of random joints: 1 in ctest, $QUOIN_TEST_SCALE in long runs.
double test_scale();

// Returns Table 1 of the paper with the starting values of the law's page.
Joint mortar();
// Returns a random admissible joint. Energies are at least margin times their bounds; stiffnesses, strengths and
// lengths are 1/spread to spread times those of masonry.
Joint random_joint(Random& random, double margin, double spread = 1.0);
bool admissible(const Joint& joint);

quoin::test::Values values_of(const Joint& joint);
cyclic_rates::Parameters rates_of(const Joint& joint);
std::string text_of(const Joint& joint);

// Lengths of random steps, m: opening, closing, slip.
struct Reach {
  double open, close, slide;
};
Reach reach_of(const Joint& joint);
double normal_scale(const Joint& joint);
double shear_scale(const Joint& joint);

// contact_models/cyclic_joint/LAW.md, "What must hold", 4, for the traction at the end of a step.
struct Surfaces {
  double over;   // excess of the traction over the strengths, Pa
  double scale;  // scale of rounding, Pa
};
Surfaces beyond_surfaces(const Joint& joint, const History& state, double sigma, double tau, double d_n, double trial);
// "What must hold", 7: returns the name of a state beyond its bound, or null.
const char* beyond_bounds(const Joint& joint, const History& state);

// The law at many points, with all outputs.
struct LawPoints {
  quoin::api::Material material;
  quoin::test::Batch batch;
  LawPoints(const quoin_law& law, const Joint& joint, std::size_t count, bool dry);
  History history(std::size_t i) const;  // old state of point i
  double out(std::size_t k, std::size_t i) const { return batch.out[k][i]; }
  double state(int k, std::size_t i) const { return batch.out[3 + k][i]; }
  double stored(std::size_t i) const { return batch.out[3 + batch.states][i]; }
  double dissipated(int mode, std::size_t i) const { return batch.out[4 + batch.states + mode][i]; }
  double tangent(int entry, std::size_t i) const { return batch.out[8 + batch.states + entry][i]; }
};

}  // namespace quoin::cyclic
