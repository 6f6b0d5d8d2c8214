#include "results/vtk.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "files/result_folder.h"
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
    declared_[section] += fmt::format("<PDataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\"{}/>\n",
                                      kVtkType<T>, xml_text(name), components, extra);
  }
  void write(const std::filesystem::path& path, size_t points, size_t cells) {
    std::string piece = fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n", points, cells);
    for (const char* section : {"Points", "Cells", "PointData", "CellData"})
      piece += fmt::format("<{0}>\n{1}</{0}>\n", section, sections_[section]);
    arrays_.write(path, piece + "</Piece>\n");
  }
  // What names the pieces of a grid, each with these arrays.
  void write_index(const std::filesystem::path& path, const std::vector<std::string>& pieces) {
    std::string text =
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
        "header_type=\"UInt64\">\n<PUnstructuredGrid GhostLevel=\"0\">\n";
    for (const char* section : {"Points", "PointData", "CellData"})
      text += fmt::format("<P{0}>\n{1}</P{0}>\n", section, declared_[section]);
    for (const std::string& piece : pieces) text += fmt::format("<Piece Source=\"{}\"/>\n", piece);
    write_file(path, text + "</PUnstructuredGrid>\n</VTKFile>\n");
  }

 private:
  VtkArrays arrays_;
  std::map<std::string, std::string> sections_, declared_;
};

void add(std::vector<float>& values, const Vec3& v) {
  for (const double x : v) values.push_back(static_cast<float>(x));
}

// A grid to be written, with its sizes.
struct Filled {
  Grid grid;
  size_t points = 0, cells = 0;
};

Filled fill_blocks(const Simulation& simulation, const Surfaces& surfaces, bool compressed, bool own_alone) {
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
    if (own_alone && !simulation.owns_block(b)) continue;
    const auto mesh = surfaces.mesh(simulation, b);
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
  return {std::move(grid), points.size() / 3, types.size()};
}

std::set<std::string> state_ids(const Simulation& simulation) {
  std::set<std::string> ids;
  for (const ContactFamily& f : simulation.model().families) {
    const quoin_law& law = f.material->api();
    for (uint64_t s = 0; s < law.state_count; ++s) ids.insert(law.states[s]->id);
  }
  return ids;
}

// A joint goes with the first of its blocks, whose rank evaluates all of its points.
Filled fill_joints(const Simulation& simulation, const Surfaces& surfaces, bool compressed, bool own_alone) {
  const auto joint_points = surfaces.joint_points(simulation, own_alone);
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
  std::vector<std::int64_t> place(static_cast<size_t>(simulation.point_count()), -1);  // by contact point
  for (size_t i = 0; i < joint_points.size(); ++i)
    place[static_cast<size_t>(joint_points[i].contact.index)] = static_cast<std::int64_t>(i);
  for (const auto& quad : surfaces.quads(simulation)) {
    if (place[static_cast<size_t>(quad[0])] < 0) continue;
    for (const int corner : quad) connectivity.push_back(place[static_cast<size_t>(corner)]);
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
    if (!simulation.keeps_state(id)) continue;
    std::vector<float> column;
    const auto values = simulation.state(id);
    for (const JointPoint& p : joint_points)
      column.push_back(static_cast<float>(values[static_cast<size_t>(p.contact.index)]));
    grid.array("PointData", "state_" + id, column);
  }
  return {std::move(grid), joint_points.size(), offsets.size()};
}

constexpr std::array kKinds{"blocks", "joints"};

std::string piece_name(const char* kind, size_t frame, int rank) {
  return fmt::format("{}_{:04}_r{}.vtu", kind, frame, rank);
}

}  // namespace

double frame_bytes(const Simulation& simulation, const Surfaces& surfaces) {
  constexpr double kVector = 12.0, kNumber = 4.0, kIndex = 8.0, kHeads = 10000.0;
  double bytes = kHeads;
  for (int b = 0; b < simulation.block_count(); ++b) {
    const auto mesh = surfaces.mesh(simulation, b);
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
  // With ranks of the points that are here, and of the others as many.
  const Model& model = simulation.model();
  double here = 0.0;
  for (int c = 0; c < static_cast<int>(model.chunks.size()); ++c)
    here += model.has_laid_out(c) ? model.chunks[static_cast<size_t>(c)].point_count : 0;
  const double quads = here > 0.0 ? static_cast<double>(surfaces.quads(simulation).size()) * points / here : 0.0;
  return bytes + (simulation.riding() ? points * (2 * kIndex + 1.0) : quads * (5 * kIndex + 1.0));
}

VtkSeries::VtkSeries(std::filesystem::path folder, const Surfaces& surfaces, std::vector<double> before,
                     bool compressed, Pieces pieces)
    : folder_(std::move(folder)),
      surfaces_(surfaces),
      times_(std::move(before)),
      compressed_(compressed),
      pieces_(pieces) {
  note_pieces();
}

void VtkSeries::add_frame(const Simulation& simulation) { add(simulation, false); }
void VtkSeries::add_piece(const Simulation& simulation) { add(simulation, pieces_.count > 1); }

void VtkSeries::add(const Simulation& simulation, bool piece) {
  const size_t frame = times_.size();
  for (const char* kind : kKinds) {
    Filled filled = (kind == kKinds[0] ? fill_blocks : fill_joints)(simulation, surfaces_, compressed_, piece);
    const std::string name = piece ? piece_name(kind, frame, pieces_.rank) : fmt::format("{}_{:04}.vtu", kind, frame);
    filled.grid.write(folder_ / name, filled.points, filled.cells);
    if (!piece || pieces_.rank > 0) continue;
    std::vector<std::string> all;
    for (int r = 0; r < pieces_.count; ++r) all.push_back(piece_name(kind, frame, r));
    filled.grid.write_index(folder_ / fmt::format("{}_{:04}.pvtu", kind, frame), all);
  }
  times_.push_back(simulation.time());
  note_pieces();
}

void VtkSeries::note_pieces() const {
  for (int r = 1; r < pieces_.count && pieces_.rank == 0; ++r) {
    for (const char* kind : kKinds) note_result(folder_ / piece_name(kind, times_.size(), r));
  }
}

void VtkSeries::finish() const {
  write_collection(folder_, "blocks", times_);
  write_collection(folder_, "joints", times_);
}

}  // namespace quoin
