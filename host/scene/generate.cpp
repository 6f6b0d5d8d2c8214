#include "scene/generate.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "base/error.h"
#include "scene/masonry_place.h"
#include "scene/openings.h"

namespace quoin {

namespace {

constexpr int kPlusX = 1, kPlusY = 3;

// The wall as a grid of half units: the unit in each cell, -1 in openings.
class WallGrid {
 public:
  explicit WallGrid(const WallSpec& wall)
      : wall_(wall),
        columns_(static_cast<int>(std::lround(2 * wall.units_per_course))),
        unit_(static_cast<size_t>(columns_) * static_cast<size_t>(wall.courses), -1),
        block_(unit_) {
    number_units();
  }

  int columns() const { return columns_; }
  int unit(int course, int column) const { return unit_[at(course, column)]; }
  int& block(int course, int column) { return block_[at(course, column)]; }
  bool solid(int course, int column) const { return unit(course, column) >= 0 && !missing(course, column); }
  // Change of a unit by the scene; null: none.
  const WallSpec::Changed* changed(int course, int column) const {
    for (const WallSpec::Changed& c : wall_.changed)
      if (c.course == course && unit(c.course, c.half_unit) == unit(course, column)) return &c;
    return nullptr;
  }
  const WallSpec::Opening* lintel(int course, int column) const { return lintel_at(wall_.openings, course, column); }

 private:
  bool missing(int course, int column) const {
    const WallSpec::Changed* c = changed(course, column);
    return c && c->material.empty();
  }
  size_t at(int course, int column) const {
    return static_cast<size_t>(course) * static_cast<size_t>(columns_) + static_cast<size_t>(column);
  }

  // Numbers the units. A unit cut by an opening or a lintel keeps its half that is left.
  void number_units() {
    int next = 0;
    for (int course = 0; course < wall_.courses; ++course) {
      for (int column = 0; column < columns_; ++column) {
        if (in_opening(wall_.openings, course, column)) continue;
        unit_[at(course, column)] = same_unit(wall_, course, column - 1, column) ? unit(course, column - 1) : next++;
      }
    }
  }

  const WallSpec& wall_;
  int columns_;
  std::vector<int> unit_, block_;
};

// Removes joints that have no mortar in the random sample of the scene.
void leave_mortar_out(Assembly* assembly) {
  const auto placed = [&](int block) {
    const Brick& brick = assembly->bricks[static_cast<std::size_t>(block)];
    return PlacedBlock{brick.unit, brick.course};
  };
  std::erase_if(assembly->joints, [&](const Joint& j) {
    const JointFamily& family = assembly->families[static_cast<std::size_t>(j.family)];
    const bool lacks = lacks_mortar(family, j.block_a, placed(j.block_a), j.block_b, placed(j.block_b));
    if (lacks) assembly->apart.push_back({j.block_a, j.block_b});
    return lacks;
  });
}

}  // namespace

std::vector<std::string> WallSpec::bottom_beams() const {
  if (!bottom_beam) return {};
  if (bottom_beam_cuts.empty()) return {"bottom_beam"};
  std::vector<std::string> names;
  for (size_t part = 1; part <= bottom_beam_cuts.size() + 1; ++part)
    names.push_back("bottom_beam_" + std::to_string(part));
  return names;
}

bool same_unit(const WallSpec& wall, int course, int half_unit, int other) {
  const auto [first, last] = std::minmax(half_unit, other);
  const bool starts_half = (wall.first_course == "half") != (wall.bond == "running" && course % 2 == 1);
  for (int column = first; column <= last; ++column) {
    if (column < 0 || in_opening(wall.openings, course, column)) return false;
    if (column == first) continue;
    const auto* const of = lintel_at(wall.openings, course, column);
    const bool second_half = of ? column > of->lintel_first()
                                : (column % 2 == 1) != starts_half && !lintel_at(wall.openings, course, column - 1);
    if (!second_half) return false;
  }
  return true;
}

double bed_area(const WallSpec& wall) { return wall.units_per_course * wall.unit[0] * wall.unit[2]; }

double bed_area(const BuildingSpec& building) {
  double area = static_cast<double>(building.corners.size()) * building.thickness * building.thickness;
  for (const BuildingSpec::Wall& wall : building.walls) area += wall.half_units * wall.half_unit * building.thickness;
  return area;
}

double bed_area(const Scene& scene) {
  if (scene.blocks) return 0.0;
  return scene.wall ? bed_area(*scene.wall) : scene.building ? bed_area(*scene.building) : 0.0;
}

namespace {

// Modelled thickness, m.
double thickness_of(const WallSpec& wall) { return wall.half_thickness ? wall.unit[2] / 2 : wall.unit[2]; }

// Adds the units. Over the whole wall the hexahedra form one grid, in which patterns of 5 tetrahedra alternate like the
// fields of a chessboard. So their diagonals coincide at every joint, for odd numbers of layers too.
void add_units(const WallSpec& wall, const std::map<std::string, BlockMaterial>& materials, WallGrid& grid,
               Assembly& assembly) {
  const double half = wall.unit[0] / 2, height = wall.unit[1], thickness = thickness_of(wall);
  const std::array<int, 3> zones{wall.zones[0], wall.zones[1], wall.half_thickness ? wall.zones[2] / 2 : wall.zones[2]};
  const int unit_material = index_of(materials, wall.unit_material);
  for (int course = 0; course < wall.courses; ++course) {
    for (int column = 0; column < grid.columns(); ++column) {
      if (!grid.solid(course, column)) continue;
      const bool same_unit = column > 0 && grid.unit(course, column - 1) == grid.unit(course, column);
      const auto* const lintel = grid.lintel(course, column);
      if (same_unit && (lintel || !wall.mid_unit_joints)) {  // lengthen the block of the unit or lintel
        const int block = grid.block(course, column - 1);
        grid.block(course, column) = block;
        Brick& brick = assembly.bricks[static_cast<size_t>(block)];
        brick.size[0] += half;
        if (!wall.rigid_units) brick.zones[0] += zones[0];
        continue;
      }
      grid.block(course, column) = static_cast<int>(assembly.bricks.size());
      Brick brick;
      brick.origin = {column * half, course * height, 0.0};
      brick.size = {half, height, thickness};
      if (wall.rigid_units) {
        brick.rigid = true;
        brick.body = course == 0 ? "bottom_course" : course + 1 == wall.courses ? "top_course" : "";
      } else {
        brick.zones = zones;
      }
      brick.parity = (column * zones[0] + course * zones[1]) % 2;
      brick.material =
          lintel && !lintel->lintel_material.empty() ? index_of(materials, lintel->lintel_material) : unit_material;
      if (const WallSpec::Changed* c = grid.changed(course, column)) brick.material = index_of(materials, c->material);
      brick.unit = grid.unit(course, column);
      brick.course = course;
      assembly.bricks.push_back(brick);
    }
  }
}

// Adds the beam over columns `first` to `end` (exclusive). Returns its block.
int add_beam(const WallSpec& wall, const std::string& name, int first, int end, double y, Assembly& assembly) {
  const double half = wall.unit[0] / 2;
  Brick beam;
  beam.origin = {first * half, y, 0.0};
  beam.size = {(end - first) * half, wall.beam_height, thickness_of(wall)};
  beam.material = static_cast<int>(assembly.materials.size()) - 1;
  beam.rigid = beam.beam = true;
  beam.body = name;
  assembly.bricks.push_back(beam);
  return static_cast<int>(assembly.bricks.size()) - 1;
}

struct Beams {
  std::vector<int> bottom;  // block by column; -1: none
  int top = -1;
};

Beams add_beams(const WallSpec& wall, const WallGrid& grid, Assembly& assembly) {
  if (wall.bottom_beam || wall.top_beam) assembly.materials.push_back({"beam", 0.0, 0.0, wall.beam_density});
  Beams beams{std::vector<int>(static_cast<size_t>(grid.columns()), -1)};
  std::vector<int> ends = wall.bottom_beam_cuts;
  ends.push_back(grid.columns());
  int first = 0;
  for (size_t part = 0; const std::string& name : wall.bottom_beams()) {
    const int end = ends[part++];
    std::fill(beams.bottom.begin() + first, beams.bottom.begin() + end,
              add_beam(wall, name, first, end, -wall.beam_height, assembly));
    if (first > 0)
      assembly.apart.push_back(
          {beams.bottom[static_cast<size_t>(first) - 1], beams.bottom[static_cast<size_t>(first)]});
    first = end;
  }
  if (!wall.top_beam) return beams;
  beams.top = add_beam(wall, "top_beam", 0, grid.columns(), wall.courses * wall.unit[1], assembly);
  assembly.bricks[static_cast<size_t>(beams.top)].load_height = wall.load_height;
  return beams;
}

// Adds joints within each course (head joints, and unit joints in the middle of a unit), then beds from the bottom up.
void add_joints(const WallSpec& wall, const std::map<std::string, JointFamily>& joints, const Beams& beams,
                WallGrid& grid, Assembly& assembly) {
  for (int course = 0; course < wall.courses; ++course) {
    for (int column = 0; column + 1 < grid.columns(); ++column) {
      const int a = grid.block(course, column), b = grid.block(course, column + 1);
      if (a < 0 || b < 0 || a == b) continue;
      const bool mid_unit = grid.unit(course, column) == grid.unit(course, column + 1);
      assembly.joints.push_back({a, b, kPlusX, index_of(joints, mid_unit ? wall.unit_joint : wall.head_joint)});
    }
  }
  for (int below = -1; below < wall.courses; ++below) {
    std::set<std::pair<int, int>> done;  // a whole unit lies on two others: each pair once
    for (int column = 0; column < grid.columns(); ++column) {
      const int a = below < 0 ? beams.bottom[static_cast<size_t>(column)] : grid.block(below, column);
      const int b = below + 1 == wall.courses ? beams.top : grid.block(below + 1, column);
      if (a < 0 || b < 0 || !done.insert({a, b}).second) continue;
      const bool at_beam = below < 0 || below + 1 == wall.courses;
      assembly.joints.push_back({a, b, kPlusY, index_of(joints, at_beam ? wall.beam_joint : wall.bed_joint)});
    }
  }
}

}  // namespace

Assembly generate_wall(const WallSpec& wall, const std::map<std::string, BlockMaterial>& materials,
                       const std::map<std::string, JointFamily>& joints) {
  auto assembly = with_materials<Assembly>(materials, joints);
  assembly.symmetry_factor = wall.half_thickness ? 2.0 : 1.0;
  assembly.symmetry_plane_z0 = wall.half_thickness;
  WallGrid grid(wall);
  add_units(wall, materials, grid, assembly);
  const Beams beams = add_beams(wall, grid, assembly);
  add_joints(wall, joints, beams, grid, assembly);
  return assembly;
}

Assembly assemble(const Scene& scene) {
  if (!scene.building && !scene.wall)
    throw Error(Exit::bad_input, scene.file + ": the scene has no [wall]: nothing to build");
  Assembly assembly = scene.building ? generate_building(*scene.building, scene.materials, scene.joints)
                                     : generate_wall(*scene.wall, scene.materials, scene.joints);
  leave_mortar_out(&assembly);
  return assembly;
}

bool stands_on_ground(const Scene& scene) {
  return scene.had_ground || std::ranges::any_of(scene.stages, [](const Stage& s) {
           return s.has_no_control || !beyond_lattice(s).empty();
         });
}

bool is_ground(const Scene& scene, const std::string& body) {
  if (scene.wall && !scene.wall->bottom_beam) return body == "bottom_course";
  return (scene.wall || scene.building) && body.starts_with("bottom_beam");
}

void stand_on_ground(const Scene& scene, Assembly& bricks) {
  if (!stands_on_ground(scene)) return;
  for (Brick& brick : bricks.bricks) brick.fixed = is_ground(scene, brick.body);
}

}  // namespace quoin
