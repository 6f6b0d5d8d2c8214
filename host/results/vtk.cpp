#include "results/vtk.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "results/vtk_arrays.h"
#include "step/large_motion.h"

namespace quoin {

namespace {

constexpr std::uint8_t kVtkVertex = 1, kVtkPolygon = 7, kVtkQuad = 9, kVtkTetrahedron = 10, kVtkHexahedron = 12;

// An unstructured grid, its arrays by section.
class Grid {
 public:
  explicit Grid(bool compressed) : arrays_(compressed) {}
  template <typename T>
  void array(const char* section, const std::string& name, const std::vector<T>& values, int components = 1,
             const char* extra = "") {
    sections_[section] += arrays_.add(name, values, components, extra);
  }
  void write(const std::filesystem::path& path, size_t points, size_t cells) {
    std::string piece = fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n", points, cells);
    for (const char* section : {"Points", "Cells", "PointData", "CellData"})
      piece += fmt::format("<{0}>\n{1}</{0}>\n", section, sections_[section]);
    arrays_.write(path, piece + "</Piece>\n");
  }

 private:
  VtkArrays arrays_;
  std::map<std::string, std::string> sections_;
};

void add(std::vector<float>& values, const Vec3& v) {
  for (const double x : v) values.push_back(static_cast<float>(x));
}

void write_blocks(const Simulation& simulation, const Surfaces& surfaces, bool compressed,
                  const std::filesystem::path& path) {
  std::vector<float> points, displacement, stress;
  std::vector<std::int64_t> connectivity, offsets;
  std::vector<std::uint8_t> types;
  std::vector<std::int32_t> block, unit, course;
  const auto add_cell = [&](std::int64_t first, const auto& corners, std::uint8_t type) {
    for (const int corner : corners) connectivity.push_back(first + corner);
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
    types.push_back(type);
  };
  for (int b = 0; b < simulation.block_count(); ++b) {
    const auto& mesh = surfaces.mesh(b);
    const auto first = static_cast<std::int64_t>(points.size() / 3);
    for (const Vec3& p : mesh.gridpoint) add(points, p);
    for (const Vec3& u : simulation.block_displacement(b)) add(displacement, u);
    for (const auto& zone : mesh.zone) add_cell(first, zone, kVtkTetrahedron);
    const bool rigid = mesh.zone.empty(), brick = rigid && !simulation.riding();
    if (brick) add_cell(first, std::array{0, 1, 3, 2, 4, 5, 7, 6}, kVtkHexahedron);
    for (const auto& face : mesh.face) {
      if (rigid && !brick) add_cell(first, face, kVtkPolygon);
    }
    for (const auto& tensor : simulation.block_stress(b)) {
      for (const double s : tensor) stress.push_back(static_cast<float>(s));
    }
    const size_t cells = brick ? 1 : rigid ? mesh.face.size() : mesh.zone.size();
    if (rigid) stress.insert(stress.end(), 6 * cells, 0.0F);
    block.insert(block.end(), cells, b);
    unit.insert(unit.end(), cells, mesh.unit);
    course.insert(course.end(), cells, mesh.course);
  }
  Grid grid(compressed);
  grid.array("Points", "position", points, 3);
  grid.array("Cells", "connectivity", connectivity);
  grid.array("Cells", "offsets", offsets);
  grid.array("Cells", "types", types);
  grid.array("PointData", "displacement_m", displacement, 3);
  grid.array("CellData", "stress_Pa", stress, 6,
             " ComponentName0=\"xx\" ComponentName1=\"yy\" ComponentName2=\"zz\" ComponentName3=\"xy\" "
             "ComponentName4=\"yz\" ComponentName5=\"zx\"");
  grid.array("CellData", "block", block);
  grid.array("CellData", "unit", unit);
  grid.array("CellData", "course", course);
  grid.write(path, points.size() / 3, types.size());
}

std::set<std::string> state_ids(const Simulation& simulation) {
  std::set<std::string> ids;
  for (const ContactFamily& f : simulation.model().families) {
    const quoin_law& law = f.material->api();
    for (uint64_t s = 0; s < law.state_count; ++s) ids.insert(law.states[s]->id);
  }
  return ids;
}

void write_joints(const Simulation& simulation, const Surfaces& surfaces, bool compressed,
                  const std::filesystem::path& path) {
  const auto joint_points = surfaces.joint_points(simulation);
  std::vector<float> points, displacement, traction, opening, slip, tension, shear, closure, area, normal, shear_axis;
  std::vector<std::int32_t> block_a, block_b, family, condition, crack;
  for (const JointPoint& p : joint_points) {
    add(points, p.contact.position);
    add(displacement, p.displacement);
    add(traction, p.contact.traction);
    add(normal, p.contact.normal);
    add(shear_axis, p.contact.s);
    area.push_back(static_cast<float>(p.contact.area));
    block_a.push_back(p.contact.block_a);
    block_b.push_back(p.contact.block_b);
    opening.push_back(static_cast<float>(p.opening));
    slip.push_back(static_cast<float>(p.slip));
    tension.push_back(static_cast<float>(p.damage_tension));
    shear.push_back(static_cast<float>(p.damage_shear));
    closure.push_back(static_cast<float>(p.closure));
    family.push_back(p.contact.family);
    condition.push_back(static_cast<std::int32_t>(p.contact.condition));
    crack.push_back(static_cast<std::int32_t>(p.crack));
  }
  // Joints of lattices are surfaces; elsewhere their points stand alone.
  std::vector<std::int64_t> connectivity, offsets;
  for (const auto& quad : surfaces.quads()) {
    for (const int corner : quad) connectivity.push_back(corner);
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
  }
  const std::uint8_t cell = simulation.riding() ? kVtkVertex : kVtkQuad;
  for (size_t i = 0; simulation.riding() && i < joint_points.size(); ++i) {
    connectivity.push_back(static_cast<std::int64_t>(i));
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
  }
  Grid grid(compressed);
  grid.array("Points", "position", points, 3);
  grid.array("Cells", "connectivity", connectivity);
  grid.array("Cells", "offsets", offsets);
  grid.array("Cells", "types", std::vector<std::uint8_t>(offsets.size(), cell));
  grid.array("PointData", "displacement_m", displacement, 3);
  grid.array("PointData", "traction_Pa", traction, 3,
             " ComponentName0=\"sigma\" ComponentName1=\"tau_s\" ComponentName2=\"tau_t\"");
  grid.array("PointData", "normal", normal, 3);
  grid.array("PointData", "shear_axis", shear_axis, 3);
  grid.array("PointData", "area_m2", area);
  grid.array("PointData", "block_a", block_a);
  grid.array("PointData", "block_b", block_b);
  grid.array("PointData", "opening_m", opening);
  grid.array("PointData", "slip_m", slip);
  grid.array("PointData", "damage_tension", tension);
  grid.array("PointData", "damage_shear", shear);
  grid.array("PointData", "plastic_closure_m", closure);
  grid.array("PointData", "family", family);
  grid.array("PointData", "condition", condition);
  grid.array("PointData", "crack", crack);

  // And the law's own states, whatever they are.
  for (const std::string& id : state_ids(simulation)) {
    std::vector<float> column;
    const auto values = simulation.state(id);
    if (std::none_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); })) continue;
    for (const JointPoint& p : joint_points)
      column.push_back(static_cast<float>(values[static_cast<size_t>(p.contact.index)]));
    grid.array("PointData", "state_" + id, column);
  }
  grid.write(path, joint_points.size(), offsets.size());
}

}  // namespace

double frame_bytes(const Simulation& simulation, const Surfaces& surfaces) {
  constexpr double kVector = 12.0, kNumber = 4.0, kIndex = 8.0, kHeads = 10000.0;
  double bytes = kHeads;
  for (int b = 0; b < simulation.block_count(); ++b) {
    const auto& mesh = surfaces.mesh(b);
    double corners = 4.0 * static_cast<double>(mesh.zone.size()), cells = static_cast<double>(mesh.zone.size());
    const bool rigid = mesh.zone.empty(), brick = rigid && !simulation.riding();
    if (brick) corners = 8.0, cells = 1.0;
    for (const auto& face : mesh.face) {
      if (rigid && !brick) corners += static_cast<double>(face.size()), cells += 1.0;
    }
    // Place and displacement; offset, type, stress of six components, block, unit and course.
    bytes += static_cast<double>(mesh.gridpoint.size()) * 2 * kVector + corners * kIndex +
             cells * (kIndex + 1.0 + 6 * kNumber + 3 * kNumber);
  }
  // Vectors: place, displacement, traction, normal, shear axis. Numbers: 6 of the joint, 5 codes, the law's states.
  const auto points = static_cast<double>(simulation.point_count());
  bytes += points * (5 * kVector + 11 * kNumber + static_cast<double>(state_ids(simulation).size()) * kNumber);
  const auto quads = static_cast<double>(surfaces.quads().size());
  return bytes + (simulation.riding() ? points * (2 * kIndex + 1.0) : quads * (5 * kIndex + 1.0));
}

void VtkSeries::add_frame(const Simulation& simulation) {
  const size_t frame = times_.size();
  write_blocks(simulation, surfaces_, compressed_, folder_ / fmt::format("blocks_{:04}.vtu", frame));
  write_joints(simulation, surfaces_, compressed_, folder_ / fmt::format("joints_{:04}.vtu", frame));
  times_.push_back(simulation.time());
}

void VtkSeries::finish() const {
  write_collection(folder_, "blocks", times_);
  write_collection(folder_, "joints", times_);
}

}  // namespace quoin
