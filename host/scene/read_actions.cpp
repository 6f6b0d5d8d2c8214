#include "scene/read_actions.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "scene/series_file.h"

namespace quoin {

using namespace reader;

namespace {

constexpr double kFarthest = 1e6;  // m, of a point: beyond, positions in double precision are coarser than a joint

void read_direction(Table& t, const std::string& key, Vec3& direction, const char* what, bool required) {
  constexpr double least = 1e-6;
  const bool given = t.numbers(key, direction, between(-1e6, 1e6), what, required);
  if (given && std::hypot(direction[0], direction[1], direction[2]) < least)
    t.refuse(key, fmt::format("a vector of length {} or more, as [1, 0, 0]", least));
}

TimeSeries read_series(Table& t, const std::string& folder) {
  TimeSeries s;
  std::string file;
  double scale = 1.0;
  t.number("scale", scale, kAny, "(m/s2 in one unit of the series)");
  if (t.text("file", file, "a file of lines: time, acceleration")) {
    for (const char* key : {"time", "acceleration"}) {
      t.accept(key);
      if (t.has(key)) t.refuse(key, "only without file; remove one of the two");
    }
    try {
      t.context().inputs.push_back(file.starts_with('/') ? file : folder + file);
      s = read_series_file(t.context().inputs.back());
    } catch (const Error& error) {
      t.context().fault(fmt::format("{} = '{}':\n{}", t.where("file"), file, error.what()));
    }
  } else {
    const bool timed = t.numbers("time", s.time, kNotNegative, "s, increasing", true);
    if (timed && std::adjacent_find(s.time.begin(), s.time.end(), std::greater_equal<>()) != s.time.end())
      t.refuse("time", "times that increase, s");
    const bool given = t.numbers("acceleration", s.value, kAny, "times scale: m/s2", true);
    if (timed && given && s.time.size() != s.value.size()) {
      t.context().fault(fmt::format("{}: {} times and {} accelerations; give as many of both", t.where(), s.time.size(),
                                    s.value.size()));
    }
  }
  for (double& v : s.value) v *= scale;
  if (!std::all_of(s.value.begin(), s.value.end(), [](double v) { return std::isfinite(v); }))
    t.refuse("scale", "a number that keeps every acceleration finite");
  return s;
}

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

GroundMotion read_ground(Table g, const std::string& folder) {
  GroundMotion ground{};
  read_direction(g, "direction", ground.direction, "of the motion", true);
  ground.acceleration = read_series(g, folder);
  g.finish();
  return ground;
}

Collapse read_collapse(Table c) {
  Collapse collapse;
  read_direction(c, "direction", collapse.direction, "of the body force", false);
  c.number("start", collapse.start, kNotNegative, "times the weight");
  c.number("rate", collapse.rate, kPositive, "times the weight, 1/s");
  c.number("displacement", collapse.displacement, kPositive, "m");
  c.number("limit", collapse.limit, kPositive, "times the weight");
  if (collapse.limit <= collapse.start) {
    c.refuse(c.has("limit") ? "limit" : "start",
             fmt::format("a limit ({}) of more than start ({})", collapse.limit, collapse.start));
  }
  c.finish();
  return collapse;
}

}  // namespace

bool has_actions(const Table& t) {
  const toml::node* pressure = t.toml().get("pressure");
  return t.has("ground_motion") || t.has("collapse") || t.has("force") || (pressure && pressure->is_array());
}

void read_actions(Table& t, Stage& stage, const std::string& folder, const std::vector<std::string>& names) {
  int index = 0;
  for (const toml::table* table : t.tables("force", "tables [[stage.force]]"))
    stage.forces.push_back(read_force({t.context(), *table, fmt::format("{}.{}", t.path("force"), ++index)}, names));
  index = 0;
  for (const toml::table* table : t.tables("pressure", "tables [[stage.pressure]]"))
    stage.pressures.push_back(
        read_pressure({t.context(), *table, fmt::format("{}.{}", t.path("pressure"), ++index)}, names));
  if (const auto* table = t.table("ground_motion", "a table { direction, time, acceleration } or { direction, file }"))
    stage.ground = read_ground({t.context(), *table, t.path("ground_motion")}, folder);
  if (const auto* table = t.table("collapse", "a table { direction, start, rate, displacement, limit }"))
    stage.collapse = read_collapse({t.context(), *table, t.path("collapse")});
}

}  // namespace quoin
