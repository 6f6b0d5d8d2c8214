// Parameters and random paths for tests of the fracture-energy law and of its reference.
#pragma once

#include <array>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "law/material_point.h"
#include "reference_law.h"

namespace quoin::test {

using Random = std::mt19937_64;

double uniform(Random& random, double low, double high);
double log_uniform(Random& random, double low, double high);

// A parameter set in which every property is given, without defaults.
struct Case {
  reference::Parameters p;
  bool dry = false;

  std::vector<PropertySetting> settings() const;
  std::shared_ptr<const Material> material() const;  // material of the law $QUOIN_TEST_LAW, default fracture_energy
  MaterialPoint point() const;
  reference::Point reference_point() const { return reference::Point(p, dry); }
  std::string text() const;

  // Lengths of contact_models/fracture_energy/LAW.md, m, computed here by its formulas.
  double area() const, max_slope() const;
  double u0() const, lt() const, su() const, wu() const;
  double end() const;  // xi at which f is 0, or where an exponential has become negligible (e^-8)
  double f(double xi) const;
  double mu0() const, mur() const, tan_psi() const;
  // Returns the largest of |S'|/ks and |F'|/kn; 1 is snap-back.
  double nearness() const;
  // Largest d_n and slip of random paths, m.
  double opening_range() const, closing_range() const, sliding_range() const;
  double shear_scale() const, normal_scale() const;  // scales of errors of stress, Pa
  // Returns the largest decrease of S along the slip where uplift crushes the joint, kn mu0 tan(psi0) q/(1 - q), Pa/m.
  double fall_by_uplift() const;
  // Returns the shear strength at a state, Pa, by the formulas of the law's page.
  double shear_strength(double e, double sigma, double xi) const;
};

// Returns joints like those of the Eindhoven walls (Table 1 of the paper, orders of magnitude), the base of other
// cases.
Case mortar();

// Returns a random admissible set: modes with and without drop, all shapes, couplings, residuals, dilation, crushing.
// The smallest ratio of a fracture energy to its bound is margin, > 1.
Case random_case(Random& random, double margin = 1.3);

struct Jump {
  double dn, ds, dt;
};
// Returns the number of sub-steps from one corner to the next: at least 1000, enough to resolve every softening length,
// times refinement.
int substeps_between(const Case& c, const Jump& from, const Jump& to, int refinement);
// Returns corners of a random path: opening and closing through zero, crushing, slip in changing directions, pauses.
std::vector<Jump> random_path(const Case& c, Random& random, int corners);

std::string law_under_test();
// Returns the factor on numbers of random paths: 1 in ctest, $QUOIN_TEST_SCALE in long runs.
double test_scale();

}  // namespace quoin::test
