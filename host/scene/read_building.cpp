// The tables of a building and of its stages; host/scenes/README.md lists the keys.
#include "scene/driven.h"
#include "scene/openings.h"
#include "scene/read_tables.h"

namespace quoin {

using namespace reader;

namespace {

using Wall = BuildingSpec::Wall;

Wall read_wall(Table& t, const BuildingSpec& b, const Scene& scene) {
  Wall w;
  w.source = {t.where()};
  t.text("name", w.name, "text, as \"B\"", true);
  t.choice("axis", w.axis, {{"x", 0}, {"z", 2}});
  t.numbers("start", w.start, kPlace, "m (x and z of the lowest corner)", true);
  const bool counted = t.integer("half_units", w.half_units, 1, 20000, true);
  const bool measured = t.number("half_unit", w.half_unit, kExtent, "m (length)", true);
  t.choice("first_course", w.first_course, {"whole", "half"});
  w.openings = read_openings(t, {counted ? w.half_units : 0, b.courses, measured ? w.half_unit : 0.0}, scene.materials);
  return w;
}

void refuse_beams_in_lintels(Table& t, const BuildingSpec::Floor& floor, const Wall& wall) {
  std::vector<std::string> taken;
  for (const int half_unit : floor.half_units) {
    if (lintel_at(wall.openings, floor.course, half_unit)) taken.push_back(std::to_string(half_unit));
  }
  if (!taken.empty())
    t.refuse("half_units", fmt::format("half units beside lintels: {} of course {} {} part of one", join(taken),
                                       floor.course, taken.size() == 1 ? "is" : "are"));
}

}  // namespace

BuildingSpec read_building(Table& t, const Scene& scene) {
  BuildingSpec b;
  const bool counted = t.integer("courses", b.courses, 1, 10000, true);
  if (!counted) b.courses = 10000;
  t.number("course_height", b.course_height, kExtent, "m", true);
  t.number("thickness", b.thickness, kExtent, "m", true);
  t.numbers("zones", b.zones, between(1, 64), "hexahedra per half unit along the wall, up and through it");
  t.number("beam_height", b.beam_height, kExtent, "m");
  t.number("beam_density", b.beam_density, kDensity, "kg/m3");
  t.name_of("unit_material", b.unit_material, scene.materials, "materials", true);
  t.name_of("bed_joint", b.bed_joint, scene.joints, "joints", true);
  t.name_of("head_joint", b.head_joint, scene.joints, "joints", true);
  t.name_of("unit_joint", b.unit_joint, scene.joints, "joints", true);
  t.name_of("beam_joint", b.beam_joint, scene.joints, "joints", true);

  std::vector<std::string> names;
  const auto add_wall = [&](Table& w) {
    const Wall& wall = b.walls.emplace_back(read_wall(w, b, scene));
    if (std::find(names.begin(), names.end(), wall.name) != names.end())
      t.context().fault(fmt::format("{}: a second wall '{}'; allowed: a name of its own", wall.source.text, wall.name));
    names.push_back(wall.name);
  };
  t.each("wall", add_wall, true);
  auto wall_of = [&](Table& table, const char* key, int& wall) {
    std::string name;
    if (!table.choice(key, name, names, true)) return false;
    wall = static_cast<int>(std::find(names.begin(), names.end(), name) - names.begin());
    return true;
  };
  t.each("corner", [&](Table& c) {
    BuildingSpec::Corner& corner = b.corners.emplace_back();
    corner.source = {c.where()};
    c.numbers("at", corner.at, kPlace, "m (x and z of the lowest corner)", true);
    const bool first_known = wall_of(c, "first", corner.first), second_known = wall_of(c, "second", corner.second);
    if (first_known && second_known && corner.first == corner.second) c.refuse("second", "another wall than first");
  });
  t.each("floor", [&](Table& f) {
    BuildingSpec::Floor floor;
    floor.source = {f.where()};
    f.text("name", floor.name, "text, as \"floor_1\"", true);
    const bool known = wall_of(f, "wall", floor.wall);
    const bool placed = f.integer("course", floor.course, 0, b.courses - 1, true);
    const int half_units = known ? b.walls[static_cast<size_t>(floor.wall)].half_units : 20000;
    f.numbers("half_units", floor.half_units, between(0, half_units - 1), "half units of the course", true);
    if (known && placed) refuse_beams_in_lintels(f, floor, b.walls[static_cast<size_t>(floor.wall)]);
    f.boolean("rigid_beams", floor.rigid);
    const bool has_mass = f.number("mass", floor.mass, kNotNegative, "kg (all beams together; it has weight)");
    f.number("load", floor.load, kNotNegative, "N (downwards, all beams together, without inertia)", !has_mass);
    for (const BuildingSpec::Floor& other : b.floors) {
      if (other.name == floor.name) f.refuse("name", "a name that no other floor has");
    }
    b.floors.push_back(floor);
  });
  return b;
}

void add_floor_controls(Stage& stage, const BuildingSpec& building) {
  BodyControl bottom;
  bottom.body = "bottom_beam";
  stage.controls.push_back(bottom);
  add_floor_loads(stage, building);
}

void add_floor_loads(Stage& stage, const BuildingSpec& building) {
  for (const BuildingSpec::Floor& floor : building.floors) {
    const auto bodies = floor.bodies();
    for (const std::string& body : bodies) {
      BodyControl& control = control_of(body, stage);
      if (control.kind[1] == DofKind::free) control.force[1] -= floor.load / static_cast<double>(bodies.size());
    }
  }
}

void watch_building(Stage& stage, const BuildingSpec& building) {
  stage.monitor = "bottom_beam";
  if (!building.floors.empty()) stage.roof = building.floors.back().bodies();
}

void read_weight(Table& t, Stage& stage, const BuildingSpec& building) {
  if (!t.has("gravity")) stage.gravity = {0.0, -9.81, 0.0};
  if (!t.has("ramp_time")) stage.ramp_time = 0.05;
  if (!t.has("equilibrium_ratio") && !stage.duration) stage.equilibrium_ratio = 1e-4;
  if (!t.has("max_steps")) stage.max_steps = 1000000;
  watch_building(stage, building);
  add_floor_controls(stage, building);
}

void read_push(Table& t, Stage& stage, const BuildingSpec& building) {
  double displacement = 0.0, velocity = 0.0;
  t.number("velocity", velocity, kAny, "m/s", true);
  if (t.number("displacement", displacement, kPositive, "m (of the roof)", true)) stage.displacement = displacement;
  if (!t.has("ramp_time")) stage.ramp_time = 0.05;
  if (t.has("velocity") && velocity == 0.0) t.refuse("velocity", "not 0: the stage would never reach its displacement");
  read_whiffletree(t, stage, building);
  stage.whiffletree->velocity = velocity;
}

void read_whiffletree(Table& t, Stage& stage, const BuildingSpec& building) {
  Whiffletree w;
  t.number("stiffness", w.stiffness, kPositive, "N/m", true);
  for (const BuildingSpec::Floor& floor : building.floors) w.floors.push_back(floor.bodies());
  if (w.floors.empty()) t.refuse("kind", "push and cycles need floors to push: give [[building.floor]]");
  watch_building(stage, building);
  add_floor_controls(stage, building);
  stage.whiffletree = std::move(w);
}

}  // namespace quoin
