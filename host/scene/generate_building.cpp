#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "base/error.h"
#include "scene/generate.h"
#include "scene/openings.h"

namespace quoin {

namespace {

constexpr int kPlusX = 1, kPlusY = 3, kPlusZ = 5;

// Coordinate in whole micrometres, as a key of sets and maps.
long micrometres(double x) { return std::lround(x * 1e6); }

using Wall = BuildingSpec::Wall;
using Corner = BuildingSpec::Corner;

struct Builder {
  const BuildingSpec& spec;
  const std::map<std::string, BlockMaterial>& materials;
  Assembly& assembly;
  int material, head, unit_family, bed, beam_family;
  int next_unit = 0;
  // Blocks by course, of each wall's columns and of the corners; -1 in openings.
  std::vector<std::vector<std::vector<int>>> column_block;  // [wall][course][column]
  std::vector<std::vector<int>> corner_block;               // [corner][course]

  double length(const Wall& wall) const { return wall.half_units * wall.half_unit; }

  // End of the wall at the corner: -1 its start, +1 its end, 0 neither.
  int end_at(const Wall& wall, const Corner& corner) const {
    const size_t along = wall.axis == 0 ? 0 : 1, across = 1 - along;
    if (micrometres(wall.start[across]) != micrometres(corner.at[across])) return 0;
    if (micrometres(corner.at[along] + spec.thickness) == micrometres(wall.start[along])) return -1;
    if (micrometres(wall.start[along] + length(wall)) == micrometres(corner.at[along])) return +1;
    return 0;
  }

  // Index of the wall whose unit includes the corner in this course.
  int owner(const Corner& corner, int course) const { return course % 2 == 0 ? corner.first : corner.second; }

  // Whether a corner starts a wall, and whether the units of a course include the corners at its ends.
  struct Ends {
    bool corner_at_start = false, owns_start = false, owns_end = false;
  };
  Ends ends_of(int wall, int course) const {
    Ends ends;
    for (const Corner& corner : spec.corners) {
      if (corner.first != wall && corner.second != wall) continue;
      const bool owns = owner(corner, course) == wall;
      if (end_at(spec.walls[static_cast<size_t>(wall)], corner) < 0)
        ends.corner_at_start = true, ends.owns_start = owns;
      else
        ends.owns_end = owns;
    }
    return ends;
  }

  int add(const Vec3& origin, const Vec3& size, const std::array<int, 3>& zones, int unit, int course) {
    Brick brick;
    brick.origin = origin;
    brick.size = size;
    brick.zones = zones;
    brick.material = material;
    brick.unit = unit;
    brick.course = course;
    assembly.bricks.push_back(brick);
    return static_cast<int>(assembly.bricks.size()) - 1;
  }

  void add_walls() {
    for (size_t w = 0; w < spec.walls.size(); ++w) {
      const Wall& wall = spec.walls[w];
      auto& blocks = column_block.emplace_back();
      const bool x = wall.axis == 0;
      for (int course = 0; course < spec.courses; ++course) {
        auto& row = blocks.emplace_back(static_cast<size_t>(wall.half_units), -1);
        // The unit at an end of this wall consists of the corner and the half unit beside it.
        const Ends ends = ends_of(static_cast<int>(w), course);
        const bool starts_half =
            ends.corner_at_start ? ends.owns_start : (wall.first_course == "half") != (course % 2 == 1);
        for (int column = 0; column < wall.half_units; ++column) {
          if (in_opening(wall.openings, course, column)) continue;
          const int before = column > 0 ? row[static_cast<size_t>(column) - 1] : -1;
          const WallSpec::Opening* const lintel = lintel_at(wall.openings, course, column);
          if (lintel && column > lintel->lintel_first()) {
            row[static_cast<size_t>(column)] = before;
            continue;
          }
          const bool in_corner = ends.owns_end && column + 1 == wall.half_units;
          const bool second_half = column > 0 && (column % 2 == 1) != starts_half && !in_corner && !lintel &&
                                   !lintel_at(wall.openings, course, column - 1);
          const int unit = second_half && before >= 0 ? assembly.bricks[static_cast<size_t>(before)].unit : next_unit++;
          const int count = lintel ? lintel->lintel_length() : 1;
          const double at = column * wall.half_unit;
          const double height = spec.course_height;
          row[static_cast<size_t>(column)] =
              x ? add({wall.start[0] + at, course * height, wall.start[1]},
                      {count * wall.half_unit, height, spec.thickness},
                      {count * spec.zones[0], spec.zones[1], spec.zones[2]}, unit, course)
                : add({wall.start[0], course * height, wall.start[1] + at},
                      {spec.thickness, height, count * wall.half_unit},
                      {spec.zones[2], spec.zones[1], count * spec.zones[0]}, unit, course);
          if (lintel && !lintel->lintel_material.empty())
            assembly.bricks.back().material = index_of(materials, lintel->lintel_material);
        }
      }
    }
    for (const Corner& corner : spec.corners) {
      auto& blocks = corner_block.emplace_back();
      for (int course = 0; course < spec.courses; ++course) {
        const int neighbour = beside(corner, owner(corner, course), course);
        const bool in_unit = neighbour >= 0 && !lintel_beside(corner, owner(corner, course), course);
        const int unit = in_unit ? assembly.bricks[static_cast<size_t>(neighbour)].unit : next_unit++;
        blocks.push_back(add({corner.at[0], course * spec.course_height, corner.at[1]},
                             {spec.thickness, spec.course_height, spec.thickness},
                             {spec.zones[2], spec.zones[1], spec.zones[2]}, unit, course));
      }
    }
  }

  // The block of the wall next to the corner.
  int beside(const Corner& corner, int wall, int course) const {
    const Wall& w = spec.walls[static_cast<size_t>(wall)];
    const auto& row = column_block[static_cast<size_t>(wall)][static_cast<size_t>(course)];
    return end_at(w, corner) < 0 ? row.front() : row.back();
  }

  bool lintel_beside(const Corner& corner, int wall, int course) const {
    const Wall& w = spec.walls[static_cast<size_t>(wall)];
    return lintel_at(w.openings, course, end_at(w, corner) < 0 ? 0 : w.half_units - 1) != nullptr;
  }

  // Sets the patterns of 5 tetrahedra. Over the whole building the hexahedra form one grid. Patterns alternate in it
  // like the fields of a chessboard, so that diagonals coincide at every joint. A hexahedron's place is the rank of its
  // coordinates among all.
  void colour() {
    std::array<std::set<long>, 3> planes;
    for (const Brick& b : assembly.bricks) {
      for (size_t c = 0; c < 3; ++c) {
        for (int i = 0; i <= b.zones[c]; ++i) planes[c].insert(micrometres(b.origin[c] + b.size[c] * i / b.zones[c]));
      }
    }
    for (Brick& b : assembly.bricks) {
      long rank = 0;
      for (size_t c = 0; c < 3; ++c) {
        const auto at = planes[c].lower_bound(micrometres(b.origin[c]) - 1);
        rank += std::distance(planes[c].begin(), at);
      }
      b.parity = static_cast<int>(rank % 2);
    }
  }

  void add_floors() {
    for (const BuildingSpec::Floor& floor : spec.floors) {
      const auto names = floor.bodies();
      for (size_t i = 0; i < names.size(); ++i) {
        const int block = column_block[static_cast<size_t>(floor.wall)][static_cast<size_t>(floor.course)]
                                      [static_cast<size_t>(floor.half_units[i])];
        if (block < 0)
          throw Error(Exit::bad_input,
                      fmt::format("{}: half unit {} of course {} is in an opening: no beam can lie there",
                                  floor.source.text, floor.half_units[i], floor.course));
        Brick& brick = assembly.bricks[static_cast<size_t>(block)];
        if (!brick.body.empty())
          throw Error(Exit::bad_input, fmt::format("{}: half unit {} of course {} carries a beam already",
                                                   floor.source.text, floor.half_units[i], floor.course));
        brick.body = names[i];
        if (!floor.rigid) continue;
        brick.rigid = brick.beam = true;
        brick.unit = next_unit++;  // a unit of its own: it lies in mortar beside the rest of the masonry unit
      }
    }
  }

  void add_beam() {
    Vec3 low{HUGE_VAL, 0, HUGE_VAL}, high{-HUGE_VAL, 0, -HUGE_VAL};
    for (const Brick& b : assembly.bricks) {
      for (size_t c : {size_t{0}, size_t{2}}) {
        low[c] = std::min(low[c], b.origin[c]);
        high[c] = std::max(high[c], b.origin[c] + b.size[c]);
      }
    }
    Brick beam;
    beam.origin = {low[0], -spec.beam_height, low[2]};
    beam.size = {high[0] - low[0], spec.beam_height, high[2] - low[2]};
    beam.material = static_cast<int>(assembly.materials.size());
    beam.rigid = beam.beam = true;
    beam.body = "bottom_beam";
    assembly.materials.push_back({"beam", 0.0, 0.0, spec.beam_density});
    assembly.bricks.push_back(beam);
  }

  void join(int a, int b, int face) {
    if (a < 0 || b < 0 || a == b) return;
    const bool same = assembly.bricks[static_cast<size_t>(a)].unit == assembly.bricks[static_cast<size_t>(b)].unit;
    assembly.joints.push_back({a, b, face, same ? unit_family : head});
  }

  void add_joints() {
    const int beam = static_cast<int>(assembly.bricks.size()) - 1;
    for (int course = 0; course < spec.courses; ++course) {
      const size_t c = static_cast<size_t>(course);
      for (size_t w = 0; w < spec.walls.size(); ++w) {
        const auto& row = column_block[w][c];
        for (size_t i = 0; i + 1 < row.size(); ++i) join(row[i], row[i + 1], spec.walls[w].axis == 0 ? kPlusX : kPlusZ);
      }
      for (size_t k = 0; k < spec.corners.size(); ++k) {
        const Corner& corner = spec.corners[k];
        for (const int w : {corner.first, corner.second}) {
          const Wall& wall = spec.walls[static_cast<size_t>(w)];
          const int block = beside(corner, w, course), face = wall.axis == 0 ? kPlusX : kPlusZ;
          if (end_at(wall, corner) < 0)
            join(corner_block[k][c], block, face);
          else
            join(block, corner_block[k][c], face);
        }
      }
    }
    // Beds from the bottom up: columns stand on each other. A lintel may lie on or under several columns; each pair has
    // one joint.
    std::set<std::pair<int, int>> done;
    auto bed_of = [&](const auto& block_at) {
      for (int course = 0; course < spec.courses; ++course) {
        const int below = course == 0 ? beam : block_at(static_cast<size_t>(course) - 1);
        const int above = block_at(static_cast<size_t>(course));
        if (below >= 0 && above >= 0 && done.insert({below, above}).second)
          assembly.joints.push_back({below, above, kPlusY, course == 0 ? beam_family : bed});
      }
    };
    for (size_t w = 0; w < spec.walls.size(); ++w) {
      for (size_t i = 0; i < static_cast<size_t>(spec.walls[w].half_units); ++i)
        bed_of([&](size_t course) { return column_block[w][course][i]; });
    }
    for (size_t k = 0; k < spec.corners.size(); ++k) bed_of([&](size_t course) { return corner_block[k][course]; });
  }
};

// Part of the building in plan: a wall, or a corner and the walls that it joins.
struct InPlan {
  std::string name, source;
  std::array<double, 2> lower, size;  // x and z, m
  std::vector<std::size_t> joined;    // indices of walls
};

std::vector<InPlan> parts_of(const BuildingSpec& building) {
  std::vector<InPlan> parts;
  for (const Wall& wall : building.walls) {
    const double length = wall.half_units * wall.half_unit, across = building.thickness;
    parts.push_back({fmt::format("wall '{}'", wall.name),
                     wall.source.text,
                     wall.start,
                     wall.axis == 0 ? std::array{length, across} : std::array{across, length},
                     {}});
  }
  for (const Corner& corner : building.corners)
    parts.push_back({fmt::format("the corner at ({:g}, {:g})", corner.at[0], corner.at[1]),
                     corner.source.text,
                     corner.at,
                     {building.thickness, building.thickness},
                     {static_cast<size_t>(corner.first), static_cast<size_t>(corner.second)}});
  return parts;
}

// Visits pairs of parts with the lengths that they have in common along x and z, in micrometres. < 0: a gap.
template <class Visit>
void each_pair(const std::vector<InPlan>& parts, const Visit& visit) {
  for (std::size_t i = 0; i < parts.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const InPlan &a = parts[j], &b = parts[i];
      const auto common = [&](std::size_t c) {
        return micrometres(std::min(a.lower[c] + a.size[c], b.lower[c] + b.size[c]) - std::max(a.lower[c], b.lower[c]));
      };
      visit(a, b, common(0), common(1), std::ranges::find(b.joined, j) != b.joined.end());
    }
  }
}

// Walls meet at corners alone. Blocks that overlap have no joint, and their gridpoints are not those of one grid.
void refuse_overlaps(const BuildingSpec& building) {
  each_pair(parts_of(building), [](const InPlan& a, const InPlan& b, long x, long z, bool) {
    if (x <= 0 || z <= 0) return;
    throw Error(Exit::bad_input,
                fmt::format("{}: {} overlaps {} in plan, by {:g} m along x and {:g} m along z; walls end at each "
                            "other's faces, and are joined by [[building.corner]] at their ends",
                            b.source, b.name, a.name, 1e-6 * static_cast<double>(x), 1e-6 * static_cast<double>(z)));
  });
}

}  // namespace

std::vector<std::string> BuildingSpec::Floor::bodies() const {
  std::vector<std::string> names;
  for (size_t i = 0; i < half_units.size(); ++i) names.push_back(fmt::format("{}_{}", name, i + 1));
  return names;
}

bool has_walls_that_touch(const BuildingSpec& building) {
  constexpr long kGap = 10;  // micrometres, up to which the faces of small blocks make a joint
  bool found = false;
  each_pair(parts_of(building), [&](const InPlan&, const InPlan&, long x, long z, bool joined) {
    const auto touches = [](long across, long along) { return across <= 0 && across >= -kGap && along > 0; };
    found = found || (!joined && (touches(x, z) || touches(z, x)));
  });
  return found;
}

std::vector<std::string> bodies_called(const std::string& name, const BuildingSpec& building) {
  for (const BuildingSpec::Floor& floor : building.floors) {
    if (floor.name == name) return floor.bodies();
  }
  return {name};
}

Assembly generate_building(const BuildingSpec& building, const std::map<std::string, BlockMaterial>& materials,
                           const std::map<std::string, JointFamily>& joints) {
  refuse_overlaps(building);
  auto assembly = with_materials<Assembly>(materials, joints);
  Builder builder{building,
                  materials,
                  assembly,
                  index_of(materials, building.unit_material),
                  index_of(joints, building.head_joint),
                  index_of(joints, building.unit_joint),
                  index_of(joints, building.bed_joint),
                  index_of(joints, building.beam_joint),
                  0,
                  {},
                  {}};
  for (const Corner& corner : building.corners) {
    for (const int w : {corner.first, corner.second}) {
      const Wall& wall = building.walls[static_cast<size_t>(w)];
      if (builder.end_at(wall, corner) == 0)
        throw Error(Exit::bad_input,
                    fmt::format("{}: wall {} neither starts nor ends at this corner", corner.source.text, wall.name));
      if (builder.end_at(wall, corner) < 0 && wall.first_course == "half")
        throw Error(Exit::bad_input, fmt::format("{}: first_course = 'half': without effect, as a corner starts this "
                                                 "wall, whose `first` says which courses begin with it; remove it",
                                                 wall.source.text));
    }
  }
  builder.add_walls();
  builder.colour();
  builder.add_floors();
  builder.add_beam();
  builder.add_joints();
  return assembly;
}

}  // namespace quoin
