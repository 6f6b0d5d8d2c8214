#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <set>

#include "geometry/vector.h"
#include "scene/read_ground.h"
#include "scene/read_tables.h"

namespace quoin {

using namespace reader;

namespace {

void read_place(Table& t, MemberEnd& end) {
  end.source = {t.where()};
  t.text("block", end.block, "the name of a block; without it the block that has the point");
  t.numbers("point", end.point, kPlace, "m, at the start", true);
}

void read_end(Table& t, const std::string& key, MemberEnd& end) {
  const auto read = [&](Table& e) {
    read_place(e, end);
    e.numbers("plate", end.plate, kPositive, "m, both sides of the anchor plate");
  };
  end.source = {t.where(key)};
  t.within(key, "a table { block = NAME, point = [x, y, z] }", read, true);
}

// Reads a name, which becomes part of columns of files.
void read_name(Table& t, const std::string& fallback, std::set<std::string>& taken, std::string& name) {
  constexpr const char* allowed = "letters, digits, '_' and '-'";
  name = fallback;
  t.text("name", name, allowed);
  if (!is_plain_name(name))
    t.refuse("name", allowed);
  else if (!taken.insert(name).second)
    t.context().fault(
        fmt::format("{}: the name '{}' is taken by another member of this kind; give name = one of its "
                    "own",
                    t.where(), name));
}

void read_tie(Table& t, TieSpec& tie) {
  read_end(t, "from", tie.from), read_end(t, "to", tie.to);
  t.each(
      "through", [&](Table& e) { read_place(e, tie.through.emplace_back()); }, false,
      "tables { block = NAME, point = [x, y, z] }");
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
}

void read_spring(Table& t, SpringSpec& spring) {
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
}

void read_line(Table& t, std::vector<Vec3>& points) {
  t.line("points", points, kPlace,
         fmt::format("a list of 2 or more points [x, y, z], each {}, m, no two in a row the same", kPlace.text()),
         true);
}

// Reads the largest distance of nodes along a line.
void read_spacing(Table& t, const std::vector<Vec3>& points, double& spacing) {
  constexpr double kMostPieces = 10000;
  t.number("spacing", spacing, kPositive, "m", true);
  double length = 0.0;
  for (std::size_t k = 0; k + 1 < points.size(); ++k)
    length += norm(geometry::vector(points[k + 1]) - geometry::vector(points[k]));
  if (spacing > 0.0 && length > kMostPieces * spacing)
    t.refuse("spacing", fmt::format("at least {:.3g} m, the length over {:.0f}", length / kMostPieces, kMostPieces));
}

void read_strip(Table& t, const Scene& scene, StripSpec& strip) {
  if (t.choice("joint", strip.joint, names_of(scene.joints), true) && scene.joints.at(strip.joint).is_random())
    t.refuse("joint", fmt::format("a family without missing_mortar or distributions, which strips do not have: "
                                  "[joints.{}] has them; give the strip a family of its own",
                                  strip.joint));
  read_line(t, strip.points);
  t.number("width", strip.width, kPositive, "m", true);
  t.number("thickness", strip.thickness, kPositive, "m", true);
  t.number("young_modulus", strip.young_modulus, kPositive, "Pa", true);
  t.number("strength", strip.strength, kPositive, "Pa");
  read_spacing(t, strip.points, strip.spacing);
  t.boolean("compression", strip.compression);
}

void read_connector(Table& c, FloorSpec& floor) {
  c.number("axial_stiffness", floor.axial_stiffness, kPositive, "N/m of a metre of edge", true);
  c.number("shear_stiffness", floor.connector_stiffness, kNotNegative, "N/m of a metre of edge", true);
  c.number("axial_strength", floor.axial_strength, kNotNegative, "N of a metre of edge");
  c.number("shear_strength", floor.connector_strength, kNotNegative, "N of a metre of edge");
  c.number("friction", floor.friction, between(0.0, 2.0), "(shear over the weight on the edge)");
  c.number("pull_out", floor.pull_out, kPositive, "m");
  c.boolean("bearing", floor.bearing);
}

void read_floor(Table& t, FloorSpec& floor) {
  t.numbers("corner", floor.corner, kPlace, "m", true);
  read_direction(t, "along", floor.along, "m, from the corner to the next", true);
  read_direction(t, "across", floor.across, "m, from the corner to the one before, square to along", true);
  constexpr double kSquare = 1e-6;  // cosine of the angle between both edges
  const geometry::Vector a = geometry::vector(floor.along), b = geometry::vector(floor.across);
  if (std::abs(dot(a, b)) > kSquare * norm(a) * norm(b)) t.refuse("across", "a vector square to along");
  t.number("spacing", floor.spacing, kPositive, "m", true);
  constexpr double kMostNodes = 200;  // most nodes of an edge: a floor with more costs as much as its walls
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
  t.within(
      "connector", "a table { axial_stiffness, shear_stiffness, ... }", [&](Table& c) { read_connector(c, floor); },
      true);
}

void read_beam(Table& t, BeamSpec& beam) {
  read_line(t, beam.points);
  read_spacing(t, beam.points, beam.spacing);
  read_direction(t, "up", beam.up, "across the line", false);
  if (const auto piece = piece_along(beam, beam.up))
    t.refuse("up", fmt::format("a vector across the line, which runs along it from point {} on", *piece + 1));
  t.number("area", beam.area, kPositive, "m2", true);
  t.numbers("inertia", beam.inertia, kNotNegative, "m4, of bending towards up and to the side");
  t.numbers("shear_area", beam.shear_area, kPositive, "m2");
  t.number("torsion", beam.torsion, kNotNegative, "m4");
  t.number("young_modulus", beam.young_modulus, kPositive, "Pa", true);
  t.number("poisson_ratio", beam.poisson_ratio, between(0.0, 0.5), "");
  t.number("density", beam.density, kDensity, "kg/m3", true);
  t.number("yield_force", beam.yield_force, kPositive, "N");
  t.numbers("yield_moment", beam.yield_moment, kPositive, "N m, towards up and to the side");
  t.boolean("compression", beam.compression);
  t.number("support_stiffness", beam.support_stiffness, kPositive, "N/m");
  t.number("friction", beam.friction, between(0.0, 2.0), "");
  t.choice("bedding", beam.bedding, {"none", "resting", "pinned", "built_in"});
  if ((beam.inertia[0] == 0.0) != (beam.inertia[1] == 0.0)) t.refuse("inertia", "both more than 0, or both 0: a cable");
  const double polar = beam.inertia[0] + beam.inertia[1];
  if (polar > 0.0 && !t.has("torsion")) beam.torsion = std::pow(beam.area, 4.0) / (40.0 * polar);  // Saint-Venant's
  if (polar > 0.0 && t.has("torsion") && beam.torsion == 0.0)
    t.refuse("torsion",
             "more than 0 for a beam that bends, which would buckle sideways under any moment; left out, "
             "it is area^4/(40 (inertia[0] + inertia[1]))");
  t.each("support", [&](Table& s) {
    BeamSupportSpec& support = beam.supports.emplace_back();
    support.source = {s.where()};
    s.numbers("point", support.point, kPlace, "m, on the line", true);
    s.text("block", support.block, "the name of a block; without it the block that has the point");
    s.choice("hold", support.hold, {"built_in", "pinned", "resting"});
  });
}

void read_dowel(Table& t, DowelSpec& dowel) {
  t.numbers("point", dowel.point, kPlace, "m, on the joint", true);
  read_direction(t, "direction", dowel.direction, "of the bar, through the joint", true);
  t.number("axial_stiffness", dowel.axial_stiffness, kPositive, "N/m", true);
  t.number("shear_stiffness", dowel.shear_stiffness, kPositive, "N/m", true);
  t.number("yield_force", dowel.yield_force, kPositive, "N, along the bar", true);
  t.number("yield_shear", dowel.yield_shear, kPositive, "N, across it", true);
}

// Reads the coefficients of horizontal pressure. Defaults are those of Rankine and Jaky.
void read_pressure(Table& t, FillSpec& fill) {
  const bool known = t.number("friction_angle", fill.friction_angle, between(0.0, 89.0), "deg", true);
  const double sine = std::sin(fill.friction_angle * std::numbers::pi / 180.0);
  fill.active = (1.0 - sine) / (1.0 + sine), fill.passive = (1.0 + sine) / (1.0 - sine), fill.at_rest = 1.0 - sine;
  t.number("active", fill.active, kNotNegative, "(horizontal over vertical stress)");
  t.number("at_rest", fill.at_rest, kNotNegative, "(horizontal over vertical stress)");
  t.number("passive", fill.passive, kNotNegative, "(horizontal over vertical stress)");
  if (known && (fill.active > fill.at_rest || fill.at_rest > fill.passive))
    t.refuse(t.has("at_rest")  ? "at_rest"
             : t.has("active") ? "active"
                               : "passive",
             fmt::format("active ({:.4g}) at most at_rest ({:.4g}), and that at most passive ({:.4g})", fill.active,
                         fill.at_rest, fill.passive));
}

void read_fill(Table& t, FillSpec& fill) {
  t.text("block", fill.block, "the name of a block, or of a group of them", true);
  read_direction(t, "towards", fill.towards, "outward, of the faces that are meant", false);
  t.numbers("surface", fill.surface, kPlace, "m, a point of its top", true);
  read_direction(t, "up", fill.up, "against gravity", false);
  t.number("unit_weight", fill.unit_weight, kPositive, "N/m3", true);
  t.number("surcharge", fill.surcharge, kNotNegative, "Pa");
  read_pressure(t, fill);
  t.number("stiffness", fill.stiffness, kPositive, "Pa/m", true);
  t.integer("divisions", fill.divisions, 1, 50);
}

// Reads the members of one kind, each with a unique name, by read(table, member).
template <class Spec, class Read>
void read_kind(Table& scene, const char* kind, std::vector<Spec>& members, const Read& read) {
  std::set<std::string> taken;
  scene.each(kind, [&](Table& t) {
    Spec& member = members.emplace_back();
    member.source = {t.where()};
    read_name(t, std::to_string(members.size()), taken, member.name);
    read(t, member);
  });
}

}  // namespace

std::optional<std::size_t> piece_along(const BeamSpec& beam, const Vec3& direction) {
  constexpr double kAcross = 0.05;  // sine of the angle between the direction and the line
  const geometry::Vector up = geometry::vector(direction);
  for (std::size_t k = 0; k + 1 < beam.points.size(); ++k) {
    const geometry::Vector way = geometry::vector(beam.points[k + 1]) - geometry::vector(beam.points[k]);
    if (norm(cross(up, way)) <= kAcross * norm(up) * norm(way)) return k;
  }
  return std::nullopt;
}

std::shared_ptr<const MemberSpecs> read_members(Table& t, const Scene& scene) {
  auto specs = std::make_shared<MemberSpecs>();
  read_kind(t, "tie", specs->ties, read_tie);
  read_kind(t, "spring", specs->springs, read_spring);
  read_kind(t, "strip", specs->strips, [&](Table& m, StripSpec& strip) { read_strip(m, scene, strip); });
  read_kind(t, "floor", specs->floors, read_floor);
  read_kind(t, "beam", specs->beams, read_beam);
  read_kind(t, "dowel", specs->dowels, [&](Table& m, DowelSpec& dowel) {
    read_dowel(m, dowel);
    if (std::ranges::any_of(specs->dowels, [&](const DowelSpec& d) { return differ_by("_shear", d.name, dowel.name); }))
      m.refuse("name", "not NAME_shear beside NAME: columns of both would have the same names");
  });
  read_kind(t, "fill", specs->fills, read_fill);
  for (const char* kind : {"tie", "spring", "strip", "floor", "beam", "dowel", "fill"}) {
    const toml::array* given = t.toml()[kind].as_array();
    if (!given || given->empty()) continue;
    if (scene.wall && scene.wall->half_thickness)
      t.refuse(kind, "none with wall.half_thickness = true: members have no half; make that false");
    return specs;
  }
  return nullptr;
}

}  // namespace quoin
