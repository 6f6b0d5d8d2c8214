// Parameters and random paths for tests of the fracture-energy law, as the law and as the reference take them.
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

// A parameter set; every property given, none left to a default.
struct Case {
  reference::Parameters p;
  bool dry = false;

  std::vector<PropertySetting> settings() const;
  std::shared_ptr<const Material> material() const;  // of $QUOIN_TEST_LAW, default fracture_energy
  MaterialPoint point() const;
  reference::Point reference_point() const { return reference::Point(p, dry); }
  std::string text() const;

  // Lengths of contact_models/fracture_energy/LAW.md, computed here from its text
  double area() const, max_slope() const;
  double u0() const, lt() const, su() const, wu() const;
  double end() const;  // xi at which f is 0, or where an exponential has become negligible (e^-8)
  double f(double xi) const;
  double mu0() const, mur() const, tan_psi() const;
  // The largest |S'|/ks, |F'|/kn: 1 is snap-back
  double nearness() const;
  // Largest d_n and slip that a random path should reach
  double opening_range() const, closing_range() const, sliding_range() const;
  double shear_scale() const, normal_scale() const;  // strengths that errors are measured against
  // Most by which S falls along the slip where uplift crushes the joint, kn mu0 tan(psi0) q/(1 - q), Pa/m
  double fall_by_uplift() const;
  // Shear strength at a state, from the words of that page
  double shear_strength(double e, double sigma, double xi) const;
};

// The joints of the Eindhoven walls (paper, Table 1 orders of magnitude), the base of hand-made cases.
Case mortar();

// Any admissible set: modes with and without drop, all shapes, couplings, residuals, dilation, crushing. margin > 1:
// every fracture energy over its bound, at least.
Case random_case(Random& random, double margin = 1.3);

struct Jump {
  double dn, ds, dt;
};
// Sub-steps from one corner to the next: at least 1000, and enough to resolve every softening length; refinement times
// as many.
int substeps_between(const Case& c, const Jump& from, const Jump& to, int refinement);
// Corners of a random path: opening and closing through zero, crushing, slip in turning directions, holds.
std::vector<Jump> random_path(const Case& c, Random& random, int corners);

std::string law_under_test();
// 1 in ctest; $QUOIN_TEST_SCALE multiplies numbers of random paths in long runs.
double test_scale();

}  // namespace quoin::test
