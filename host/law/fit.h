// Identification of a law's properties from measured curves of couplets, triplets and prisms. Least squares on the law
// itself, with confidence intervals.
#pragma once

#include <string>
#include <vector>

#include "law/csv_table.h"
#include "law/law_library.h"

namespace quoin {

enum class TestKind {
  couplet,  // columns dn, sigma: opening, m, and tensile stress, Pa
  triplet,  // columns ds, tau, sigma: slip, m, shear stress and constant normal stress, Pa
  prism     // columns dn, sigma: closing of the joint, m (< 0), and stress, Pa (< 0)
};

struct MeasuredCurve {
  TestKind kind = TestKind::couplet;
  std::string file;
  std::vector<double> jump;    // dn or ds
  std::vector<double> stress;  // sigma or tau
  std::vector<double> normal;  // triplet: sigma
};

// Reads a curve. Throws Error(bad_input) with file, line and value.
MeasuredCurve read_curve(TestKind kind, const std::string& file);

struct FittedProperty {
  std::string id, symbol, unit;
  double value = 0.0;
  double low = 0.0, high = 0.0;  // bounds of the 95 % confidence interval
};

struct FitResult {
  std::vector<FittedProperty> properties;
  std::vector<std::vector<double>> model;  // stress of the fitted law, by curve and row
  std::vector<double> noise;               // standard deviation of the residuals, by curve, Pa
  int iterations = 0;
  std::vector<PropertySetting> settings;  // given and fitted properties, as settings of a material
  bool no_cohesion = false;               // the curves show friction alone; settings has a cohesion of 0
  std::vector<std::string> notes;         // what the curves do not determine
};

// Fits the properties that the curves determine. Couplets give tensile_strength and fracture_energy_tension, prisms
// compressive_strength and fracture_energy_compression. Triplets give cohesion and fracture_energy_shear. They give
// friction_angle with at least two confinements, or with curves that reach their residual stress. What the law does not
// have is left out. A cohesion whose interval holds 0 is 0, without a fracture energy. given: values of all other
// properties, at least the stiffnesses; given properties are not fitted. The method is Levenberg-Marquardt in the
// logarithm of each property (of tan for the angle), with curves weighted by their own noise. Throws Error(bad_input)
// for curves that determine nothing, Error(numerical) without convergence.
FitResult fit_properties(const Law& law, const std::vector<MeasuredCurve>& curves,
                         const std::vector<PropertySetting>& given);

// Plots measured and fitted curves side by side to FOLDER/fit.png; returns the file's name.
std::string plot_fit(const std::vector<MeasuredCurve>& curves, const FitResult& result, const std::string& folder);

}  // namespace quoin
