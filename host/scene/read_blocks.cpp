#include <algorithm>
#include <cmath>

#include "scene/actions/actions.h"
#include "scene/driven.h"
#include "scene/read_tables.h"

namespace quoin {

using namespace reader;

namespace {

const Range kLength = above_to(0, kPlace.upper), kTurn = between(-360, 360);

// Reads a list of lists of vertex numbers. `which`: their meaning and order, for messages.
std::vector<std::vector<int>> read_corners(Table& t, const std::string& key, size_t vertex_count, const char* which) {
  std::vector<std::vector<int>> faces;
  const std::string allowed =
      fmt::format("a list of lists of vertex numbers, integers from 0 and less than {} (the count of vertices), {}",
                  vertex_count, which);
  const toml::array* list = t.list(key, allowed);
  if (!list) return faces;
  for (const toml::node& element : *list) {
    const toml::array* f = element.as_array();
    if (!f) return t.wrong_type(key, allowed), std::vector<std::vector<int>>{};
    auto& face = faces.emplace_back();
    for (const toml::node& corner : *f) {
      const auto* v = corner.as_integer();
      if (!v) return t.wrong_type(key, allowed), std::vector<std::vector<int>>{};
      if (v->get() < 0 || v->get() >= static_cast<int64_t>(vertex_count))
        return t.refuse(key, allowed), std::vector<std::vector<int>>{};
      face.push_back(static_cast<int>(v->get()));
    }
  }
  return faces;
}

std::vector<std::array<int, 4>> read_tetrahedra(Table& t, const std::string& key, size_t vertex_count) {
  const char* const which = "four for each tetrahedron";
  std::vector<std::array<int, 4>> tetrahedra;
  for (const std::vector<int>& corners : read_corners(t, key, vertex_count, which)) {
    if (corners.size() != 4) return t.refuse(key, which), std::vector<std::array<int, 4>>{};
    std::copy(corners.begin(), corners.end(), tetrahedra.emplace_back().begin());
  }
  return tetrahedra;
}

void read_kind(Table& t, const Scene& scene, std::string& material, bool& rigid, double& zone_edge) {
  t.choice("material", material, names_of(scene.materials), true);
  t.boolean("rigid", rigid);
  if (t.number("zone_edge", zone_edge, kLength, "m") && rigid) t.refuse("zone_edge", "only with rigid = false");
}

// Reads `fixed`: true, false, or names of blocks of a mesh.
void read_fixed(Table& t, BlockSpec& b) {
  const std::string allowed = "true or false, or of a mesh a list of names of blocks";
  const toml::node* node = t.find("fixed", allowed, false);
  if (node && node->is_boolean())
    b.fixed = *node->value<bool>();
  else if (node && !t.has("mesh"))
    t.wrong_type("fixed", allowed);
  else if (node)
    t.texts("fixed", b.fixed_names, allowed);
}

BlockSpec read_block(Table& t, const Scene& scene) {
  BlockSpec b;
  b.source = {t.where()};
  t.text("name", b.name, "text");
  t.text("unit", b.unit, "the name of the masonry unit that the block is part of");
  read_kind(t, scene, b.material, b.rigid, b.zone_edge);
  read_fixed(t, b);
  if (t.numbers("divisions", b.divisions, between(1, 200), "hexahedra of 5 zones along the three edges") && b.rigid) {
    t.refuse("divisions", "only with rigid = false");
  }
  if (t.has("divisions") && b.zone_edge > 0.0) t.refuse("divisions", "not beside zone_edge; remove one of the two");
  if (!b.rigid && b.zone_edge == 0.0 && b.divisions[0] == 0 && !t.has("tetrahedra")) {
    t.context().fault(t.where() + ": a deformable block needs zone_edge (m), divisions or tetrahedra");
  }
  t.numbers("position", b.position, kPlace, "m");
  t.numbers("rotation", b.rotation, kTurn, "deg, about its own direction");
  int shapes = 0;
  shapes += t.within("box", "{ lower = [x, y, z], size = [x, y, z] }, m", [&](Table& box) {
    b.box_lower = Vec3{0, 0, 0};
    b.box_size = Vec3{1, 1, 1};
    box.numbers("lower", *b.box_lower, kPlace, "m");
    box.numbers("size", *b.box_size, kLength, "m", true);
  });
  t.points("vertices", b.vertices, kPlace, fmt::format("a list of [x, y, z], each {}, m", kPlace.text()));
  b.faces = read_corners(t, "faces", b.vertices.size(), "counter-clockwise seen from outside");
  b.tetrahedra = read_tetrahedra(t, "tetrahedra", b.vertices.size());
  if (t.has("tetrahedra")) {
    if (b.rigid) t.refuse("tetrahedra", "only with rigid = false");
    for (const char* other : {"faces", "zone_edge", "divisions"}) {
      if (t.has(other)) t.refuse(other, "not beside tetrahedra, which are the zones; remove it");
    }
  }
  shapes += !b.vertices.empty();
  if (t.text("mesh", b.mesh, "a file .off, .obj, .stl or .json (COMPAS)")) ++shapes;
  if (t.number("scale", b.scale, kLength, "(mesh file's unit in m)") && !t.has("mesh"))
    t.refuse("scale", "only with mesh; remove it");
  if (shapes != 1)
    t.context().fault(t.where() +
                      ": give the shape by one of box, vertices (with or without faces or tetrahedra), mesh");
  return b;
}

constexpr double kBed = 1e-5;  // of the height of a course; distance from a bed joint that is rounding

// Refuses an opening that takes nothing from the wall, more than there is, or part of a course. Keys that are missing
// are faults already.
void check_opening(Table& o, DryWallSpec::Opening& opening, const DryWallSpec& wall) {
  const double rounding = 1.0 + 1e-9;
  const auto check = [&](const char* lower, double low, const char* upper, double up, double whole, const char* what) {
    if (!o.has(lower) || !o.has(upper) || !(whole > 0.0)) return;
    if (low >= up)
      o.refuse(upper, fmt::format("more than {} ({:g} m)", lower, low));
    else if (up > whole * rounding)
      o.refuse(upper, fmt::format("at most the {} of the wall, {:g} m", what, whole));
  };
  check("from", opening.from, "to", opening.to, wall.units_per_course * wall.unit[0], "length");
  check("sill", opening.sill, "head", opening.head, wall.courses * wall.unit[1], "height");
  const double height = wall.unit[1];
  for (const auto& [key, place] : {std::pair{"sill", &opening.sill}, std::pair{"head", &opening.head}}) {
    if (!o.has(key) || !(height > 0.0)) continue;
    const double below = std::floor(*place / height) * height, bed = std::round(*place / height) * height;
    if (std::abs(*place - bed) > kBed * height)
      o.refuse(key,
               fmt::format("a bed joint, {:.9g} or {:.9g} m: courses are {:.9g} m high, and only whole ones end at "
                           "an opening",
                           below, below + height, height));
    *place = bed;
  }
  if (o.has("head") && opening.bearing > 0.0 && opening.head > (wall.courses - 0.5) * height)
    o.refuse("bearing", "0 where the head is the top of the wall: there is no course for a lintel");
}

// Compares the last opening and its lintel with those before. No two may take the same part of the wall, and a lintel
// may not leave it.
void check_lintels(Table& o, const DryWallSpec& wall) {
  struct Place {
    double from, to, low, high;
  };
  const double length = wall.units_per_course * wall.unit[0], height = wall.unit[1], tiny = 1e-9 * length;
  const auto overlap = [tiny](const Place& a, const Place& b) {
    return std::min(a.to, b.to) - std::max(a.from, b.from) > tiny &&
           std::min(a.high, b.high) - std::max(a.low, b.low) > tiny;
  };
  const auto hole = [](const DryWallSpec::Opening& x) { return Place{x.from, x.to, x.sill, x.head}; };
  const auto lintel = [&](const DryWallSpec::Opening& x) {
    return Place{x.from - x.bearing, x.to + x.bearing, x.head, x.bearing > 0.0 ? x.head + height : x.head};
  };
  const DryWallSpec::Opening& last = wall.openings.back();
  const Place of_last = lintel(last);
  if (last.bearing > 0.0 &&
      ((last.from > tiny && of_last.from < -tiny) || (last.to < length - tiny && of_last.to > length + tiny)))
    return o.refuse("bearing", fmt::format("at most {:g} m, up to the end of the wall, or an opening up to there",
                                           std::min(last.from, length - last.to)));
  for (std::size_t i = 0; i + 1 < wall.openings.size(); ++i) {
    const DryWallSpec::Opening& other = wall.openings[i];
    if (overlap(of_last, hole(other)) || overlap(of_last, lintel(other)))
      o.refuse("bearing", fmt::format("a lintel beside opening {} and its lintel", i + 1));
    else if (overlap(hole(last), lintel(other)))
      o.refuse("from", fmt::format("an opening beside the lintel of opening {}, which goes from {:g} to {:g} m", i + 1,
                                   lintel(other).from, lintel(other).to));
  }
}

DryWallSpec read_dry_wall(Table& t, const Scene& scene) {
  DryWallSpec w;
  w.source = {t.where()};
  t.text("name", w.name, "text");
  read_kind(t, scene, w.material, w.rigid, w.zone_edge);
  t.choice("bond", w.bond, {"running", "third", "stack"});
  if (t.choice("first_course", w.first_course, {"whole", "half"}) && w.bond == "third")
    t.refuse("first_course", "only with bond = \"running\" or \"stack\"");
  t.integer("courses", w.courses, 1, 10000, true);
  if (t.number("units_per_course", w.units_per_course, between(0.5, 10000), "units, in halves", true) &&
      2 * w.units_per_course != std::floor(2 * w.units_per_course)) {
    t.refuse("units_per_course", "a multiple of 0.5");
  }
  t.numbers("unit", w.unit, kExtent, "m (length, height, thickness)", true);
  if (t.numbers("zones", w.zones, between(1, 64), "hexahedra of 5 zones per half unit along x, y, z")) {
    if (w.rigid) t.refuse("zones", "only with rigid = false");
    if (w.zone_edge > 0.0) t.refuse("zones", "not beside zone_edge; remove one of the two");
  } else if (!w.rigid && w.zone_edge == 0.0 && !t.has("zones") && !t.has("zone_edge")) {
    t.context().fault(t.where() + ": deformable units need zones or zone_edge (m)");
  }
  t.boolean("mid_unit_joints", w.mid_unit_joints);
  t.numbers("origin", w.origin, kPlace, "m");
  t.number("direction", w.direction, kTurn, "deg in plan, from x towards z");
  t.numbers("trim_start", w.trim_start, kNotNegative, "m, of even and of odd courses");
  t.numbers("trim_end", w.trim_end, kNotNegative, "m, of even and of odd courses");
  constexpr double kRounding = 1e-9;
  const double length = w.units_per_course * w.unit[0];
  for (std::size_t parity = 0; length > 0.0 && parity < 2; ++parity) {
    if (w.trim_start[parity] + w.trim_end[parity] >= (1.0 - kRounding) * length)
      t.refuse(w.trim_end[parity] > 0.0 ? "trim_end" : "trim_start",
               fmt::format("together less than the length of the wall, {:g} m", length));
  }
  t.each("opening", [&](Table& o) {
    DryWallSpec::Opening& opening = w.openings.emplace_back();
    o.number("from", opening.from, kNotNegative, "m along the wall", true);
    o.number("to", opening.to, kPositive, "m along the wall", true);
    o.number("sill", opening.sill, kNotNegative, "m above the foot", true);
    o.number("head", opening.head, kPositive, "m above the foot", true);
    o.number("bearing", opening.bearing, kNotNegative, "m of lintel either side (0: no lintel)");
    check_opening(o, opening, w);
    check_lintels(o, w);
  });
  return w;
}

ArchSpec read_arch(Table& t, const Scene& scene) {
  ArchSpec a;
  a.source = {t.where()};
  t.text("name", a.name, "text");
  read_kind(t, scene, a.material, a.rigid, a.zone_edge);
  t.numbers("centre", a.centre, kPlace, "m");
  t.number("radius", a.radius, kLength, "m, mean", true);
  if (t.number("thickness", a.thickness, kLength, "m", true) && a.thickness >= 2 * a.radius) {
    t.refuse("thickness", "less than twice the radius");
  }
  t.number("depth", a.depth, kLength, "m", true);
  t.integer("voussoirs", a.voussoirs, 2, 10000, true);
  t.numbers("angles", a.angles, kTurn, "deg from x");
  t.boolean("abutments", a.abutments);
  constexpr double kCircle = 360.0;
  const double span = std::abs(a.angles[1] - a.angles[0]);
  if (span == 0.0 || span > kCircle || (a.abutments && span * (1.0 + 2.0 / a.voussoirs) > kCircle))
    t.refuse("angles", "two different ones, up to 360 degrees apart with the abutments");
  return a;
}

JointRule read_rule(Table& t, const Scene& scene) {
  JointRule r;
  std::vector<std::string> families = names_of(scene.joints), ends;
  families.insert(families.begin(), "none");
  t.choice("family", r.family, families, true);
  t.choice("normal", r.normal, {"vertical", "horizontal", "any"});
  t.boolean("inside_units", r.inside_units);
  const std::string allowed = "two beginnings of block names";
  if (t.texts("between", ends, allowed) && ends.size() == 2)
    r.between = {ends[0], ends[1]};
  else if (!ends.empty())
    t.wrong_type("between", allowed);
  return r;
}

void read_drive(Table& v, Stage& stage) {
  BodyControl c;
  v.text("block", c.body, "the name of a block", true);
  v.refuse_second("block", c, stage.controls);
  v.numbers("omega", c.omega, kAny, "rad/s");
  bool held = true;
  v.boolean("rotation_held", held);
  if (!held && v.has("omega"))
    v.refuse("omega", "none with rotation_held = false, where the block turns by itself; remove one of them");
  c.may_turn = !held;
  v.velocity(c, true);
  stage.controls.push_back(c);
}

}  // namespace

Stage read_block_stage(Table t, const Scene& scene, const Stage* previous, const std::string& folder) {
  Stage s;
  s.source = {t.where()};
  s.name = "stage";
  read_stage_basics(t, s, previous);
  t.each("velocity", [&](Table& v) { read_drive(v, s); });
  read_actions(t, s, folder, {});
  s.kind = "custom";
  if (t.choice("kind", s.kind, {"rest", "cycles", "custom"}) && !t.has("name")) s.name = s.kind;
  if (s.kind == "cycles") {
    read_cycles(t, s, "cycle_velocity");
    read_cycled_body(t, "block", nullptr, s);
    if (s.ground || s.collapse || s.moving_load)
      t.refuse("kind",
               "cycles without ground_motion, collapse and moving_load; give them a stage of "
               "their own");
  } else {
    read_monitor(t, s);
    if (s.displacement && s.monitor.empty() && scene.output.monitor.empty() && !t.has("monitor"))
      t.refuse("displacement", "only with a block to measure; give monitor here, or output.monitor");
  }
  if (s.kind == "rest") {
    read_rest(t, s);
    if (s.ground || s.displacement || moves_blocks(s))
      t.refuse(
          "kind",
          "rest with weight and constant loads alone: without ground_motion, collapse, moving_load, displacement and "
          "velocities, which a stage after it takes");
  }
  read_stage_solver(t, s, scene);
  require_end(t, s);
  read_law_swaps(t, scene, s);
  t.finish();
  return s;
}

BlocksSpec read_blocks(Table& t, const Scene& scene, const std::string& folder) {
  BlocksSpec spec;
  t.each("block", [&](Table& b) {
    BlockSpec& block = spec.blocks.emplace_back(read_block(b, scene));
    if (!block.mesh.empty() && !block.mesh.starts_with('/')) block.mesh = folder + block.mesh;
    if (!block.mesh.empty()) t.context().inputs.push_back(block.mesh);
  });
  t.each("dry_wall", [&](Table& w) { spec.walls.push_back(read_dry_wall(w, scene)); });
  t.each("arch", [&](Table& a) { spec.arches.push_back(read_arch(a, scene)); });
  t.each("joint_rule", [&](Table& r) { spec.rules.push_back(read_rule(r, scene)); });
  if (!scene.joints.empty()) spec.default_joint = scene.joints.begin()->first;
  std::vector<std::string> families = names_of(scene.joints);
  families.insert(families.begin(), "none");
  t.choice("default_joint", spec.default_joint, families, scene.joints.size() > 1 && spec.rules.empty());
  return spec;
}

void read_contact(Table& c, const SolverSettings& solver, BlocksSpec::Contact* contact) {
  c.number("skin", contact->skin, between(1e-9, 1e3), "m");
  if (c.number("joint_tolerance", contact->joint_tolerance, between(1e-9, 1e3), "m") && contact->skin > 0.0 &&
      contact->joint_tolerance > contact->skin / 4)
    c.refuse("joint_tolerance", fmt::format("at most {:g} m, a quarter of contact.skin: faces further apart get no "
                                            "contact points; give a larger skin too",
                                            contact->skin / 4));
  c.number("point_spacing", contact->point_spacing, kPositive, "m");
  c.number("small_displacement", contact->small_displacement, between(0, 0.1), "of the least extent of a block");
  if (contact->small_displacement == 0.0 && solver.large_motion == LargeMotion::never)
    c.refuse("small_displacement", "more than 0 with solver.large_motion = \"never\"; 0 means \"always\"");
  if (contact->small_displacement == 0.0 && solver.kernels == Kernels::lattice)
    c.refuse("small_displacement", "more than 0 with solver.kernels = \"lattice\"; 0 is large motion from the start");
}

}  // namespace quoin
