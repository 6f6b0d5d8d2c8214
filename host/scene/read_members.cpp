#include "scene/read_members.h"

#include <cmath>
#include <numbers>
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
  e.numbers("plate", end.plate, kPositive, "m, both sides of the anchor plate");
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

std::vector<MemberEnd> read_through(Table& t) {
  std::vector<MemberEnd> ends;
  int index = 0;
  for (const toml::table* table : t.tables("through", "tables { block = NAME, point = [x, y, z] }")) {
    Table e(t.context(), *table, t.path(fmt::format("through.{}", ++index)));
    MemberEnd end;
    end.source = {e.where()};
    e.text("block", end.block, "the name of a block; without it the block that has the point");
    e.numbers("point", end.point, between(-kFarthest, kFarthest), "m, at the start", true);
    e.finish();
    ends.push_back(end);
  }
  return ends;
}

TieSpec read_tie(Table t, int number, std::set<std::string>& taken) {
  TieSpec tie;
  tie.source = {t.where()};
  read_name(t, std::to_string(number), taken, tie.name);
  tie.from = read_end(t, "from"), tie.to = read_end(t, "to");
  tie.through = read_through(t);
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
  constexpr double kMostNodes = 200;  // most nodes of an edge: a floor of more costs as much as its walls
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

DowelSpec read_dowel(Table t, int number, std::set<std::string>& taken) {
  DowelSpec dowel;
  dowel.source = {t.where()};
  read_name(t, std::to_string(number), taken, dowel.name);
  t.numbers("point", dowel.point, between(-kFarthest, kFarthest), "m, on the joint", true);
  read_direction(t, "direction", dowel.direction, "of the bar, through the joint", true);
  t.number("axial_stiffness", dowel.axial_stiffness, kPositive, "N/m", true);
  t.number("shear_stiffness", dowel.shear_stiffness, kPositive, "N/m", true);
  t.number("yield_force", dowel.yield_force, kPositive, "N, along the bar", true);
  t.number("yield_shear", dowel.yield_shear, kPositive, "N, across it", true);
  t.finish();
  return dowel;
}

// Coefficients after Rankine and Jaky, unless they are given.
void read_pressure(Table& t, FillSpec& fill) {
  if (!t.number("friction_angle", fill.friction_angle, between(0.0, 89.0), "deg", true)) return;
  const double sine = std::sin(fill.friction_angle * std::numbers::pi / 180.0);
  fill.active = (1.0 - sine) / (1.0 + sine), fill.passive = (1.0 + sine) / (1.0 - sine), fill.at_rest = 1.0 - sine;
  t.number("active", fill.active, kNotNegative, "(horizontal over vertical stress)");
  t.number("at_rest", fill.at_rest, kNotNegative, "(horizontal over vertical stress)");
  t.number("passive", fill.passive, kNotNegative, "(horizontal over vertical stress)");
  if (fill.active > fill.at_rest || fill.at_rest > fill.passive)
    t.refuse(t.has("at_rest")  ? "at_rest"
             : t.has("active") ? "active"
                               : "passive",
             fmt::format("active ({:.4g}) at most at_rest ({:.4g}), and that at most passive ({:.4g})", fill.active,
                         fill.at_rest, fill.passive));
}

FillSpec read_fill(Table t, int number, std::set<std::string>& taken) {
  FillSpec fill;
  fill.source = {t.where()};
  read_name(t, std::to_string(number), taken, fill.name);
  t.text("block", fill.block, "the name of a block, or of a group of them", true);
  read_direction(t, "towards", fill.towards, "outward, of the faces that are meant", false);
  t.numbers("surface", fill.surface, between(-kFarthest, kFarthest), "m, a point of its top", true);
  read_direction(t, "up", fill.up, "against gravity", false);
  t.number("unit_weight", fill.unit_weight, kPositive, "N/m3", true);
  t.number("surcharge", fill.surcharge, kNotNegative, "Pa");
  read_pressure(t, fill);
  t.number("stiffness", fill.stiffness, kPositive, "Pa/m", true);
  t.integer("divisions", fill.divisions, 1, 50);
  t.finish();
  return fill;
}

// The kind of the first member that there is.
const char* first_kind(const MemberSpecs& specs) {
  return !specs.ties.empty()      ? "tie"
         : !specs.springs.empty() ? "spring"
         : !specs.strips.empty()  ? "strip"
         : !specs.floors.empty()  ? "floor"
         : !specs.beams.empty()   ? "beam"
         : !specs.dowels.empty()  ? "dowel"
         : !specs.fills.empty()   ? "fill"
                                  : nullptr;
}

}  // namespace

std::shared_ptr<const MemberSpecs> read_members(Table& t, const Scene& scene) {
  auto specs = std::make_shared<MemberSpecs>();
  std::set<std::string> taken;
  // read(table, number): adds it. Names are of a kind.
  const auto each = [&](const std::vector<const toml::table*>& tables, const char* kind, const auto& read) {
    int index = 0;
    taken.clear();
    for (const toml::table* table : tables) {
      ++index;
      read(Table(t.context(), *table, fmt::format("{}.{}", kind, index)), index);
    }
  };
  each(t.tables("tie", "tables [[tie]]"), "tie",
       [&](Table m, int i) { specs->ties.push_back(read_tie(std::move(m), i, taken)); });
  each(t.tables("spring", "tables [[spring]]"), "spring",
       [&](Table m, int i) { specs->springs.push_back(read_spring(std::move(m), i, taken)); });
  each(t.tables("strip", "tables [[strip]]"), "strip",
       [&](Table m, int i) { specs->strips.push_back(read_strip(std::move(m), i, scene, taken)); });
  each(t.tables("floor", "tables [[floor]]"), "floor",
       [&](Table m, int i) { specs->floors.push_back(read_floor(std::move(m), i, taken)); });
  each(t.tables("beam", "tables [[beam]]"), "beam",
       [&](Table m, int i) { specs->beams.push_back(read_beam(std::move(m), i, taken)); });
  each(t.tables("dowel", "tables [[dowel]]"), "dowel",
       [&](Table m, int i) { specs->dowels.push_back(read_dowel(std::move(m), i, taken)); });
  each(t.tables("fill", "tables [[fill]]"), "fill",
       [&](Table m, int i) { specs->fills.push_back(read_fill(std::move(m), i, taken)); });
  const char* const kind = first_kind(*specs);
  if (!kind) return nullptr;
  if (scene.wall && scene.wall->half_thickness)
    t.refuse(kind, "none with wall.half_thickness = true: members have no half; make that false");
  return specs;
}

}  // namespace quoin
