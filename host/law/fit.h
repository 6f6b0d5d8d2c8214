// Identification of a law's properties from measured curves of couplets, triplets and prisms: least squares on the law
// itself, with confidence intervals.
#pragma once

#include <string>
#include <vector>

#include "law/csv_table.h"
#include "law/law_library.h"

namespace quoin {

enum class TestKind {
  couplet,  // columns dn, sigma: opening, m, and tensile stress, Pa
  triplet,  // columns ds, tau, sigma: sliding, m, shear stress, Pa, and the normal stress held meanwhile (compression <
            // 0)
  prism     // columns dn, sigma: closing of the joint, m (< 0), and its stress, Pa (< 0)
};

struct MeasuredCurve {
  TestKind kind = TestKind::couplet;
  std::string file;
  std::vector<double> jump;    // dn or ds
  std::vector<double> stress;  // sigma or tau
  std::vector<double> normal;  // triplet: sigma
};

// Throws Error(bad_input) with file, line and value.
MeasuredCurve read_curve(TestKind kind, const std::string& file);

struct FittedProperty {
  std::string id, symbol, unit;
  double value = 0.0;
  double low = 0.0, high = 0.0;  // 95 % confidence
};

struct FitResult {
  std::vector<FittedProperty> properties;
  std::vector<std::vector<double>> model;  // stress of the fitted law, by curve and row
  std::vector<double> noise;               // standard deviation of measured less fitted, by curve, Pa
  int iterations = 0;
  std::vector<PropertySetting> settings;  // given and fitted, ready to make the material
};

// Fits the properties that the curves determine. Couplets give tensile_strength and fracture_energy_tension, prisms
// compressive_strength and fracture_energy_compression. Triplets give cohesion, fracture_energy_shear and
// friction_angle, this one with two confinements at least, or curves that reach their residual. given: all others, the
// stiffnesses at least. A property that is given is not fitted. Levenberg-Marquardt in the logarithm of each property
// (of tan for the angle), curves weighted by their own noise. Throws Error(bad_input): curves that determine nothing;
// Error(numerical): no convergence.
FitResult fit_properties(const Law& law, const std::vector<MeasuredCurve>& curves,
                         const std::vector<PropertySetting>& given);

// Measured and fitted curves side by side, FOLDER/fit.png; returns the picture's name.
std::string plot_fit(const std::vector<MeasuredCurve>& curves, const FitResult& result, const std::string& folder);

}  // namespace quoin
