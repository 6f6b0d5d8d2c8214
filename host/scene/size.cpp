#include "scene/size.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/zoning.h"

namespace quoin {

namespace {

// Memory in bytes, fitted to the peak memory of runs (benchmarks/RANKS.md, "Memory"), for congruent blocks in full SIMD
// groups of eight.
struct Costs {
  double gridpoint, point, rigid_block;
};
constexpr Costs kLattice{147.0, 207.0, 0.0}, kLargeMotion{167.0, 723.0, 0.0}, kRigidInMotion{0.0, 553.0, 2930.0};
constexpr double kAlone = 8.0;  // factor on gridpoints of a block without congruent ones, which uses one of eight lanes
// Bytes per block and per point of the whole lattice, which every rank stores.
constexpr double kOutlineOfBlock = 550.0, kOutlineOfPoint = 50.0;
constexpr double kOutlineInMotion = 0.25;  // share of memory in large motion that every rank stores of the whole model
constexpr double kOnBorders = 1.13;        // factor on a rank's equal share of the rest, for the blocks at its borders

using Counts = std::array<double, 3>;

double gridpoints_of(const Counts& n) { return (n[0] + 1) * (n[1] + 1) * (n[2] + 1); }

// Contact points of blocks that may have neighbours on all sides: the gridpoints of one face in each direction.
double points_all_round(const Counts& n) {
  return (n[0] + 1) * (n[1] + 1) + (n[1] + 1) * (n[2] + 1) + (n[2] + 1) * (n[0] + 1);
}

// Contact points of a head joint and of the bed joints to the next course. A half unit lies on one block, a whole one
// on two.
double points_in_a_wall(const Counts& n, bool halves) {
  const double bed = halves ? n[0] + 1 : 2 * (std::ceil(n[0] / 2) + 1);
  return (n[1] + 1) * (n[2] + 1) + bed * (n[2] + 1);
}

// Adds `count` blocks of hexahedra of 5 zones.
void add_zoned(double count, const Counts& n, double points, const Costs& costs, double alone, SceneSize* size) {
  size->blocks += count;
  size->zones += 5 * n[0] * n[1] * n[2] * count;
  size->points += points * count;
  size->bytes += count * (alone * costs.gridpoint * gridpoints_of(n) + costs.point * points);
}

// Adds rigid blocks. Where they have no memory of their own, each contact point has a gridpoint on either side.
void add_rigid(double count, double points, const Costs& costs, SceneSize* size) {
  const double gridpoints = costs.rigid_block > 0.0 ? 0.0 : 2.0 * points;
  size->blocks += count;
  size->points += points * count;
  size->bytes += count * (costs.rigid_block + costs.gridpoint * gridpoints + costs.point * points);
}

// Contact points of a rigid block: at the corners of each face, or `times` as many. If `spacing` (m) is more than 0,
// they are at most that far apart.
struct OfRigid {
  double spacing = 0.0, times = 1.0;
};
// Contact points of the scene's rigid blocks. Joints that carry tension or may crush have cubic points, 17 on a
// rectangle. Any initial state other than dry counts as one with tension.
OfRigid points_of_rigid(const Scene& scene) {
  constexpr double kCubic = 17.0 / 4.0;
  const double spacing = scene.blocks ? scene.blocks->contact.point_spacing : 0.0;
  const bool bonded = std::any_of(scene.joints.begin(), scene.joints.end(), [](const auto& joint) {
    return joint.second.initial_state != "dry" ||
           std::ranges::count(joint.second.properties, "compressive_strength", &PropertySetting::id) > 0;
  });
  return {spacing, spacing == 0.0 && scene.cubic_points.value_or(bonded) ? kCubic : 1.0};
}

Counts parts_of_rigid(const Vec3& extent, double spacing) {
  constexpr double kMostParts = 100.0;  // largest number along a side, as in geometry/overlap.cpp
  Counts n{1, 1, 1};
  for (std::size_t k = 0; k < 3 && spacing > 0.0; ++k)
    n[k] = std::clamp(std::ceil(extent[k] / spacing), 1.0, kMostParts);
  return n;
}

void add_tetrahedra(const BlockSpec& block, SceneSize* size) {
  const auto zones = double(block.tetrahedra.size()), gridpoints = double(block.vertices.size());
  size->blocks += 1;
  size->zones += zones;
  size->points += gridpoints;
  size->bytes += kAlone * kLargeMotion.gridpoint * std::max(gridpoints, zones / 5) + kLargeMotion.point * gridpoints;
}

Counts divided(const Vec3& extent, double edge) {
  Counts n{};
  for (std::size_t k = 0; k < 3; ++k) n[k] = geometry::hexahedra_along(extent[k], edge);
  return n;
}

Counts as_counts(const std::array<int, 3>& n) { return {double(n[0]), double(n[1]), double(n[2])}; }

// Adds blocks of one extent, rigid or zoned. given: their hexahedra; 0: by the edge of zones. points_of: contact
// points.
template <class Spec, class Points>
void add_blocks(double count, const Spec& spec, const Vec3& extent, const Counts& given, double alone,
                const OfRigid& rigid, const Points& points_of, SceneSize* size) {
  if (spec.rigid)
    return add_rigid(count, rigid.times * points_of(parts_of_rigid(extent, rigid.spacing)), kRigidInMotion, size);
  const Counts n = given[0] > 0 ? given : divided(extent, spec.zone_edge);
  add_zoned(count, n, points_of(n), kLargeMotion, alone, size);
}

void add_block(const BlockSpec& block, const OfRigid& rigid, SceneSize* size) {
  Vec3 low{}, extent{};
  if (block.box_size) {
    extent = *block.box_size;
  } else if (!block.vertices.empty()) {
    low = extent = block.vertices.front();
    for (const Vec3& p : block.vertices) {
      for (std::size_t k = 0; k < 3; ++k) low[k] = std::min(low[k], p[k]), extent[k] = std::max(extent[k], p[k]);
    }
    for (std::size_t k = 0; k < 3; ++k) extent[k] -= low[k];
  } else {
    return;
  }
  if (!block.rigid && !block.tetrahedra.empty()) return add_tetrahedra(block, size);
  add_blocks(1, block, extent, as_counts(block.divisions), kAlone, rigid, points_all_round, size);
}

void add_dry_wall(const DryWallSpec& wall, const OfRigid& rigid, SceneSize* size) {
  const bool halves = wall.mid_unit_joints;
  const double count = wall.courses * (halves ? 2.0 : 1.0) * std::ceil(wall.units_per_course + 1);
  const Vec3 extent{halves ? wall.unit[0] / 2 : wall.unit[0], wall.unit[1], wall.unit[2]};
  Counts hexahedra = as_counts(wall.zones);
  if (!halves) hexahedra[0] *= 2;
  const auto points_of = [&](const Counts& n) { return points_in_a_wall(n, halves); };
  add_blocks(count, wall, extent, hexahedra, 1.0, rigid, points_of, size);
}

void add_arch(const ArchSpec& arch, const OfRigid& rigid, SceneSize* size) {
  const double turn = std::abs(arch.angles[1] - arch.angles[0]) * std::numbers::pi / 180;
  const Vec3 extent{(arch.radius + arch.thickness / 2) * turn / arch.voussoirs, arch.thickness, arch.depth};
  add_blocks(arch.voussoirs + (arch.rigid ? 2 : 0), arch, extent, {}, 1.0, rigid, points_all_round, size);
}

}  // namespace

SceneSize size_of(const Scene& scene) {
  SceneSize size;
  const bool on_lattice =
      scene.solver.large_motion != LargeMotion::always && scene.solver.kernels != Kernels::general && !scene.blocks;
  const Costs& costs = on_lattice ? kLattice : kLargeMotion;
  const OfRigid rigid = points_of_rigid(scene);
  if (scene.wall) {
    const WallSpec& wall = *scene.wall;
    Counts hexahedra = as_counts(wall.zones);
    if (wall.half_thickness) hexahedra[2] /= 2;
    const double halves = 2.0 * wall.units_per_course * wall.courses;
    const double blocks = wall.mid_unit_joints ? halves : halves / 2;
    if (!wall.mid_unit_joints) hexahedra[0] *= 2;
    if (wall.rigid_units)
      add_rigid(blocks, rigid.times * points_in_a_wall({1, 1, 1}, wall.mid_unit_joints),
                on_lattice ? kLattice : kRigidInMotion, &size);
    else
      add_zoned(blocks, hexahedra, points_in_a_wall(hexahedra, wall.mid_unit_joints), costs, 1.0, &size);
  }
  if (scene.building) {
    const BuildingSpec& building = *scene.building;
    double halves = static_cast<double>(building.corners.size());
    for (const BuildingSpec::Wall& wall : building.walls) halves += wall.half_units;
    const Counts hexahedra = as_counts(building.zones);
    add_zoned(halves * building.courses, hexahedra, points_in_a_wall(hexahedra, true), costs, 1.0, &size);
  }
  if (scene.blocks) {
    for (const BlockSpec& block : scene.blocks->blocks) add_block(block, rigid, &size);
    for (const DryWallSpec& wall : scene.blocks->walls) add_dry_wall(wall, rigid, &size);
    for (const ArchSpec& arch : scene.blocks->arches) add_arch(arch, rigid, &size);
  }
  const bool all_rigid = size.zones == 0.0;  // rigid blocks need only what every rank stores
  if (on_lattice && !all_rigid)
    size.bytes_shared = std::max(0.0, size.bytes - kOutlineOfBlock * size.blocks - kOutlineOfPoint * size.points);
  const bool scatters =
      std::any_of(scene.joints.begin(), scene.joints.end(), [](const auto& joint) { return joint.second.scatters(); });
  if (!on_lattice && scene.damage.empty() && !scatters) size.bytes_shared = (1.0 - kOutlineInMotion) * size.bytes;
  return size;
}

double SceneSize::bytes_of_rank(int ranks) const {
  return bytes - bytes_shared * std::max(0.0, 1.0 - kOnBorders / ranks);
}

}  // namespace quoin
