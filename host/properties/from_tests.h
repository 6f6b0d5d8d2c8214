// Properties of a model's joints and units from common tests: strengths of units, mortar and masonry, shear tests. The
// derivation with its sources is in host/validate/README.md.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace quoin {

enum class UnitKind { clay, hollow_clay, calcium_silicate, concrete, aerated_concrete, stone };
// mortar: about 10 mm thick. thin: 1 to 3 mm. dry: units in contact. unfilled: head joints without mortar.
enum class JointKind { mortar, thin, dry, unfilled };

// Test results of a masonry. Stresses in Pa, lengths in m; nothing: not tested.
struct TestedMasonry {
  UnitKind unit = UnitKind::clay;
  JointKind bed = JointKind::mortar, head = JointKind::mortar;
  double block_height = 0.0;  // height of the model's units with one joint, for the stiffness of a bed joint, m
  double axial_stress = 0.0;  // pressure on dry joints, which increases their stiffness
  std::optional<double> unit_strength, unit_strength_normalised, unit_modulus, mortar_strength;
  std::optional<double> masonry_strength, masonry_modulus, cohesion, friction;
};

// Properties of one joint family by the names of laws, SI.
struct JointNumbers {
  double normal_stiffness = 0.0, shear_stiffness = 0.0;
  double tensile_strength = 0.0, cohesion = 0.0, friction_angle = 0.0;  // Pa, Pa, deg
  std::optional<double> compressive_strength;                           // nothing: no crushing
  double tension_energy = 0.0, shear_energy = 0.0, compression_energy = 0.0;
};

// Derivation of a number, to be shown.
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

// Random factor, above 0, on a number of this name and coefficient of variation, for samples of an ensemble.
using ScatterFactor = std::function<double(const std::string& name, double spread)>;

// scatter: empty: none. Numbers derived from a random number vary with it. Throws Error(bad_input) for values out of
// range: strengths above 0, friction above 0.
MasonryNumbers properties_of(const TestedMasonry& tested, const ScatterFactor& scatter = {});

}  // namespace quoin
