#include "results/vtk.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>

#include "results/file.h"

namespace quoin {

namespace {

constexpr std::uint8_t kVtkQuad = 9, kVtkTetrahedron = 10, kVtkHexahedron = 12;

// An unstructured grid in VTK's XML, with all arrays raw in one appended block.
class Grid {
 public:
  template <typename T>
  void array(const char* section, const std::string& name, const std::vector<T>& values, int components = 1,
             const char* extra = "") {
    const char* type = std::is_same_v<T, float>          ? "Float32"
                       : std::is_same_v<T, std::int32_t> ? "Int32"
                       : std::is_same_v<T, std::uint8_t> ? "UInt8"
                                                         : "Int64";
    std::string& text = section == std::string_view("PointData")  ? point_data_
                        : section == std::string_view("CellData") ? cell_data_
                        : section == std::string_view("Points")   ? points_
                                                                  : cells_;
    text += fmt::format(
        "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"{}/>\n", type,
        name, components, appended_.size(), extra);
    const std::uint64_t bytes = values.size() * sizeof(T);
    append(&bytes, sizeof bytes);
    append(values.data(), bytes);
  }

  void write(const std::filesystem::path& path, size_t points, size_t cells) const {
    write_file(path,
               fmt::format("<?xml version=\"1.0\"?>\n"
                           "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
                           "header_type=\"UInt64\">\n<UnstructuredGrid>\n"
                           "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<Points>\n{}</Points>\n<Cells>\n{}"
                           "</Cells>\n<PointData>\n{}</PointData>\n<CellData>\n{}</CellData>\n</Piece>\n"
                           "</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_",
                           points, cells, points_, cells_, point_data_, cell_data_) +
                   appended_ + "\n</AppendedData>\n</VTKFile>\n");
  }

 private:
  void append(const void* data, size_t bytes) {
    if (bytes > 0) appended_.append(static_cast<const char*>(data), bytes);
  }
  std::string points_, cells_, point_data_, cell_data_, appended_;
};

void add(std::vector<float>& values, const Vec3& v) {
  for (const double x : v) values.push_back(static_cast<float>(x));
}

void write_blocks(const Simulation& simulation, const Surfaces& surfaces, const std::filesystem::path& path) {
  std::vector<float> points, displacement, stress;
  std::vector<std::int64_t> connectivity, offsets;
  std::vector<std::uint8_t> types;
  std::vector<std::int32_t> block, unit, course;
  const auto& bricks = simulation.assembly().bricks;
  for (size_t b = 0; b < bricks.size(); ++b) {
    const auto& mesh = surfaces.mesh(static_cast<int>(b));
    const auto first = static_cast<std::int64_t>(points.size() / 3);
    for (const Vec3& p : mesh.gridpoint) add(points, p);
    for (const Vec3& u : simulation.block_displacement(static_cast<int>(b))) add(displacement, u);
    size_t cells = mesh.zone.size();
    if (bricks[b].rigid) {
      for (const int corner : {0, 1, 3, 2, 4, 5, 7, 6}) connectivity.push_back(first + corner);
      offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
      types.push_back(kVtkHexahedron);
      stress.insert(stress.end(), 6, 0.0F);
      cells = 1;
    } else {
      for (const auto& zone : mesh.zone) {
        for (const int corner : zone) connectivity.push_back(first + corner);
        offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
        types.push_back(kVtkTetrahedron);
      }
      for (const auto& tensor : simulation.block_stress(static_cast<int>(b))) {
        for (const double s : tensor) stress.push_back(static_cast<float>(s));
      }
    }
    block.insert(block.end(), cells, static_cast<std::int32_t>(b));
    unit.insert(unit.end(), cells, bricks[b].unit);
    course.insert(course.end(), cells, bricks[b].course);
  }
  Grid grid;
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

void write_joints(const Simulation& simulation, const Surfaces& surfaces, const std::filesystem::path& path) {
  const auto joint_points = surfaces.joint_points(simulation);
  std::vector<float> points, displacement, traction, opening, slip, tension, shear, closure, area, normal;
  std::vector<std::int32_t> block_a, block_b, family, condition, crack;
  for (const JointPoint& p : joint_points) {
    add(points, p.contact.position);
    add(displacement, p.displacement);
    add(traction, p.contact.traction);
    add(normal, p.contact.normal);
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
  std::vector<std::int64_t> connectivity, offsets;
  for (const auto& quad : surfaces.quads()) {
    for (const int corner : quad) connectivity.push_back(corner);
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
  }
  Grid grid;
  grid.array("Points", "position", points, 3);
  grid.array("Cells", "connectivity", connectivity);
  grid.array("Cells", "offsets", offsets);
  grid.array("Cells", "types", std::vector<std::uint8_t>(offsets.size(), kVtkQuad));
  grid.array("PointData", "displacement_m", displacement, 3);
  grid.array("PointData", "traction_Pa", traction, 3,
             " ComponentName0=\"sigma\" ComponentName1=\"tau_s\" ComponentName2=\"tau_t\"");
  grid.array("PointData", "normal", normal, 3);
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
  std::set<std::string> ids;
  for (const ContactFamily& f : simulation.model().families) {
    const quoin_law& law = f.material->api();
    for (uint64_t s = 0; s < law.state_count; ++s) ids.insert(law.states[s]->id);
  }
  for (const std::string& id : ids) {
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

void VtkSeries::add_frame(const Simulation& simulation) {
  const size_t frame = times_.size();
  write_blocks(simulation, surfaces_, folder_ / fmt::format("blocks_{:04}.vtu", frame));
  write_joints(simulation, surfaces_, folder_ / fmt::format("joints_{:04}.vtu", frame));
  times_.push_back(simulation.time());
}

void VtkSeries::finish() const {
  for (const char* what : {"blocks", "joints"}) {
    std::string text = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n";
    for (size_t frame = 0; frame < times_.size(); ++frame)
      text += fmt::format("<DataSet timestep=\"{:.9g}\" file=\"{}_{:04}.vtu\"/>\n", times_[frame], what, frame);
    write_file(folder_ / fmt::format("{}.pvd", what), text + "</Collection>\n</VTKFile>\n");
  }
}

}  // namespace quoin
