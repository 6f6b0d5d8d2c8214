// One rule from what engineers measure (strengths of units, mortar, masonry; shear tests) to all properties of a
// model's joints and units. The derivation with its sources is in host/validate/README.md.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace quoin {

enum class UnitKind { clay, hollow_clay, calcium_silicate, concrete, aerated_concrete, stone };
// mortar: of some 10 mm. thin: of 1 to 3 mm. dry: units touch. unfilled: head joints without mortar.
enum class JointKind { mortar, thin, dry, unfilled };

// What is known of a masonry. Stresses in Pa, lengths in m; nothing where nothing is known.
struct TestedMasonry {
  UnitKind unit = UnitKind::clay;
  JointKind bed = JointKind::mortar, head = JointKind::mortar;
  double block_height = 0.0;  // height of the model's units with a joint, for the stiffness of a bed joint, m
  double axial_stress = 0.0;  // dry joints are stiffer under pressure
  std::optional<double> unit_strength, unit_strength_normalised, unit_modulus, mortar_strength;
  std::optional<double> masonry_strength, masonry_modulus, cohesion, friction;
};

// Numbers of one joint family as the laws name them, SI.
struct JointNumbers {
  double normal_stiffness = 0.0, shear_stiffness = 0.0;
  double tensile_strength = 0.0, cohesion = 0.0, friction_angle = 0.0;  // Pa, Pa, deg
  std::optional<double> compressive_strength;                           // nothing: it cannot crush
  double tension_energy = 0.0, shear_energy = 0.0, compression_energy = 0.0;
};

// How a number came about, for people.
struct Derivation {
  std::string name;  // "bed joint: cohesion"
  double value = 0.0;
  std::string unit;     // "Pa"
  std::string from;     // relation and its source
  double spread = 0.0;  // coefficient of variation, for ensembles
};

struct MasonryNumbers {
  double young_modulus = 0.0, poisson_ratio = 0.0, density = 0.0;  // properties of units
  double masonry_modulus = 0.0, masonry_strength = 0.0;            // Pa
  JointNumbers bed, head, inside_units;
  std::vector<Derivation> derivation;
};

// By what a number of this name and coefficient of variation differs from the rule's, for samples of an ensemble: above
// 0.
using ScatterFactor = std::function<double(const std::string& name, double spread)>;

// scatter: empty: none. What follows from a scattered number follows it. Throws Error(bad_input) for values out of
// range: strengths above 0, friction above 0.
MasonryNumbers properties_of(const TestedMasonry& tested, const ScatterFactor& scatter = {});

}  // namespace quoin
