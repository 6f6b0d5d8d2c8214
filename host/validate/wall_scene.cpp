#include "validate/wall_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/printable.h"
#include "base/text.h"

namespace quoin::validate {

namespace {

constexpr double kGravity = 9.81;                        // m/s2
constexpr double kMortarJoint = 10.0, kThinJoint = 2.0;  // mm
// Largest number of half units, 0.3 to 1 s of computation each. Blocks of larger walls stand for several courses.
constexpr int kMostHalfUnits = 700;
constexpr double kBondedThickness = 1.5;  // limit in unit widths: thicker walls have headers across their leaves
constexpr double kDrift = 0.01;           // final displacement of the top over the height
constexpr double kCyclicDrifts[] = {0.001, 0.002, 0.003, 0.005, 0.008};
constexpr double kCyclicVelocity = 0.01;                    // m/s
constexpr double kBeamHeight = 0.1, kBeamDensity = 7850.0;  // m, kg/m3
// H0/H of a wall whose top cannot rotate, also the default of rows without it.
constexpr double kHeldSpan = 0.5;

UnitKind unit_of(const WallRow& row) {
  const std::string type = upper(row.unit_type);
  if (type.starts_with("CS")) return UnitKind::calcium_silicate;
  if (type.find("AAC") != std::string::npos) return UnitKind::aerated_concrete;
  if (type.starts_with("ST")) return UnitKind::stone;
  if (type.starts_with("C") || type.starts_with("LAC") || type.starts_with("LWC")) return UnitKind::concrete;
  return type.starts_with("SB") || type.empty() ? UnitKind::clay : UnitKind::hollow_clay;
}

JointKind joint_of(const std::string& code, JointKind otherwise) {
  const std::string kind = upper(code);
  if (kind == "DRY" || kind == "D") return JointKind::dry;
  if (kind == "U" || kind == "UNFILLED") return JointKind::unfilled;
  if (kind == "TL" || kind == "TF") return JointKind::thin;
  if (kind.empty() || kind == "F") return otherwise;
  return JointKind::mortar;
}

struct Layout {
  int courses = 0;
  double units = 0.0;                           // per course, multiples of one half
  double unit_length = 0.0, unit_height = 0.0;  // m, expanded
  int half_units() const { return static_cast<int>(std::lround(2 * units)) * courses; }
};

// Layout with blocks k courses high and k half units long where the wall has too many units.
Layout layout_of(const WallRow& row) {
  const JointKind bed = joint_of(row.bed_joints, JointKind::mortar), head = joint_of(row.head_joints, bed);
  const auto width = [](JointKind kind) {
    return kind == JointKind::mortar ? kMortarJoint : kind == JointKind::thin ? kThinJoint : 0.0;
  };
  // Bonded over the thickness: alternate courses of stretchers and headers, whose mean length is that of the steps of
  // cracks.
  const double stretcher = row.unit_length.value_or(250.0),
               header = std::min(row.unit_width.value_or(stretcher), stretcher);
  const bool bonded = 1e3 * row.thickness > kBondedThickness * header;
  const double length = (bonded ? (stretcher + header) / 2 : stretcher) + width(head);
  const double height = row.unit_height.value_or(65.0) + width(bed);
  const double courses = row.courses.value_or(std::max(1.0, std::round(1e3 * row.height / height)));
  Layout l;
  for (int merged = 1;; ++merged) {
    l.courses = std::max(2, static_cast<int>(std::lround(courses / merged)));
    l.units = std::max(1.0, std::round(2 * 1e3 * row.length / (length * merged)) / 2);
    if (l.half_units() <= kMostHalfUnits) break;
  }
  l.unit_length = row.length / l.units;
  l.unit_height = row.height / l.courses;
  return l;
}

std::string family(const char* name, const JointNumbers& j, bool cyclic, bool mortar) {
  std::string text = fmt::format(
      "\n[joints.{}]\nlaw = \"{}\"\nnormal_stiffness = {:.6g}\nshear_stiffness = {:.6g}\nfriction_angle = {:.6g}\n",
      name, cyclic ? "cyclic_joint" : "fracture_energy", j.normal_stiffness, j.shear_stiffness, j.friction_angle);
  if (j.tensile_strength > 0.0)
    text += fmt::format("tensile_strength = {:.6g}\nfracture_energy_tension = {:.6g}\n", j.tensile_strength,
                        j.tension_energy);
  if (j.cohesion > 0.0)
    text += fmt::format("cohesion = {:.6g}\nfracture_energy_shear = {:.6g}\n", j.cohesion, j.shear_energy);
  if (j.compressive_strength)
    text += fmt::format("compressive_strength = {:.6g}\nfracture_energy_compression = {:.6g}\n",
                        *j.compressive_strength, j.compression_energy);
  // Starting values of the page of cyclic_joint.
  if (cyclic && mortar && j.tensile_strength > 0.0) text += "residual_opening = 0.3\n";
  if (cyclic && mortar && j.compressive_strength)
    text += fmt::format("compressive_yield = {:.6g}\ncompressive_peak_closure = 9e-5\n", *j.compressive_strength / 3);
  return text;
}

std::string wall_table(const Layout& l, const WallRow& row, double load_height, bool turns) {
  const int along = 4,
            up = l.unit_height > 0.75 * l.unit_length ? 4 : 2;  // 4 x 2 x 2 as in the paper; more in high units
  std::string text = fmt::format(
      "\n[wall]\nbond = \"running\"\ncourses = {}\nunits_per_course = {:g}\nunit = [{:.9g}, {:.9g}, {:.9g}]\n"
      "zones = [{}, {}, 2]\nhalf_thickness = true\nunit_material = \"unit\"\nbed_joint = \"bed\"\nhead_joint = "
      "\"head\"\n"
      "unit_joint = \"inside\"\nbeam_joint = \"bed\"\nbeam_height = {:g}\nbeam_density = {:g}\n",
      l.courses, l.units, l.unit_length, l.unit_height, row.thickness, along, up, kBeamHeight, kBeamDensity);
  if (turns) text += fmt::format("load_height = {:.9g}  # m: the shear span H0\n", load_height);
  return text;
}

std::string stages(const WallRow& row, const TestScene& scene, bool turns, bool cyclic) {
  const double beam_weight = kBeamDensity * kBeamHeight * scene.bed_area * kGravity;
  // Without the beam's own weight, N.
  const double force = std::max(0.0, row.axial_stress * 1e6 * scene.bed_area - beam_weight);
  std::string text = fmt::format(
      "\n[[stage]]\nname = \"precompression\"\nkind = \"pressure\"\npressure = {:.6g}  # Pa, beside the beam's weight\n"
      "gravity = [0, -{}, 0]\n\n[[stage]]\nname = \"shear\"\n",
      force / scene.bed_area, kGravity);
  const double driven = kDrift * row.height / scene.top_displacement;
  if (cyclic) {
    text += "kind = \"cycles\"\namplitudes = [";
    for (const double drift : kCyclicDrifts)
      text +=
          fmt::format("{}{:.6g}", drift == kCyclicDrifts[0] ? "" : ", ", drift * row.height / scene.top_displacement);
    text += fmt::format("]\nvelocity = {}\nramp_time = 0.05\n", kCyclicVelocity);
  }
  if (!turns) {
    if (!cyclic) text += fmt::format("kind = \"shear\"\ndisplacement = {:.6g}\n", driven);
    return text + "vertical = \"pressure\"\n";
  }
  // The model has half of the wall, and half of the force.
  const double velocity = cyclic ? 0.0 : 0.02;
  if (cyclic)
    text += "body = \"top_beam\"\n";
  else
    text += fmt::format("kind = \"custom\"\nramp_time = 0.05\ndisplacement = {:.6g}\n", driven);
  return text + fmt::format(
                    "\n[[stage.control]]\nbody = \"bottom_beam\"\n\n[[stage.control]]\nbody = \"top_beam\"\n"
                    "rotation_held = false\nvelocity = [{:g}, \"free\", 0]\nforce = [0, {:.9g}, 0]\n",
                    velocity, -force / 2);
}

std::string comments(const WallRow& row, const MasonryNumbers& numbers) {
  std::string text = "# Properties by the rule of host/validate/README.md:\n";
  for (const Derivation& d : numbers.derivation)
    text += fmt::format("#   {} = {:.4g} {}: {}\n", d.name, d.value, d.unit, d.from);
  return fmt::format("# {}: {:g} x {:g} x {:g} m, {:g} MPa, H0/H {}.\n", printable(row.name()), row.length, row.height,
                     row.thickness, row.axial_stress,
                     row.shear_span ? fmt::format("{:g}", *row.shear_span) : "not given: 0.5 [assumed]") +
         text;
}

}  // namespace

TestedMasonry tested_masonry(const WallRow& row) {
  const auto pa = [](const Given& mpa) { return mpa ? Given(*mpa * 1e6) : Given(); };
  TestedMasonry t;
  t.unit = unit_of(row);
  t.bed = joint_of(row.bed_joints, JointKind::mortar);
  t.head = joint_of(row.head_joints, t.bed);
  t.block_height = layout_of(row).unit_height;
  t.axial_stress = row.axial_stress * 1e6;
  t.unit_strength = pa(row.unit_strength), t.unit_strength_normalised = pa(row.unit_strength_normalised);
  t.mortar_strength = pa(row.mortar_strength), t.masonry_strength = pa(row.masonry_strength);
  t.cohesion = pa(row.cohesion), t.friction = row.friction;
  return t;
}

double rocking_force(const WallRow& row) {
  const double load = 1e3 * row.axial_stress * row.length * row.thickness;  // kN
  return load * row.length / (2 * row.shear_span.value_or(kHeldSpan) * row.height);
}

double rocking_force_with_weight(const WallRow& row) {
  const double density = properties_of(tested_masonry(row)).density;
  const double weight = 1e-3 * density * kGravity * row.length * row.thickness * row.height;
  // With the top held against rotation, both toes carry the wall: V H = N L + W L/2.
  const double span = row.shear_span.value_or(kHeldSpan), lever = span == kHeldSpan ? 1.0 : span;
  return rocking_force(row) + weight * row.length / (2 * lever * row.height);
}

TestScene scene_of(const WallRow& row, bool cyclic, const ScatterFactor& scatter) {
  TestScene scene;
  const Layout layout = layout_of(row);
  const double span = row.shear_span.value_or(kHeldSpan);
  const bool turns = span != kHeldSpan;
  scene.numbers = properties_of(tested_masonry(row), scatter);
  scene.load_height = turns ? span * row.height : row.height;
  // Exact for a wall that rocks on its toe.
  scene.top_displacement = turns ? 1.0 / span : 1.0;
  scene.bed_area = row.length * row.thickness;
  scene.half_units = layout.half_units();
  const MasonryNumbers& n = scene.numbers;
  scene.text = comments(row, n) +
               fmt::format(
                   "title = \"{} {}\"\n\n[solver]\nlarge_motion = \"never\"\npast_motion_bound = \"warn\"\n"
                   "\n[materials.unit]\nyoung_modulus = {:.6g}\npoisson_ratio = {}\ndensity = {}\n",
                   row.folder_name(), cyclic ? "cyclic" : "monotonic", n.young_modulus, n.poisson_ratio, n.density) +
               family("bed", n.bed, cyclic, true) + family("head", n.head, cyclic, true) +
               family("inside", n.inside_units, cyclic, false) + wall_table(layout, row, scene.load_height, turns) +
               stages(row, scene, turns, cyclic) + "\n[output]\nframes = 1\nframes_of = \"last\"\n";
  return scene;
}

}  // namespace quoin::validate
