#include <algorithm>
#include <cmath>
#include <functional>

#include "scene/read_tables.h"

namespace quoin {

using namespace reader;

WallSpec read_wall(Table& t, const Scene& scene) {
  WallSpec w;
  t.choice("bond", w.bond, {"running", "stack"});
  t.choice("first_course", w.first_course, {"whole", "half"});
  const bool has_courses = t.integer("courses", w.courses, 1, 10000, true);
  bool has_units = t.number("units_per_course", w.units_per_course, between(0.5, 10000), "units, in halves", true);
  if (has_units && 2 * w.units_per_course != std::floor(2 * w.units_per_course)) {
    t.refuse("units_per_course", "a multiple of 0.5, as units are cut in half at most");
    has_units = false;
  }
  const bool has_unit = t.numbers("unit", w.unit, kExtent, "m (length, height, thickness)", true);
  t.numbers("zones", w.zones, between(1, 64), "hexahedra per half unit along x, y, z");
  t.boolean("mid_unit_joints", w.mid_unit_joints);
  t.boolean("rigid_units", w.rigid_units);
  if (w.rigid_units && t.has("zones")) t.refuse("zones", "only with deformable units; remove it, or rigid_units");
  t.boolean("half_thickness", w.half_thickness);
  if (w.half_thickness && w.zones[2] % 2 != 0)
    t.refuse("half_thickness", "true only with an even number of zones along z");
  t.boolean("bottom_beam", w.bottom_beam);
  t.boolean("top_beam", w.top_beam);
  t.number("beam_height", w.beam_height, kExtent, "m");
  t.number("load_height", w.load_height, kNotNegative, "m above the foot of the wall");
  if (w.load_height && !w.top_beam) t.refuse("load_height", "only with top_beam = true, on which it acts");
  if (w.load_height &&
      (scene.solver.large_motion != LargeMotion::never || scene.solver.kernels == Kernels::general || scene.blocks))
    t.refuse("load_height",
             "only in small displacements, without blocks of other shapes: solver.large_motion = \"never\", "
             "solver.kernels = \"automatic\"");
  t.number("beam_density", w.beam_density, kDensity, "kg/m3");

  const int half_units = has_units ? static_cast<int>(2 * w.units_per_course) : 0;
  std::vector<int>& cuts = w.bottom_beam_cuts;
  if (t.numbers("bottom_beam_cuts", cuts, between(1, 20000), "half units from the left, where the beam is cut")) {
    const bool grow = std::ranges::adjacent_find(cuts, std::greater_equal<>()) == cuts.end();
    if (has_units && (!grow || cuts.back() >= half_units))
      t.refuse("bottom_beam_cuts", fmt::format("half units that grow, 1 to {}", half_units - 1));
    if (!w.bottom_beam) t.refuse("bottom_beam_cuts", "only with bottom_beam = true");
  }
  const bool beams = w.bottom_beam || w.top_beam;
  t.name_of("unit_material", w.unit_material, scene.materials, "materials", true);
  t.name_of("bed_joint", w.bed_joint, scene.joints, "joints", true);
  t.name_of("head_joint", w.head_joint, scene.joints, "joints", true);
  t.name_of("unit_joint", w.unit_joint, scene.joints, "joints", w.mid_unit_joints);
  t.name_of("beam_joint", w.beam_joint, scene.joints, "joints", beams);

  const Lattice lattice{half_units, has_courses ? w.courses : 0, has_unit ? w.unit[0] / 2 : 0};
  w.openings = read_openings(t, lattice, scene.materials);
  w.changed = read_changed(t, lattice, w, scene.materials);
  return w;
}

}  // namespace quoin
