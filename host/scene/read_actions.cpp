#include "scene/read_actions.h"

#include <algorithm>
#include <cmath>

#include "scene/collapse_load.h"
#include "scene/read_ground.h"

namespace quoin {

using namespace reader;

namespace {

// The block that something acts on. names: those that the scene has; empty: they are looked up later.
void read_name(Table& t, std::string& block, const std::vector<std::string>& names) {
  if (names.empty())
    t.text("block", block, "the name of a block", true);
  else
    t.choice("block", block, names, true);
}

PointForce read_force(Table f, const std::vector<std::string>& names) {
  PointForce c{};
  read_name(f, c.block, names);
  f.numbers("point", c.point, between(-kFarthest, kFarthest), "m, where it acts at the start; it moves with the block",
            true);
  f.numbers("force", c.force, kAny, "N", true);
  f.finish();
  return c;
}

FacePressure read_pressure(Table p, const std::vector<std::string>& names) {
  FacePressure c{};
  read_name(p, c.block, names);
  read_direction(p, "normal", c.normal, "outward, of the face that is meant", true);
  p.number("pressure", c.pressure, kAny, "Pa, > 0 pushes on the block", true);
  p.finish();
  return c;
}

MovingLoad read_moving_load(Table m) {
  MovingLoad load;
  m.numbers("from", load.from, between(-kFarthest, kFarthest), "m, where it begins", true);
  m.numbers("to", load.to, between(-kFarthest, kFarthest), "m, where it ends", true);
  if (m.numbers("force", load.force, kAny, "N", true) && load.force == Vec3{})
    m.refuse("force", "a force that is not 0");
  if (m.integer("positions", load.positions, 1, 2000) && load.positions < 2 && load.from != load.to)
    m.refuse("positions", "2 or more along a line, to the end of which the load goes");
  if (load.from == load.to) load.positions = 1;
  m.finish();
  return load;
}

Collapse read_collapse(Table c) {
  Collapse collapse;
  read_direction(c, "direction", collapse.direction, "of the body force", false);
  const auto is_word = [&](const char* key) {
    const toml::node* node = c.toml().get(key);
    return node && node->is_string();
  };
  std::string word;
  if (!is_word("start"))
    c.number("start", *collapse.start, kNotNegative, "times the weight, or \"limit\"");
  else if (c.choice("start", word, {"limit"}))
    collapse.start.reset();
  if (!is_word("rate"))
    c.number("rate", *collapse.rate, kPositive, "times the weight, 1/s, or \"auto\"");
  else if (c.choice("rate", word, {"auto"}))
    collapse.rate.reset();
  if (!collapse.start && !c.has("rate")) collapse.rate.reset();
  if (waits(collapse) && collapse.start == 0.0)
    c.refuse("rate",
             "\"auto\" with a start of more than 0 (times the weight), of which it is a share; give start, or "
             "start = \"limit\"");
  c.number("displacement", collapse.displacement, kPositive, "m");
  c.number("limit", *collapse.limit, kPositive, "times the weight");
  if (collapse.start && *collapse.limit <= *collapse.start) {
    c.refuse(c.has("limit") ? "limit" : "start",
             fmt::format("a limit ({}) of more than start ({})", *collapse.limit, *collapse.start));
  }
  if (!collapse.start && !c.has("limit")) collapse.limit.reset();
  c.finish();
  return collapse;
}

}  // namespace

bool has_actions(const Table& t) {
  const toml::node* pressure = t.toml().get("pressure");
  return t.has("ground_motion") || t.has("collapse") || t.has("force") || t.has("moving_load") ||
         (pressure && pressure->is_array());
}

void read_actions(Table& t, Stage& stage, const std::string& folder, const std::vector<std::string>& names) {
  int index = 0;
  for (const toml::table* table : t.tables("force", "tables [[stage.force]]"))
    stage.forces.push_back(read_force({t.context(), *table, fmt::format("{}.{}", t.path("force"), ++index)}, names));
  if (const auto* table = t.table("moving_load", "a table { from, to, force, positions }")) {
    stage.moving_load = read_moving_load({t.context(), *table, t.path("moving_load")});
    if (!stage.duration && !t.has("duration"))
      t.refuse("moving_load", "with duration (s) of the stage, in which the load goes along its line after ramp_time");
    else if (stage.duration && *stage.duration <= stage.ramp_time)
      t.refuse("duration", fmt::format("more than ramp_time ({:g} s), after which moving_load moves", stage.ramp_time));
  }
  index = 0;
  for (const toml::table* table : t.tables("pressure", "tables [[stage.pressure]]"))
    stage.pressures.push_back(
        read_pressure({t.context(), *table, fmt::format("{}.{}", t.path("pressure"), ++index)}, names));
  if (const auto* table =
          t.table("ground_motion",
                  "a table { direction, time, acceleration } or { direction, file }, or of files along x, y, z"))
    stage.ground = read_ground({t.context(), *table, t.path("ground_motion")}, folder);
  if (const auto* table = t.table("collapse", "a table { direction, start, rate, displacement, limit }"))
    stage.collapse = read_collapse({t.context(), *table, t.path("collapse")});
}

}  // namespace quoin
