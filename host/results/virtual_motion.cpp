#include "results/virtual_motion.h"

#include <cstdint>

#include "results/vtk_file.h"

namespace quoin {
namespace {

using geometry::Vector;

constexpr std::uint8_t kVtkPolygon = 7, kVtkTetrahedron = 10;

template <class T>
void add(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}
void add(std::string& bytes, const Vector& v) {
  for (int c = 0; c < 3; ++c) add(bytes, static_cast<float>(v[c]));
}

// Cells of all blocks, in VTK's format.
struct Cells {
  std::string corners, ends, types, blocks;
  std::int64_t count = 0, corner_count = 0;

  template <class Corners>
  void add_cell(const Corners& of_cell, std::int64_t first_point, int block, std::uint8_t type) {
    for (const int corner : of_cell) add(corners, first_point + corner), ++corner_count;
    add(ends, corner_count), add(types, type), add(blocks, std::int32_t{block});
    ++count;
  }
};

}  // namespace

void write_motions(const std::filesystem::path& file, const std::vector<StillBlock>& blocks,
                   const std::vector<VirtualMotion>& motions) {
  std::string points;
  Cells cells;
  std::int64_t point_count = 0;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const StillBlock& block = blocks[b];
    for (const Vector& p : block.point) add(points, p);
    for (const auto& zone : block.zone) cells.add_cell(zone, point_count, static_cast<int>(b), kVtkTetrahedron);
    if (block.zone.empty()) {
      for (const auto& face : block.face) cells.add_cell(face, point_count, static_cast<int>(b), kVtkPolygon);
    }
    point_count += static_cast<std::int64_t>(block.point.size());
  }
  std::vector<VtkArray> arrays{{"Points", "position", kVtkType<float>, 3},
                               {"Cells", "connectivity", kVtkType<std::int64_t>, 1, VtkRows::corner},
                               {"Cells", "offsets", kVtkType<std::int64_t>, 1, VtkRows::cell},
                               {"Cells", "types", kVtkType<std::uint8_t>, 1, VtkRows::cell},
                               {"CellData", "block", kVtkType<std::int32_t>, 1, VtkRows::cell}};
  for (const VirtualMotion& motion : motions) arrays.push_back({"PointData", motion.name, kVtkType<float>, 3});
  VtkSizes sizes;
  sizes.points = static_cast<std::uint64_t>(point_count), sizes.cells = static_cast<std::uint64_t>(cells.count);
  sizes.corners = static_cast<std::uint64_t>(cells.corner_count);
  VtkFile vtu(file, arrays, sizes, false);
  const std::string* const of_grid[] = {&points, &cells.corners, &cells.ends, &cells.types, &cells.blocks};
  for (std::size_t i = 0; i < std::size(of_grid); ++i) vtu.append(i, *of_grid[i]);
  for (std::size_t m = 0; m < motions.size(); ++m) {
    std::string bytes;
    for (const auto& of_block : motions[m].displacement) {
      for (const Vector& u : of_block) add(bytes, u);
    }
    vtu.append(std::size(of_grid) + m, bytes);
  }
  vtu.finish();
}

}  // namespace quoin
