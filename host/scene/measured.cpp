#include "scene/measured.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "scene/generate.h"
#include "scene/quality.h"

namespace quoin {
namespace {

struct Range {
  const char* key;
  double low, high;
};

constexpr Range kMortar[] = {
    {"normal_stiffness", 20e9, 164e9},  {"shear_stiffness", 8e9, 72e9},     {"tensile_strength", 0.05e6, 0.4e6},
    {"cohesion", 0.15e6, 0.6e6},        {"friction_angle", 30, 35},         {"compressive_strength", 5e6, 10e6},
    {"fracture_energy_tension", 5, 30}, {"fracture_energy_shear", 20, 250}, {"fracture_energy_compression", 8e3, 16e3}};
constexpr Range kInUnits[] = {{"normal_stiffness", 120e9, 1000e9},
                              {"shear_stiffness", 50e9, 1000e9},
                              {"tensile_strength", 1e6, 2e6},
                              {"cohesion", 1.5e6, 3e6},
                              {"friction_angle", 35, 35},
                              {"compressive_strength", 12e6, 15e6},
                              {"fracture_energy_tension", 80, 80},
                              {"fracture_energy_shear", 125, 550},
                              {"fracture_energy_compression", 19e3, 21e3}};

// Empty within the range, else its text. Ends have a tolerance, as values of scenes may be rounded products.
std::string outside(const Range& range, double value, const std::string& where) {
  if (value >= range.low * (1 - 1e-9) && value <= range.high * (1 + 1e-9)) return {};
  return fmt::format("{}{} = {:g}, measured from {:g} to {:g}", where, range.key, value, range.low, range.high);
}

template <std::size_t n>
std::string outside_joint(const JointFamily& joint, const Range (&ranges)[n]) {
  const std::string where = "joints." + joint.name + ".";
  if (joint.law != "fracture_energy") return fmt::format("{}law = {}, measured with fracture_energy", where, joint.law);
  if (joint.initial_state != "bonded") return where + "initial_state, measured with bonded";
  const auto value_of = [&](const std::string& id) -> const double* {
    for (const PropertySetting& p : joint.properties) {
      if (p.id == id && p.numbers.size() == 1) return &p.numbers[0];
    }
    return nullptr;
  };
  for (const Range& range : ranges) {
    const double* value = value_of(range.key);
    if (!value) return fmt::format("{}{}, measured with a number for it", where, range.key);
    if (const std::string text = outside(range, *value, where); !text.empty()) return text;
  }
  for (const PropertySetting& p : joint.properties) {
    if (std::any_of(ranges, ranges + n, [&](const Range& r) { return p.id == r.key; })) continue;
    if (p.id == "friction_angle_residual" && p.numbers == std::vector<double>{*value_of("friction_angle")}) continue;
    return where + p.id + ", measured with its default";
  }
  return {};
}

std::string outside_wall(const Scene& scene) {
  const WallSpec& wall = *scene.wall;
  if (wall.rigid_units) return "wall.rigid_units, measured with deformable units";
  if (wall.zones != std::array<int, 3>{4, 2, 2}) return "wall.zones, measured with [4, 2, 2]";
  if (!wall.bottom_beam) return "wall.bottom_beam, measured with one";
  if (!wall.bottom_beam_cuts.empty()) return "wall.bottom_beam_cuts, measured without";
  if (!wall.changed.empty()) return "wall.changed, measured with units alike";
  if (wall.openings.size() > 1) return "wall.opening, measured with one";
  for (const WallSpec::Opening& opening : wall.openings) {
    if (opening.bearing > 0) return "wall.opening.bearing, measured without lintels";
    if (opening.half_units > 2 || opening.courses > 6)
      return fmt::format("wall.opening of {} half units by {} courses, measured to 2 by 6", opening.half_units,
                         opening.courses);
  }
  const BlockMaterial& brick = scene.materials.at(wall.unit_material);
  const std::string of_unit = "wall.unit ", of_wall = "wall.", of_brick = "materials." + brick.name + ".";
  const struct {
    Range range;
    double value;
    const std::string& where;
  } numbers[] = {{{"length", 0.22, 0.66}, wall.unit[0], of_unit},
                 {{"height", 0.0625, 0.2}, wall.unit[1], of_unit},
                 {{"thickness", 0.1, 0.25}, wall.unit[2], of_unit},
                 {{"courses", 9, 32}, static_cast<double>(wall.courses), of_wall},
                 {{"units_per_course", 2.5, 9}, wall.units_per_course, of_wall},
                 {{"beam_height", 0.1, 0.1}, wall.beam_height, of_wall},
                 {{"beam_density", 7850, 7850}, wall.beam_density, of_wall},
                 {{"young_modulus", 2.4e9, 33.4e9}, brick.young_modulus, of_brick},
                 {{"poisson_ratio", 0.15, 0.2}, brick.poisson_ratio, of_brick},
                 {{"density", 1750, 1900}, brick.density, of_brick}};
  for (const auto& number : numbers) {
    if (const std::string text = outside(number.range, number.value, number.where); !text.empty()) return text;
  }
  for (const std::string& name : std::set<std::string>{wall.bed_joint, wall.head_joint, wall.beam_joint}) {
    if (const std::string text = outside_joint(scene.joints.at(name), kMortar); !text.empty()) return text;
  }
  return wall.mid_unit_joints ? outside_joint(scene.joints.at(wall.unit_joint), kInUnits) : std::string();
}

std::string outside_stages(const Scene& scene) {
  const Quality& quality = quality_named(scene.quality);
  if (scene.stages.size() != 2 || scene.stages[0].kind != "pressure" || scene.stages[1].kind != "shear")
    return "stages, measured with one of kind pressure, then one of kind shear";
  const Stage &press = scene.stages[0], &shear = scene.stages[1];
  for (const Stage& stage : scene.stages) {
    if (stage.gravity != Vec3{}) return fmt::format("stage.{}.gravity, measured without", stage.name);
    if (!stage.law_swaps.empty()) return fmt::format("stage.{}.law, measured without", stage.name);
    if (stage.duration) return fmt::format("stage.{}.duration, measured without", stage.name);
  }
  if (!press.equilibrium_ratio || *press.equilibrium_ratio > quality.equilibrium_ratio)
    return fmt::format("stage.{}.equilibrium_ratio, measured with {:g}", press.name, quality.equilibrium_ratio);
  if (shear.equilibrium_ratio) return fmt::format("stage.{}.equilibrium_ratio, measured without", shear.name);
  const WallSpec& wall = *scene.wall;
  const auto top = std::find_if(press.controls.begin(), press.controls.end(),
                                [](const BodyControl& c) { return c.body == "top_beam"; });
  const double force = top == press.controls.end() ? 0.0 : -top->force[1];
  const std::string of_press = "stage." + press.name + ".", of_shear = "stage." + shear.name + ".";
  std::string text =
      outside({"pressure", 0.3e6, 2.12e6}, force * (wall.half_thickness ? 2.0 : 1.0) / bed_area(wall), of_press);
  if (text.empty()) text = outside({"ramp_time", 0.05, 0.05}, shear.ramp_time, of_shear);
  if (text.empty())
    text = outside({"displacement over the height of the wall", 0.0025, 0.02},
                   *shear.displacement / (wall.courses * wall.unit[1]), of_shear);
  return text;
}

}  // namespace

std::string outside_measured(const Scene& scene) {
  if (scene.blocks) return "blocks of any shape, measured on walls";
  if (scene.building) return "building, measured on walls";
  if (!scene.damage.empty()) return "damage, measured on sound walls";
  if (!scene.start.empty()) return "start, measured from rest";
  if (!scene.quality_as_is) return fmt::format("settings of quality {} changed", scene.quality);
  for (const auto& [name, family] : scene.joints) {
    if (family.is_random()) return fmt::format("joints.{}, which scatter: measured with joints alike", name);
  }
  const std::string text = outside_wall(scene);
  return text.empty() ? outside_stages(scene) : text;
}

}  // namespace quoin
