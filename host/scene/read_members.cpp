#include "scene/read_members.h"

#include <set>

#include "geometry/vector.h"
#include "scene/read_ground.h"

namespace quoin {

using namespace reader;

namespace {

constexpr double kFarthest = 1e6;  // m, of a point: beyond, positions in double precision are coarser than a joint

MemberEnd read_end(Table& t, const std::string& key) {
  MemberEnd end;
  end.source = {t.where(key)};
  const toml::table* given = t.table(key, "a table { block = NAME, point = [x, y, z] }", true);
  if (!given) return end;
  Table e(t.context(), *given, t.path(key));
  e.text("block", end.block, "the name of a block; without it the block that has the point");
  e.numbers("point", end.point, between(-kFarthest, kFarthest), "m, at the start", true);
  e.finish();
  return end;
}

// Names go into columns of files.
void read_name(Table& t, const std::string& fallback, std::set<std::string>& taken, std::string& name) {
  constexpr const char* allowed = "letters, digits, '_' and '-'";
  name = fallback;
  t.text("name", name, allowed);
  const bool plain = !name.empty() && std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) || c == '_' || c == '-';
  });
  if (!plain)
    t.refuse("name", allowed);
  else if (!taken.insert(name).second)
    t.context().fault(
        fmt::format("{}: the name '{}' is taken by another member of this kind; give name = one of its "
                    "own",
                    t.where(), name));
}

TieSpec read_tie(Table t, int number, std::set<std::string>& taken) {
  TieSpec tie;
  tie.source = {t.where()};
  read_name(t, std::to_string(number), taken, tie.name);
  tie.from = read_end(t, "from"), tie.to = read_end(t, "to");
  t.number("area", tie.area, kPositive, "m2", true);
  t.number("young_modulus", tie.young_modulus, kPositive, "Pa", true);
  const bool yields = t.number("yield_stress", tie.yield_stress, kPositive, "Pa", true);
  if (t.number("pretension", tie.pretension, kNotNegative, "N") && yields && tie.pretension > tie.yield_force())
    t.refuse("pretension", fmt::format("0 to {:g} N, area times yield_stress", tie.yield_force()));
  if (t.number("hardening", tie.hardening, kNotNegative, "(tangent modulus over young_modulus)") &&
      tie.hardening >= 1.0)
    t.refuse("hardening", "0 or more and less than 1: tangent modulus beyond yield over young_modulus");
  if (t.number("rupture_strain", tie.rupture_strain, kPositive, "(elongation over length)") && yields &&
      tie.rupture_strain * tie.young_modulus <= tie.yield_stress)
    t.refuse("rupture_strain",
             fmt::format("more than {:g}, the strain at yield", tie.yield_stress / tie.young_modulus));
  t.number("slack", tie.slack, kNotNegative, "m");
  t.boolean("compression", tie.compression);
  if (tie.slack > 0.0 && (tie.pretension > 0.0 || tie.compression))
    t.refuse("slack", "0 with pretension or compression, which leave no slack");
  t.finish();
  return tie;
}

SpringSpec read_spring(Table t, int number, std::set<std::string>& taken) {
  SpringSpec spring;
  spring.source = {t.where()};
  read_name(t, std::to_string(number), taken, spring.name);
  t.text("block", spring.block, "the name of a block", true);
  read_direction(t, "normal", spring.normal, "outward, of the face that is meant", false);
  t.number("normal_stiffness", spring.normal_stiffness, kPositive, "Pa/m", true);
  t.number("shear_stiffness", spring.shear_stiffness, kNotNegative, "Pa/m");
  t.number("normal_dashpot", spring.normal_dashpot, kNotNegative, "Pa s/m");
  t.number("shear_dashpot", spring.shear_dashpot, kNotNegative, "Pa s/m");
  t.number("friction_angle", spring.friction_angle, between(0.0, 90.0), "deg");
  t.boolean("tension", spring.tension);
  if (spring.tension && t.has("friction_angle") && spring.friction_angle < 90.0)
    t.refuse("friction_angle", "90 with tension = true, which has no pressure to rub by; remove one of the two");
  t.integer("divisions", spring.divisions, 1, 50);
  t.finish();
  return spring;
}

std::vector<Vec3> read_line(Table& t) {
  std::vector<Vec3> points;
  const std::string allowed = fmt::format("a list of 2 or more points [x, y, z], each {}, m, no two in a row the same",
                                          between(-kFarthest, kFarthest).text());
  const toml::node* node = t.find("points", allowed, true);
  if (!node) return points;
  const toml::array* list = node->as_array();
  if (!list) return t.wrong_type("points", *node, allowed), points;
  for (const toml::node& element : *list) {
    const toml::array* given = element.as_array();
    if (!given || given->size() != 3) return t.wrong_type("points", *node, allowed), points;
    Vec3 point{};
    for (std::size_t c = 0; c < 3; ++c) {
      const std::optional<double> number = number_of(*given->get(c));
      if (!number) return t.wrong_type("points", *node, allowed), points;
      if (!(std::abs(*number) <= kFarthest)) return t.refuse("points", allowed), points;
      point[c] = *number;
    }
    if (!points.empty() && points.back() == point) return t.refuse("points", allowed), points;
    points.push_back(point);
  }
  if (points.size() < 2) t.refuse("points", allowed);
  return points;
}

StripSpec read_strip(Table t, int number, const Scene& scene, std::set<std::string>& taken) {
  StripSpec strip;
  strip.source = {t.where()};
  read_name(t, std::to_string(number), taken, strip.name);
  std::vector<std::string> families;
  for (const auto& [name, family] : scene.joints) families.push_back(name);
  t.choice("joint", strip.joint, families, true);
  strip.points = read_line(t);
  t.number("width", strip.width, kPositive, "m", true);
  t.number("thickness", strip.thickness, kPositive, "m", true);
  t.number("young_modulus", strip.young_modulus, kPositive, "Pa", true);
  t.number("strength", strip.strength, kPositive, "Pa");
  t.number("spacing", strip.spacing, kPositive, "m", true);
  t.boolean("compression", strip.compression);
  t.finish();
  return strip;
}

void read_connector(Table& t, FloorSpec& floor) {
  const toml::table* given = t.table("connector", "a table { axial_stiffness, shear_stiffness, ... }", true);
  if (!given) return;
  Table c(t.context(), *given, t.path("connector"));
  c.number("axial_stiffness", floor.axial_stiffness, kPositive, "N/m of a metre of edge", true);
  c.number("shear_stiffness", floor.connector_stiffness, kNotNegative, "N/m of a metre of edge", true);
  c.number("axial_strength", floor.axial_strength, kNotNegative, "N of a metre of edge");
  c.number("shear_strength", floor.connector_strength, kNotNegative, "N of a metre of edge");
  c.number("friction", floor.friction, between(0.0, 2.0), "(shear over the weight on the edge)");
  c.number("pull_out", floor.pull_out, kPositive, "m");
  c.boolean("bearing", floor.bearing);
  c.finish();
}

FloorSpec read_floor(Table t, int number, std::set<std::string>& taken) {
  FloorSpec floor;
  floor.source = {t.where()};
  read_name(t, std::to_string(number), taken, floor.name);
  t.numbers("corner", floor.corner, between(-kFarthest, kFarthest), "m", true);
  read_direction(t, "along", floor.along, "m, from the corner to the next", true);
  read_direction(t, "across", floor.across, "m, from the corner to the one before, square to along", true);
  constexpr double kSquare = 1e-6;  // cosine of the angle between both edges
  const geometry::Vector a = geometry::vector(floor.along), b = geometry::vector(floor.across);
  if (std::abs(dot(a, b)) > kSquare * norm(a) * norm(b)) t.refuse("across", "a vector square to along");
  t.number("spacing", floor.spacing, kPositive, "m", true);
  constexpr double kMostNodes = 200;  // of an edge: a floor of more costs as much as its walls
  const double longest = std::max(norm(a), norm(b));
  if (floor.spacing > 0.0 && longest > kMostNodes * floor.spacing)
    t.refuse("spacing",
             fmt::format("at least {:.3g} m, a {:.0f}th of the longest edge", longest / kMostNodes, kMostNodes));
  std::array<double, 2> axial{};
  t.numbers("axial_stiffness", axial, kPositive, "N/m along and across: modulus times thickness", true);
  floor.stiffness_along = axial[0], floor.stiffness_across = axial[1];
  t.number("shear_stiffness", floor.shear_stiffness, kPositive, "N/m: shear modulus times thickness", true);
  t.number("shear_yield", floor.shear_yield, kPositive, "N/m");
  t.number("mass", floor.mass, kPositive, "kg/m2", true);
  t.number("load", floor.load, kNotNegative, "Pa");
  t.choice("span", floor.span, {"along", "across", "both"});
  read_connector(t, floor);
  t.finish();
  return floor;
}

void read_supports(Table& t, BeamSpec& beam) {
  int index = 0;
  for (const toml::table* table : t.tables("support", "tables [[beam.support]]")) {
    ++index;
    Table s(t.context(), *table, t.path(fmt::format("support.{}", index)));
    BeamSupportSpec support;
    support.source = {s.where()};
    s.numbers("point", support.point, between(-kFarthest, kFarthest), "m, on the line", true);
    s.text("block", support.block, "the name of a block; without it the block that has the point");
    s.choice("hold", support.hold, {"built_in", "pinned", "resting"});
    s.finish();
    beam.supports.push_back(support);
  }
}

BeamSpec read_beam(Table t, int number, std::set<std::string>& taken) {
  BeamSpec beam;
  beam.source = {t.where()};
  read_name(t, std::to_string(number), taken, beam.name);
  beam.points = read_line(t);
  t.number("spacing", beam.spacing, kPositive, "m", true);
  read_direction(t, "up", beam.up, "across the line", false);
  for (std::size_t k = 0; k + 1 < beam.points.size(); ++k) {
    constexpr double kAcross = 0.05;  // sine of the angle between `up` and the line
    const geometry::Vector up = geometry::vector(beam.up),
                           way = geometry::vector(beam.points[k + 1]) - geometry::vector(beam.points[k]);
    if (norm(cross(up, way)) > kAcross * norm(up) * norm(way)) continue;
    t.refuse("up", fmt::format("a vector across the line, which runs along it from point {} on", k + 1));
    break;
  }
  t.number("area", beam.area, kPositive, "m2", true);
  t.numbers("inertia", beam.inertia, kNotNegative, "m4, of bending towards up and to the side");
  t.numbers("shear_area", beam.shear_area, kPositive, "m2");
  t.number("torsion", beam.torsion, kNotNegative, "m4");
  t.number("young_modulus", beam.young_modulus, kPositive, "Pa", true);
  t.number("poisson_ratio", beam.poisson_ratio, between(0.0, 0.5), "");
  t.number("density", beam.density, kPositive, "kg/m3", true);
  t.number("yield_force", beam.yield_force, kPositive, "N");
  t.numbers("yield_moment", beam.yield_moment, kPositive, "N m, towards up and to the side");
  t.boolean("compression", beam.compression);
  t.number("support_stiffness", beam.support_stiffness, kPositive, "N/m");
  t.number("friction", beam.friction, between(0.0, 2.0), "");
  t.choice("bedding", beam.bedding, {"none", "resting", "pinned", "built_in"});
  if ((beam.inertia[0] == 0.0) != (beam.inertia[1] == 0.0)) t.refuse("inertia", "both more than 0, or both 0: a cable");
  read_supports(t, beam);
  t.finish();
  return beam;
}

}  // namespace

std::shared_ptr<const MemberSpecs> read_members(Table& t, const Scene& scene) {
  auto specs = std::make_shared<MemberSpecs>();
  std::set<std::string> taken;
  int index = 0;
  for (const toml::table* table : t.tables("tie", "tables [[tie]]")) {
    ++index;
    specs->ties.push_back(read_tie({t.context(), *table, fmt::format("tie.{}", index)}, index, taken));
  }
  index = 0, taken.clear();
  for (const toml::table* table : t.tables("spring", "tables [[spring]]")) {
    ++index;
    specs->springs.push_back(read_spring({t.context(), *table, fmt::format("spring.{}", index)}, index, taken));
  }
  index = 0, taken.clear();
  for (const toml::table* table : t.tables("strip", "tables [[strip]]")) {
    ++index;
    specs->strips.push_back(read_strip({t.context(), *table, fmt::format("strip.{}", index)}, index, scene, taken));
  }
  index = 0, taken.clear();
  for (const toml::table* table : t.tables("floor", "tables [[floor]]")) {
    ++index;
    specs->floors.push_back(read_floor({t.context(), *table, fmt::format("floor.{}", index)}, index, taken));
  }
  index = 0, taken.clear();
  for (const toml::table* table : t.tables("beam", "tables [[beam]]")) {
    ++index;
    specs->beams.push_back(read_beam({t.context(), *table, fmt::format("beam.{}", index)}, index, taken));
  }
  if (specs->ties.empty() && specs->springs.empty() && specs->strips.empty() && specs->floors.empty() &&
      specs->beams.empty())
    return nullptr;
  if (scene.wall && scene.wall->half_thickness)
    t.refuse(!specs->ties.empty()      ? "tie"
             : !specs->springs.empty() ? "spring"
             : !specs->strips.empty()  ? "strip"
             : !specs->floors.empty()  ? "floor"
                                       : "beam",
             "none with wall.half_thickness = true: members have no half; make that false");
  return specs;
}

}  // namespace quoin
