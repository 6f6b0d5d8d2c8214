#include "properties/from_tests.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.h"

namespace quoin {

namespace {

constexpr double kMPa = 1e6, kMm = 1e-3;

// Defaults of a kind of unit, for missing tests.
struct KindOfUnit {
  UnitKind kind;
  double strength;          // Pa, of the unit
  double k_mortar, k_thin;  // K of EN 1996-1-1, table 3.3, units of group 1 (hollow clay: group 2)
  double thin_power;        // exponent of the unit's strength with thin joints, EN 1996-1-1, 3.6.1.2
  double density;           // kg/m3
};
constexpr KindOfUnit kKinds[] = {{UnitKind::clay, 20 * kMPa, 0.55, 0.75, 0.85, 1800},
                                 {UnitKind::hollow_clay, 12 * kMPa, 0.45, 0.70, 0.7, 1000},
                                 {UnitKind::calcium_silicate, 20 * kMPa, 0.55, 0.80, 0.85, 1900},
                                 {UnitKind::concrete, 10 * kMPa, 0.55, 0.80, 0.85, 2000},
                                 {UnitKind::aerated_concrete, 4 * kMPa, 0.55, 0.80, 0.85, 600},
                                 {UnitKind::stone, 60 * kMPa, 0.45, 0.75, 0.85, 2500}};

constexpr double kPoisson = 0.2;
constexpr double kMortarStrength = 5 * kMPa;        // M5, without a test
constexpr double kMeanOverCharacteristic = 1.2;     // EN 1052-1: fk = f/1.2
constexpr double kShearOfCharacteristic = 0.8;      // EN 1052-3: characteristic = 0.8 of the mean
constexpr double kModulusOverStrength = 550.0;      // modulus over strength of masonry, Kaushik, Rai and Jain (2007)
constexpr double kUnitModulusOverStrength = 300.0;  // modulus over strength of units, Kaushik, Rai and Jain (2007)
constexpr double kLeastStiffer = 2.0;  // unit over masonry modulus, so that the joint has a share [assumed]
constexpr double kStiffestBed = 1e12;  // Pa/m; a stiffer joint does not change the stiffness of a block [assumed]
constexpr double kFriction = 0.7;      // van der Pluijm (1999): sliding friction of clay masonry 0.7 to 0.8
constexpr double kBondOverCohesion = 2.0 / 3.0;             // Table 1 and Table 3 of the paper
constexpr double kTensionLength = 0.075 * kMm;              // G1/ft: 15 J/m2 at 0.2 MPa, Table 1
constexpr double kLeastTension = 5.0, kMostTension = 20.0;  // J/m2, van der Pluijm (1999); least: Table 3
constexpr double kShearLength = 0.2 * kMm;      // G2/c: between 0.1 mm (Angelillo et al. 2014) and 0.42 mm (Table 1)
constexpr double kCrushingLength = 1.6 * kMm;   // Gc/fc below 12 MPa, Angelillo et al. (2014)
constexpr double kUnitTension = 0.05;           // tensile over compressive strength of units, Angelillo et al. (2014)
constexpr double kUnitFriction = 35.0;          // deg, Table 1 and Table 3
constexpr double kUnitShearLength = 0.1 * kMm;  // G2/c, Angelillo et al. (2014)
constexpr double kUnitStiffness = 6.0;          // stiffness of joints inside units over that of bed joints, Table 3
constexpr double kUnfilledStiffness = 0.1;      // stiffness of unfilled head joints over that of filled ones [assumed]
// Stiffness of dry joints at 0.5 MPa, Pa/m. It is proportional to the square root of pressure, as the pressure on rough
// faces grows with the square of their closure. Both are fitted to six dry walls together
// (host/validate/dry_walls.csv).
constexpr double kDryStiffness = 8e9, kDryPressure = 0.5 * kMPa;
constexpr double kLeastDryPressure = 0.05 * kMPa;

const KindOfUnit& kind_of(UnitKind kind) {
  return *std::find_if(std::begin(kKinds), std::end(kKinds), [&](const KindOfUnit& k) { return k.kind == kind; });
}

// Fracture energy of compression, J/m2; fc in Pa. Angelillo et al. (2014), after the Model Code 1990, which ends at 80
// MPa.
double crushing_energy(double fc) {
  const double mpa = std::min(fc / kMPa, 80.0);
  return mpa < 12.0 ? kCrushingLength * fc : 1e3 * (15.0 + 0.43 * mpa - 0.0036 * mpa * mpa);
}
double degrees(double tangent) { return std::atan(tangent) * 180.0 / std::numbers::pi; }

// Characteristic cohesion of EN 1996-1-1, table 3.4, Pa.
double code_cohesion(UnitKind unit, JointKind joint, double mortar) {
  const bool clay = unit == UnitKind::clay || unit == UnitKind::hollow_clay;
  if (joint == JointKind::thin) return (clay ? 0.30 : unit == UnitKind::calcium_silicate ? 0.40 : 0.30) * kMPa;
  if (mortar >= 10 * kMPa) return (clay ? 0.30 : 0.20) * kMPa;
  if (mortar >= 2.5 * kMPa) return (clay ? 0.20 : 0.15) * kMPa;
  return 0.10 * kMPa;
}

class Rule {
 public:
  Rule(const TestedMasonry& tested, const ScatterFactor& scatter)
      : t_(tested), kind_(kind_of(tested.unit)), scatter_(scatter) {}

  MasonryNumbers numbers() {
    strengths();
    moduli();
    bed();
    head();
    inside_units();
    return std::move(n_);
  }

 private:
  double note(const std::string& name, double value, const char* unit, const std::string& from, double spread) {
    if (scatter_ && spread > 0.0) value *= scatter_(name, spread);
    n_.derivation.push_back({name, value, unit, from, spread});
    return value;
  }

  void strengths() {
    unit_ = t_.unit_strength              ? note("unit: compressive strength", *t_.unit_strength, "Pa", "given", 0.15)
            : t_.unit_strength_normalised ? note("unit: compressive strength", *t_.unit_strength_normalised, "Pa",
                                                 "the normalised one, given", 0.2)
                                          : note("unit: compressive strength", kind_.strength, "Pa",
                                                 "nothing known: usual for this kind [assumed]", 0.4);
    mortar_ = t_.mortar_strength ? *t_.mortar_strength : kMortarStrength;
    if (t_.masonry_strength) {
      n_.masonry_strength = note("masonry: compressive strength", *t_.masonry_strength, "Pa", "given", 0.15);
      return;
    }
    const bool thin = t_.bed == JointKind::thin || t_.bed == JointKind::dry;
    // Bounds of EN 1996-1-1, 3.6.1.2: fb up to 50 MPa in thin joints, else 75; fm up to 20 MPa and to 2 fb.
    const double fb = std::min(t_.unit_strength_normalised.value_or(unit_) / kMPa, thin ? 50.0 : 75.0);
    const double fm = std::min({mortar_ / kMPa, 20.0, 2.0 * fb});
    const double characteristic =
        thin ? kind_.k_thin * std::pow(fb, kind_.thin_power) : kind_.k_mortar * std::pow(fb, 0.7) * std::pow(fm, 0.3);
    n_.masonry_strength =
        note("masonry: compressive strength", kMeanOverCharacteristic * characteristic * kMPa, "Pa",
             thin ? fmt::format("1.2 x {} fb^{} (EN 1996-1-1, 3.6.1.2; EN 1052-1)", kind_.k_thin, kind_.thin_power)
                  : fmt::format("1.2 x {} fb^0.7 fm^0.3 (EN 1996-1-1, 3.6.1.2; EN 1052-1)", kind_.k_mortar),
             0.25);
  }

  void moduli() {
    n_.poisson_ratio = note("unit: Poisson's ratio", kPoisson, "", "Table 3 of the paper", 0.0);
    n_.density = note("unit: density", kind_.density, "kg/m3", "usual for this kind [assumed]", 0.05);
    n_.masonry_modulus = t_.masonry_modulus ? note("masonry: modulus", *t_.masonry_modulus, "Pa", "given", 0.15)
                                            : note("masonry: modulus", kModulusOverStrength * n_.masonry_strength, "Pa",
                                                   "550 fc (Kaushik, Rai and Jain 2007; 250 to 1100 there)", 0.3);
    const double of_unit = kUnitModulusOverStrength * unit_, least = kLeastStiffer * n_.masonry_modulus;
    if (t_.unit_modulus)
      n_.young_modulus = note("unit: modulus", *t_.unit_modulus, "Pa", "given", 0.1);
    else if (t_.bed == JointKind::dry || of_unit > least)
      n_.young_modulus = note("unit: modulus", of_unit, "Pa", "300 fb (Kaushik, Rai and Jain 2007)", 0.3);
    else
      n_.young_modulus = note("unit: modulus", least, "Pa", "twice the masonry's, more than 300 fb [assumed]", 0.3);
  }

  double bed_stiffness() {
    if (t_.bed == JointKind::dry)
      return note("bed joint: normal stiffness",
                  kDryStiffness * std::sqrt(std::max(t_.axial_stress, kLeastDryPressure) / kDryPressure), "Pa/m",
                  "8e9 sqrt(sigma/0.5 MPa): closure of rough faces, fitted to six dry walls together", 0.3);
    const double softer = 1.0 / n_.masonry_modulus - 1.0 / n_.young_modulus;
    const double stiffness = softer > 0.0 ? 1.0 / (t_.block_height * softer) : kStiffestBed;
    return note("bed joint: normal stiffness", std::min(stiffness, kStiffestBed), "Pa/m",
                softer > 0.0 ? "unit and joint in series: 1/(h (1/E masonry - 1/E unit))"
                             : "the stiffest joint, as E masonry is not below E unit, which bounds it [assumed]",
                0.3);
  }

  // Fracture energies are at least twice the elastic energy at the strength, so that no joint snaps back.
  void bed() {
    JointNumbers& j = n_.bed;
    j.normal_stiffness = bed_stiffness();
    j.shear_stiffness = note("bed joint: shear stiffness", j.normal_stiffness / (2.0 * (1.0 + kPoisson)), "Pa/m",
                             "kn/(2 (1 + nu)), as in the paper's tables", 0.3);
    const double mu =
        note("bed joint: friction coefficient", t_.friction.value_or(kFriction), "",
             t_.friction ? "given" : "nothing known: 0.7 (van der Pluijm 1999)", t_.friction ? 0.1 : 0.19);
    j.friction_angle = degrees(mu);
    if (t_.bed == JointKind::dry) {
      note("bed joint: cohesion", 0.0, "Pa", "dry", 0.0);
      return;  // the joint neither softens nor crushes before the units
    }
    j.cohesion = t_.cohesion
                     ? note("bed joint: cohesion", *t_.cohesion, "Pa", "initial shear strength, given", 0.25)
                     : note("bed joint: cohesion", code_cohesion(t_.unit, t_.bed, mortar_) / kShearOfCharacteristic,
                            "Pa", "EN 1996-1-1, table 3.4, over 0.8 (EN 1052-3)", 0.4);
    j.tensile_strength =
        note("bed joint: tensile strength", std::min(kBondOverCohesion * j.cohesion, j.cohesion / mu), "Pa",
             "2/3 of the cohesion (Tables 1 and 3 of the paper), at most cohesion/friction", 0.4);
    if (scatter_) j.tensile_strength = std::min(j.tensile_strength, j.cohesion / mu);
    j.tension_energy = note("bed joint: fracture energy, tension",
                            std::max(std::clamp(kTensionLength * j.tensile_strength, kLeastTension, kMostTension),
                                     j.tensile_strength * j.tensile_strength / j.normal_stiffness),
                            "J/m2", "0.075 mm ft (Table 1), 5 to 20 J/m2 (van der Pluijm 1999)", 0.4);
    j.shear_energy = note("bed joint: fracture energy, shear",
                          std::max(kShearLength * j.cohesion, j.cohesion * j.cohesion / j.shear_stiffness), "J/m2",
                          "0.2 mm c: between Angelillo et al. (2014), 0.1 mm, and Table 1, 0.42 mm", 0.5);
    if (scatter_) {
      j.tension_energy = std::max(j.tension_energy, j.tensile_strength * j.tensile_strength / j.normal_stiffness);
      j.shear_energy = std::max(j.shear_energy, j.cohesion * j.cohesion / j.shear_stiffness);
    }
    j.compressive_strength = n_.masonry_strength;
    j.compression_energy =
        note("bed joint: fracture energy, compression", crushing_energy(n_.masonry_strength), "J/m2",
             "1.6 mm fc below 12 MPa, then 15 + 0.43 fc - 0.0036 fc^2 N/mm (Angelillo et al. 2014)", 0.3);
  }

  void head() {
    n_.head = n_.bed;
    if (t_.head == JointKind::mortar || t_.head == JointKind::thin) {
      note("head joint", 1.0, "", "filled: as bed joints", 0.0);
      return;
    }
    n_.head.tensile_strength = n_.head.cohesion = n_.head.tension_energy = n_.head.shear_energy = 0.0;
    if (t_.bed == JointKind::dry) return;
    const double part = note("head joint: stiffness over that of bed joints", kUnfilledStiffness, "",
                             "unfilled: units touch in few places; no bond [assumed]", 0.5);
    n_.head.normal_stiffness *= part, n_.head.shear_stiffness *= part;
    n_.head.compressive_strength.reset();
  }

  void inside_units() {
    JointNumbers& j = n_.inside_units;
    // With soft dry joints the scale is the modulus of the unit.
    const double scale = t_.bed == JointKind::dry ? n_.young_modulus / t_.block_height : n_.bed.normal_stiffness;
    j.normal_stiffness = note("inside units: normal stiffness", kUnitStiffness * scale, "Pa/m",
                              "6 times that of bed joints (Table 3); dry: 6 E/h", 0.0);
    j.shear_stiffness = j.normal_stiffness / (2.0 * (1.0 + kPoisson));
    j.tensile_strength = note("inside units: tensile strength", kUnitTension * unit_, "Pa",
                              "0.05 of the unit's strength (Angelillo et al. 2014)", 0.25);
    // Mohr's straight envelope, tangent to the circles of uniaxial tension and compression.
    j.cohesion = note("inside units: cohesion", 0.5 * std::sqrt(unit_ * j.tensile_strength), "Pa",
                      "sqrt(fb ft)/2: Mohr's straight envelope between tension and compression", 0.25);
    j.friction_angle = kUnitFriction;
    j.tension_energy =
        note("inside units: fracture energy, tension", 25.0 * std::pow(2.0 * j.tensile_strength / kMPa, 0.7), "J/m2",
             "0.025 (2 ft)^0.7 N/mm (Angelillo et al. 2014)", 0.3);
    j.shear_energy = note("inside units: fracture energy, shear", kUnitShearLength * j.cohesion, "J/m2",
                          "0.1 mm c (Angelillo et al. 2014)", 0.3);
    j.compressive_strength = unit_;
    j.compression_energy = crushing_energy(unit_);
  }

  const TestedMasonry& t_;
  const KindOfUnit& kind_;
  const ScatterFactor& scatter_;
  double unit_ = 0.0, mortar_ = 0.0;  // strengths, Pa
  MasonryNumbers n_;
};

void require(const char* name, const std::optional<double>& value) {
  if (value && !(*value > 0.0 && std::isfinite(*value)))
    throw Error(Exit::bad_input, fmt::format("properties from tests: {} = {:g}; allowed: more than 0", name, *value));
}

}  // namespace

MasonryNumbers properties_of(const TestedMasonry& tested, const ScatterFactor& scatter) {
  require("unit_strength", tested.unit_strength);
  require("unit_strength_normalised", tested.unit_strength_normalised);
  require("unit_modulus", tested.unit_modulus);
  require("mortar_strength", tested.mortar_strength);
  require("masonry_strength", tested.masonry_strength);
  require("masonry_modulus", tested.masonry_modulus);
  require("friction", tested.friction);
  require("block_height", tested.block_height);
  if (tested.cohesion && !(*tested.cohesion >= 0.0 && std::isfinite(*tested.cohesion)))
    throw Error(Exit::bad_input,
                fmt::format("properties from tests: cohesion = {:g}; allowed: 0 or more", *tested.cohesion));
  return Rule(tested, scatter).numbers();
}

}  // namespace quoin
