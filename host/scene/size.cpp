#include "scene/size.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/zoning.h"

namespace quoin {

namespace {

// Bytes, measured with `quoin check`: walls of 1e4 to 3e5 blocks (200 and 3400), single blocks of 4e4 to 1e6 zones
// (950, as seven of eight lanes are empty).
constexpr double kOfBlock = 3500.0, kOfPoint = 500.0, kOfZone = 200.0, kOfZoneAlone = 950.0;

using Counts = std::array<double, 3>;

// `count` blocks of hexahedra of 5 zones, with contact points at the gridpoints of one face in each direction.
void add_zoned(double count, const Counts& hexahedra, double zone_bytes, SceneSize* size) {
  const auto& [nx, ny, nz] = hexahedra;
  const double zones = 5 * nx * ny * nz * count;
  const double points = ((nx + 1) * (ny + 1) + (ny + 1) * (nz + 1) + (nz + 1) * (nx + 1)) * count;
  size->blocks += count;
  size->zones += zones;
  size->points += points;
  size->bytes += kOfBlock * count + zone_bytes * zones + kOfPoint * points;
}

// Points at the corners of each face, or no further apart than `spacing`, m, where that is more than 0.
void add_rigid(double count, const Vec3& extent, double spacing, SceneSize* size) {
  constexpr double kMostParts = 100.0;  // of a side: geometry/overlap.cpp
  Counts n{1, 1, 1};
  for (std::size_t k = 0; k < 3 && spacing > 0.0; ++k)
    n[k] = std::clamp(std::ceil(extent[k] / spacing), 1.0, kMostParts);
  add_zoned(count, n, 0.0, size);
  size->zones -= 5 * n[0] * n[1] * n[2] * count;
}

void add_tetrahedra(const BlockSpec& block, SceneSize* size) {
  const auto zones = double(block.tetrahedra.size()), gridpoints = double(block.vertices.size());
  size->blocks += 1;
  size->zones += zones;
  size->points += gridpoints;
  size->bytes += kOfBlock + kOfZoneAlone * zones + kOfPoint * gridpoints;
}

Counts divided(const Vec3& extent, double edge) {
  Counts n{};
  for (std::size_t k = 0; k < 3; ++k) n[k] = geometry::hexahedra_along(extent[k], edge);
  return n;
}

Counts as_counts(const std::array<int, 3>& n) { return {double(n[0]), double(n[1]), double(n[2])}; }

void add_block(const BlockSpec& block, double spacing, SceneSize* size) {
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
  if (block.rigid)
    add_rigid(1, extent, spacing, size);
  else if (!block.tetrahedra.empty())
    add_tetrahedra(block, size);
  else
    add_zoned(1, block.divisions[0] > 0 ? as_counts(block.divisions) : divided(extent, block.zone_edge), kOfZoneAlone,
              size);
}

void add_dry_wall(const DryWallSpec& wall, double spacing, SceneSize* size) {
  const bool halves = wall.mid_unit_joints;
  const double count = wall.courses * (halves ? 2.0 : 1.0) * std::ceil(wall.units_per_course + 1);
  const Vec3 extent{halves ? wall.unit[0] / 2 : wall.unit[0], wall.unit[1], wall.unit[2]};
  Counts hexahedra = as_counts(wall.zones);
  if (!halves) hexahedra[0] *= 2;
  if (wall.rigid)
    add_rigid(count, extent, spacing, size);
  else
    add_zoned(count, wall.zones[0] > 0 ? hexahedra : divided(extent, wall.zone_edge), kOfZone, size);
}

void add_arch(const ArchSpec& arch, double spacing, SceneSize* size) {
  const double turn = std::abs(arch.angles[1] - arch.angles[0]) * std::numbers::pi / 180;
  const Vec3 extent{(arch.radius + arch.thickness / 2) * turn / arch.voussoirs, arch.thickness, arch.depth};
  if (arch.rigid)
    add_rigid(arch.voussoirs + 2, extent, spacing, size);
  else
    add_zoned(arch.voussoirs, divided(extent, arch.zone_edge), kOfZone, size);
}

}  // namespace

SceneSize size_of(const Scene& scene) {
  SceneSize size;
  if (scene.wall) {
    const WallSpec& wall = *scene.wall;
    Counts hexahedra = as_counts(wall.zones);
    if (wall.half_thickness) hexahedra[2] /= 2;
    const double halves = 2.0 * wall.units_per_course * wall.courses;
    const double blocks = wall.mid_unit_joints ? halves : halves / 2;
    if (!wall.mid_unit_joints) hexahedra[0] *= 2;
    if (wall.rigid_units)
      add_rigid(blocks, wall.unit, 0.0, &size);
    else
      add_zoned(blocks, hexahedra, kOfZone, &size);
  }
  if (scene.building) {
    const BuildingSpec& building = *scene.building;
    double halves = static_cast<double>(building.corners.size());
    for (const BuildingSpec::Wall& wall : building.walls) halves += wall.half_units;
    add_zoned(halves * building.courses, as_counts(building.zones), kOfZone, &size);
  }
  if (scene.blocks) {
    const double spacing = scene.blocks->contact.point_spacing;
    for (const BlockSpec& block : scene.blocks->blocks) add_block(block, spacing, &size);
    for (const DryWallSpec& wall : scene.blocks->walls) add_dry_wall(wall, spacing, &size);
    for (const ArchSpec& arch : scene.blocks->arches) add_arch(arch, spacing, &size);
  }
  return size;
}

}  // namespace quoin
