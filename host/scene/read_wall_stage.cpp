#include <algorithm>
#include <cmath>

#include "scene/actions/actions.h"
#include "scene/driven.h"
#include "scene/generate.h"
#include "scene/read_tables.h"

namespace quoin {

using namespace reader;

namespace {

// Names of deformable blocks that loads may have.
std::vector<std::string> loaded_names(const Scene& scene) {
  std::vector<std::string> names;
  if (!scene.building) return names;
  for (const BuildingSpec::Floor& floor : scene.building->floors) {
    if (floor.rigid) continue;
    for (const std::string& body : floor.bodies()) names.push_back(body);
  }
  return names;
}

// Names of bodies that controls may have.
std::vector<std::string> body_names(const Scene& scene) {
  std::vector<std::string> names;
  if (scene.building) {
    names.push_back("bottom_beam");
    for (const BuildingSpec::Floor& floor : scene.building->floors) {
      if (!floor.rigid) continue;
      for (const std::string& body : floor.bodies()) names.push_back(body);
    }
  }
  if (scene.wall) names = scene.wall->bottom_beams();
  if (scene.wall && scene.wall->top_beam) names.push_back("top_beam");
  if (scene.wall && scene.wall->rigid_units) names.insert(names.end(), {"bottom_course", "top_course"});
  return names;
}

BodyControl read_control(Table& t, std::vector<std::string> bodies, const std::vector<std::string>& loaded) {
  BodyControl c;
  bodies.insert(bodies.end(), loaded.begin(), loaded.end());
  t.choice("body", c.body, bodies, true);
  t.velocity(c, false);
  bool held = true;
  t.boolean("rotation_held", held);
  c.may_turn = !held;
  if (t.numbers("force", c.force, kAny, "N")) {
    for (size_t i = 0; i < 3; ++i) {
      if (c.force[i] != 0.0 && c.kind[i] == DofKind::velocity)
        t.refuse("force", "0 along components whose velocity is prescribed; make them \"free\" in velocity");
    }
  }
  if (std::find(loaded.begin(), loaded.end(), c.body) != loaded.end() &&
      std::find(c.kind.begin(), c.kind.end(), DofKind::velocity) != c.kind.end())
    t.refuse("body",
             "a rigid body, or velocity = [\"free\", \"free\", \"free\"]: half units of a floor without "
             "rigid_beams can be loaded but not moved");
  return c;
}

void read_controls(Table& t, Stage& stage, const std::vector<std::string>& bodies, const Scene& scene) {
  t.each("control", [&](Table& c) {
    const BodyControl control = read_control(c, bodies, loaded_names(scene));
    c.refuse_second("body", control, stage.controls);
    stage.controls.push_back(control);
  });
}

bool has_top_beam(const Scene& scene) { return scene.wall && scene.wall->top_beam; }

// Holds what stands for the ground and has no control in a stage.
void hold_ground(Stage& stage, const Scene& scene) {
  for (const std::string& body : body_names(scene)) {
    if (is_ground(scene, body) && !std::ranges::count(stage.controls, body, &BodyControl::body))
      stage.controls.emplace_back().body = body;
  }
}

// Adds the controls of the short kinds of stage: the bottom beam held, the top beam, if any, pressed or moved.
void add_beam_controls(Stage& stage, const Scene& scene, double top_force, bool top_free, double top_velocity) {
  if (!scene.wall) return;
  hold_ground(stage, scene);
  if (!has_top_beam(scene)) return;
  BodyControl& top = stage.controls.emplace_back();
  top.body = "top_beam";
  if (top_free) {
    top.kind[1] = DofKind::free;
    top.force[1] = -top_force;
  }
  top.velocity[0] = top_velocity;
}

// Adds the supports and loads of bodies without a control in a stage with forces, pressures, ground motion or collapse,
// or without any control. The lower beam is the ground. The upper one is free under the pressure of the last pressure
// stage. Floors have their loads.
void add_loads_of_before(Stage& stage, const Scene& scene, double top_force) {
  const bool is_controlled = std::ranges::count(stage.controls, "top_beam", &BodyControl::body) > 0;
  if (has_top_beam(scene) && top_force > 0.0 && !is_controlled) control_of("top_beam", stage).force[1] = -top_force;
  if (scene.building) add_floor_loads(stage, *scene.building);
}

// Reads a custom stage: controls and actions.
void read_custom(Table& t, Stage& stage, const Scene& scene, std::vector<std::string> bodies, double top_force,
                 const std::string& folder) {
  read_controls(t, stage, bodies, scene);
  stage.has_no_control = stage.controls.empty();
  const std::vector<std::string> held = bodies, loaded = loaded_names(scene);
  bodies.insert(bodies.end(), loaded.begin(), loaded.end());
  read_actions(t, stage, folder, bodies);
  const bool acts = !beyond_lattice(stage).empty();
  read_stage_solver(t, stage, scene);
  if (scene.building && !t.has("monitor")) watch_building(stage, *scene.building);
  read_monitor(t, stage, acts ? &bodies : &held);
  if (acts || stage.has_no_control)
    add_loads_of_before(stage, scene, top_force);
  else
    hold_ground(stage, scene);
  require_end(t, stage);
  const bool on_ground = scene.building && stage.roof.empty() && !t.has("monitor");
  if (stage.displacement && (stage.monitor.empty() || on_ground))
    t.refuse("displacement", "only with a monitor body to measure; give monitor");
}

}  // namespace

Stage read_stage(Table t, Scene& scene, const Stage* previous, double& pressure, const std::string& folder) {
  const Quality& quality = quality_named(scene.quality);
  Stage stage;
  stage.source = {t.where()};
  const std::vector<std::string> bodies = body_names(scene);
  std::string kind = "custom";
  const std::vector<std::string> kinds =
      scene.building ? std::vector<std::string>{"weight", "rest", "push", "cycles", "custom"}
                     : std::vector<std::string>{"pressure", "rest", "shear", "cycles", "custom"};
  const bool acts = has_actions(t) && !t.has("kind");
  const bool kind_known = t.choice("kind", kind, kinds, !acts) || acts;
  stage.name = stage.kind = kind;
  read_stage_basics(t, stage, previous);

  const bool top = has_top_beam(scene);
  stage.monitor = top ? "top_beam" : "";
  if (kind == "pressure" || kind == "shear" || (kind == "rest" && t.has("pressure"))) {
    if (!top && scene.wall) t.refuse("kind", "pressure and shear need a top beam to act on: wall.top_beam = true");
  }
  const double area = scene.wall ? bed_area(*scene.wall) / (scene.wall->half_thickness ? 2.0 : 1.0) : 0.0;
  if (kind == "pressure") {
    t.number("pressure", pressure, kNotNegative, "Pa (downwards on the gross bed area)", true);
    if (!t.has("ramp_time")) stage.ramp_time = 0.005;
    if (!t.has("equilibrium_ratio") && !stage.duration) stage.equilibrium_ratio = quality.equilibrium_ratio;
    if (!t.has("max_steps")) stage.max_steps = 1000000;
    add_beam_controls(stage, scene, pressure * area, true, 0.0);
  } else if (kind == "shear") {
    double velocity = quality.velocity;
    bool pressed = false;
    const bool velocity_known = !t.has("velocity") || t.number("velocity", velocity, kAny, "m/s");
    scene.quality_as_is = scene.quality_as_is && std::abs(velocity) == quality.velocity;
    t.number("displacement", stage.displacement, kPositive, "m");
    t.choice("vertical", pressed, {{"held", false}, {"pressure", true}});
    if (!t.has("ramp_time")) stage.ramp_time = 0.05;
    if (!t.has("displacement") && !t.has("duration") && !t.has("equilibrium_ratio"))
      t.find("displacement", "a number, more than 0 m (or give duration)", true);
    if (velocity_known && velocity == 0.0 && stage.displacement)
      t.refuse("velocity", "not 0: the stage would never reach its displacement");
    add_beam_controls(stage, scene, pressure * area, pressed, velocity);
  } else if (kind == "weight") {
    read_weight(t, stage, *scene.building);
  } else if (kind == "rest") {
    if (scene.building) read_weight(t, stage, *scene.building);
    if (!scene.building) t.number("pressure", pressure, kNotNegative, "Pa (downwards on the gross bed area)");
    if (!scene.building) add_beam_controls(stage, scene, pressure * area, true, 0.0);
    read_rest(t, stage);
  } else if (kind == "push") {
    read_push(t, stage, *scene.building);
  } else if (kind == "cycles" && (t.has("body") || t.has("control"))) {
    read_cycles(t, stage);
    read_controls(t, stage, bodies, scene);
    read_cycled_body(t, "body", &bodies, stage);
    hold_ground(stage, scene);
    if (scene.building) add_floor_loads(stage, *scene.building);
  } else if (kind == "cycles" && scene.building) {
    read_cycles(t, stage);
    read_whiffletree(t, stage, *scene.building);
  } else if (kind == "cycles") {
    if (!top) t.refuse("kind", "cycles move the top beam, which the wall does not have: wall.top_beam = true, or body");
    read_cycles(t, stage);
    bool pressed = false;
    t.choice("vertical", pressed, {{"held", false}, {"pressure", true}});
    add_beam_controls(stage, scene, pressure * area, pressed, stage.cycles->velocity);
    if (top) stage.controls.back().in_cycles = 0;
  } else if (kind_known) {
    read_custom(t, stage, scene, bodies, pressure * area, folder);
  }

  if (stage.cycles) scene.quality_as_is = scene.quality_as_is && std::abs(stage.cycles->velocity) == quality.velocity;
  read_law_swaps(t, scene, stage);
  if (!kind_known) return stage;  // the allowed keys depend on the kind
  t.finish();
  return stage;
}

}  // namespace quoin
