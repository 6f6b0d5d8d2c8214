#include "results/report.h"

#include <fmt/format.h>
#include <zlib.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <sstream>

#include "base/error.h"
#include "base/input_file.h"
#include "base/number_text.h"
#include "files/file.h"
#include "files/markup.h"
#include "files/result_folder.h"
#include "results/colours.h"
#include "results/joint_table.h"
#include "results/read_vtu.h"
#include "results/report_parts.h"

namespace quoin {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;
using Triangle = std::array<std::int32_t, 3>;

constexpr std::uint8_t kQuad = 9, kPolygon = 7, kTetrahedron = 10, kHexahedron = 12;
constexpr double kSharp = 0.94;  // cosine of the angle between two triangles; below it, their common edge is drawn

// Arrays one after the other in one block of bytes, with their places.
class Blob {
 public:
  template <class T>
  void add(const std::string& name, const std::vector<T>& values) {
    bytes_.resize((bytes_.size() + 3) / 4 * 4);
    const char* type = std::is_same_v<T, float>           ? "Float32Array"
                       : std::is_same_v<T, std::int16_t>  ? "Int16Array"
                       : std::is_same_v<T, std::uint8_t>  ? "Uint8Array"
                       : std::is_same_v<T, std::uint32_t> ? "Uint32Array"
                                                          : "Int32Array";
    arrays_[name] = {{"type", type}, {"offset", bytes_.size()}, {"count", values.size()}};
    const auto* data = reinterpret_cast<const char*>(values.data());
    bytes_.append(data, values.size() * sizeof(T));
  }
  const Json& arrays() const { return arrays_; }
  // The bytes, compressed by zlib, in base64.
  std::string text() const {
    uLongf size = compressBound(bytes_.size());
    std::string packed(size, '\0');
    // The default level: the best one takes five times as long for the same size.
    compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(bytes_.data()),
              bytes_.size(), Z_DEFAULT_COMPRESSION);
    packed.resize(size);
    constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < packed.size(); i += 3) {
      std::uint32_t word = 0;
      for (std::size_t k = 0; k < 3; ++k)
        word = word << 8 | (i + k < packed.size() ? static_cast<unsigned char>(packed[i + k]) : 0U);
      for (std::size_t k = 0; k < 4; ++k) text += i + k > packed.size() ? '=' : digits[word >> (18 - 6 * k) & 63U];
    }
    return text;
  }

 private:
  std::string bytes_;
  Json arrays_ = Json::object();
};

// Values of all frames in few bits: value = stored * step + lower.
struct Quantised {
  double lower = 0.0, upper = 0.0;
  void see(const std::vector<float>& values) {
    for (const float v : values) {
      if (!std::isfinite(v)) continue;
      lower = std::min(lower, double{v}), upper = std::max(upper, double{v});
    }
  }
  std::vector<std::uint8_t> bytes(const std::vector<float>& values) const {
    std::vector<std::uint8_t> result;
    const double range = upper > lower ? upper - lower : 1.0;
    for (const float v : values)
      result.push_back(static_cast<std::uint8_t>(std::isfinite(v) ? std::lround(255.0 * (v - lower) / range) : 0));
    return result;
  }
  std::vector<std::int16_t> words(const std::vector<float>& values) const {  // symmetric about 0
    std::vector<std::int16_t> result;
    const double largest = std::max(upper, -lower);
    for (const float v : values)
      result.push_back(
          static_cast<std::int16_t>(std::isfinite(v) && largest > 0.0 ? std::lround(32767.0 * v / largest) : 0));
    return result;
  }
};

std::array<float, 3> at(const std::vector<float>& vectors, std::size_t i) {
  return {vectors[3 * i], vectors[3 * i + 1], vectors[3 * i + 2]};
}

// The surface of all blocks as triangles, with the points of the file that lie on it.
struct Surface {
  std::vector<std::uint32_t> vertex;  // by vertex of the surface: its point in the file
  std::vector<Triangle> triangle;     // indices of vertices of the surface
  std::vector<std::uint32_t> edge;    // pairs of vertices: sharp edges
  std::vector<std::int32_t> block;    // by vertex
  std::set<std::int32_t> beams;       // rigid beams on the lattice, which are not masonry
};

std::vector<Triangle> triangles_of(const VtuGrid& grid) {
  // Faces of tetrahedra, by their sorted corners: count, and corners in their order.
  std::map<Triangle, std::pair<int, Triangle>> faces;
  std::vector<Triangle> result;
  for (std::size_t c = 0; c < grid.cells(); ++c) {
    const std::size_t first = grid.first_corner(c);
    const auto corner = [&](std::size_t k) { return static_cast<std::int32_t>(grid.corner[first + k]); };
    if (grid.type[c] == kTetrahedron) {
      constexpr std::size_t kFaces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
      for (const auto& f : kFaces) {
        const Triangle face{corner(f[0]), corner(f[1]), corner(f[2])};
        Triangle sorted = face;
        std::sort(sorted.begin(), sorted.end());
        auto& seen = faces[sorted];
        ++seen.first, seen.second = face;
      }
    } else if (grid.type[c] == kHexahedron) {
      constexpr std::size_t kQuads[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                            {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
      for (const auto& q : kQuads) {
        result.push_back({corner(q[0]), corner(q[1]), corner(q[2])});
        result.push_back({corner(q[0]), corner(q[2]), corner(q[3])});
      }
    } else if (grid.type[c] == kPolygon) {
      for (std::size_t k = 2; k < grid.end[c] - first; ++k) result.push_back({corner(0), corner(k - 1), corner(k)});
    }
  }
  for (const auto& [sorted, seen] : faces) {
    if (seen.first == 1) result.push_back(seen.second);
  }
  return result;
}

Surface surface_of(const VtuFile& blocks) {
  const VtuGrid& grid = blocks.grid();
  const std::vector<float>& points = grid.position;
  Surface s;
  s.triangle = triangles_of(grid);
  std::vector<std::int32_t> number(points.size() / 3, -1);
  for (const Triangle& t : s.triangle) {
    for (const std::int32_t p : t) number[static_cast<std::size_t>(p)] = 0;
  }
  for (std::size_t p = 0; p < number.size(); ++p) {
    if (number[p] < 0) continue;
    number[p] = static_cast<std::int32_t>(s.vertex.size());
    s.vertex.push_back(static_cast<std::uint32_t>(p));
  }
  std::map<std::pair<std::int32_t, std::int32_t>, std::vector<Eigen::Vector3f>> edges;  // normals of both sides
  for (Triangle& t : s.triangle) {
    const auto corner = [&](int k) {
      return Eigen::Vector3f(at(points, static_cast<std::size_t>(t[static_cast<std::size_t>(k)])).data());
    };
    const Eigen::Vector3f normal = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
    for (std::int32_t& p : t) p = number[static_cast<std::size_t>(p)];
    for (std::size_t k = 0; k < 3; ++k) edges[std::minmax(t[k], t[(k + 1) % 3])].push_back(normal);
  }
  for (const auto& [ends, normals] : edges) {
    if (normals.size() == 2 && std::abs(normals[0].dot(normals[1])) > kSharp) continue;
    s.edge.push_back(static_cast<std::uint32_t>(ends.first));
    s.edge.push_back(static_cast<std::uint32_t>(ends.second));
  }
  // Cells have the number of their block, from which their corners have it.
  const auto block = blocks.read_indices("block", VtkRows::cell, grid.cells());
  std::vector<std::int32_t> of_point(grid.points(), -1);
  for (std::size_t c = 0, i = 0; c < grid.cells(); ++c) {
    for (; i < grid.end[c]; ++i) of_point[grid.corner[i]] = block[c];
  }
  for (const std::uint32_t p : s.vertex) s.block.push_back(of_point[p]);
  if (!blocks.has("unit")) return s;
  const auto unit = blocks.read<std::int32_t>("unit", VtkRows::cell);
  for (std::size_t c = 0; c < grid.cells(); ++c) {
    if (grid.type[c] == kHexahedron && unit[c] < 0) s.beams.insert(block[c]);
  }
  // Blocks of any shape have no units, and all of them are masonry.
  if (std::all_of(unit.begin(), unit.end(), [](std::int32_t u) { return u < 0; })) s.beams.clear();
  return s;
}

// Point of the file for each vertex of the surface, found by place. Promotion to large motion changes the order of
// points.
std::vector<std::uint32_t> points_of(const VtuFile& blocks, const Surface& surface, const std::vector<float>& start) {
  const VtuGrid& grid = blocks.grid();
  const auto block = blocks.read_indices("block", VtkRows::cell, grid.cells());
  std::map<std::pair<std::int32_t, std::array<float, 3>>, std::uint32_t> found;
  for (std::size_t c = 0, i = 0; c < grid.cells(); ++c) {
    for (; i < grid.end[c]; ++i)
      found[{block[c], at(grid.position, grid.corner[i])}] = static_cast<std::uint32_t>(grid.corner[i]);
  }
  std::vector<std::uint32_t> points;
  for (std::size_t v = 0; v < surface.vertex.size(); ++v) {
    const auto place = found.find({surface.block[v], at(start, v)});
    points.push_back(place == found.end() ? surface.vertex[v] : place->second);
  }
  return points;
}

// Volume and mass centre of a closed surface.
struct Solid {
  double volume = 0.0;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();  // centre times volume
};

// Solids of rigid blocks that are free to move, in their current places. All their loads but weight are forces of
// joints.
std::map<std::int32_t, Solid> rigid_solids(const VtuFile& blocks, const std::set<std::int32_t>& held) {
  const VtuGrid& grid = blocks.grid();
  const auto block = blocks.read_indices("block", VtkRows::cell, grid.cells());
  const auto moved = blocks.read<float>("displacement_m", VtkRows::point, 3);
  std::set<std::int32_t> zoned, moves;
  for (std::size_t c = 0, i = 0; c < grid.cells(); ++c) {
    if (grid.type[c] == kTetrahedron) zoned.insert(block[c]);
    for (; i < grid.end[c]; ++i) {
      if (at(moved, grid.corner[i]) != std::array<float, 3>{}) moves.insert(block[c]);
    }
  }
  std::vector<std::int32_t> of_point(grid.points(), -1);
  for (std::size_t c = 0, i = 0; c < grid.cells(); ++c) {
    for (; i < grid.end[c]; ++i) of_point[grid.corner[i]] = block[c];
  }
  const auto place = [&](std::size_t p) {
    const auto x = at(grid.position, p), u = at(moved, p);
    return Eigen::Vector3d(double{x[0]} + u[0], double{x[1]} + u[1], double{x[2]} + u[2]);
  };
  std::map<std::int32_t, Solid> solids;
  for (const Triangle& t : triangles_of(grid)) {
    const auto corner = [&](std::size_t k) { return place(static_cast<std::size_t>(t[k])); };
    const std::int32_t b = of_point[static_cast<std::size_t>(t[0])];
    if (zoned.contains(b) || held.contains(b) || !moves.contains(b)) continue;
    const double volume = corner(0).dot(corner(1).cross(corner(2))) / 6.0;  // volume of the tetrahedron with the origin
    solids[b].volume += volume, solids[b].moment += volume / 4.0 * (corner(0) + corner(1) + corner(2));
  }
  return solids;
}

// Stress of each cell, xx yy zz xy yz zx. Files have none for rigid blocks, whose mean stress follows from their
// joints.
std::vector<float> stress_of_cells(const VtuFile& blocks, const VtuFile& joints, const std::set<std::int32_t>& held) {
  auto stress = blocks.read<float>("stress_Pa", VtkRows::cell, 6);
  const std::map<std::int32_t, Solid> solids = rigid_solids(blocks, held);
  if (solids.empty()) return stress;
  std::map<std::int32_t, std::array<double, 3>> centre;
  for (const auto& [b, solid] : solids) {
    const Eigen::Vector3d x = solid.moment / solid.volume;
    if (x.allFinite()) centre[b] = {x[0], x[1], x[2]};
  }
  const auto moments = force_moments(joints, centre);
  const auto block = blocks.read_indices("block", VtkRows::cell, blocks.grid().cells());
  for (std::size_t c = 0; c < blocks.grid().cells(); ++c) {
    const auto found = moments.find(block[c]);
    for (std::size_t k = 0; found != moments.end() && k < 6; ++k)
      stress[6 * c + k] = static_cast<float>(found->second[k] / std::abs(solids.at(block[c]).volume));
  }
  return stress;
}

// Smallest principal stress (compression < 0) at points: the mean of their cells.
std::vector<float> stress_of(const VtuFile& blocks, const VtuFile& joints, const std::vector<std::uint32_t>& of_points,
                             const std::set<std::int32_t>& held) {
  const VtuGrid& grid = blocks.grid();
  const auto stress = stress_of_cells(blocks, joints, held);
  std::vector<double> sum(grid.points(), 0.0), count(grid.points(), 0.0);
  for (std::size_t c = 0, i = 0; c < grid.cells(); ++c) {
    const float* t = stress.data() + 6 * c;  // xx yy zz xy yz zx
    Eigen::Matrix3d tensor;
    tensor << t[0], t[3], t[5], t[3], t[1], t[4], t[5], t[4], t[2];
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    const double least = solver.computeDirect(tensor, Eigen::EigenvaluesOnly).eigenvalues()[0];
    for (; i < grid.end[c]; ++i) {
      sum[grid.corner[i]] += least;
      count[grid.corner[i]] += 1.0;
    }
  }
  std::vector<float> result;
  for (const std::uint32_t p : of_points) result.push_back(static_cast<float>(sum[p] / std::max(1.0, count[p])));
  return result;
}

// Joint quantities at the vertices of blocks: the largest values of the contact points closest to each.
struct JointValues {
  std::vector<float> damage, opening, slip;
};

// Vertices of each block, which have colours of its joints.
class VerticesOfBlocks {
 public:
  explicit VerticesOfBlocks(const Surface& surface) {
    for (std::size_t v = 0; v < surface.block.size(); ++v) {
      if (surface.block[v] < 0 || surface.beams.contains(surface.block[v])) continue;
      const auto b = static_cast<std::size_t>(surface.block[v]);
      if (b >= of_block_.size()) of_block_.resize(b + 1);
      of_block_[b].push_back(v);
    }
  }
  // Index of the vertex of the block that is closest to a place; none: the block has no surface.
  std::optional<std::size_t> nearest(std::int32_t block, const std::array<float, 3>& place,
                                     const std::vector<float>& positions) const {
    std::optional<std::size_t> best;
    float least = HUGE_VALF;
    if (block < 0 || static_cast<std::size_t>(block) >= of_block_.size()) return best;
    for (const std::size_t v : of_block_[static_cast<std::size_t>(block)]) {
      float squares = 0.0F;
      for (std::size_t c = 0; c < 3; ++c) squares += std::pow(positions[3 * v + c] - place[c], 2.0F);
      if (squares < least) least = squares, best = v;
      if (squares == 0.0F) break;
    }
    return best;
  }

 private:
  std::vector<std::vector<std::size_t>> of_block_;
};

// Joints of a frame, as the page shows them.
struct Joints {
  std::vector<float> place, displacement, gap, opening, slip, tension, shear;  // by point; gap: empty on the lattice
  std::vector<std::int32_t> block_a, block_b, crack;
  std::vector<std::uint32_t> rim;  // pairs of points: edges of joints of the lattice at the surface

  std::size_t count() const { return crack.size(); }
  // Place of a point on block a or b. They differ where the blocks have parted.
  std::array<float, 3> place_on(bool on_b, std::size_t i) const {
    std::array<float, 3> x = at(place, i);
    for (std::size_t c = 0; on_b && !gap.empty() && c < 3; ++c) x[c] += gap[3 * i + c];
    return x;
  }
  bool has_parted(std::size_t i) const { return !gap.empty() && at(gap, i) != std::array<float, 3>{}; }
};

JointValues joint_values(const Joints& joints, const VerticesOfBlocks& vertices, const std::vector<float>& positions) {
  JointValues values;
  for (auto* column : {&values.damage, &values.opening, &values.slip}) column->assign(positions.size() / 3, 0.0F);
  for (std::size_t i = 0; i < joints.count(); ++i) {
    for (const bool on_b : {false, true}) {
      const auto v =
          vertices.nearest(on_b ? joints.block_b[i] : joints.block_a[i], joints.place_on(on_b, i), positions);
      if (!v) continue;
      const auto raise = [&](std::vector<float>& column, float value) {
        if (value > column[*v]) column[*v] = value;
      };
      raise(values.damage, std::max(joints.tension[i], joints.shear[i]));
      raise(values.opening, joints.opening[i]);
      raise(values.slip, std::abs(joints.slip[i]));
    }
  }
  return values;
}

std::vector<float> vectors_at(const std::vector<std::uint32_t>& points, const std::vector<float>& vectors) {
  std::vector<float> result;
  for (const std::uint32_t p : points) {
    for (const float x : at(vectors, p)) result.push_back(x);
  }
  return result;
}

// Edges of only one quad, where a joint meets the surface.
std::vector<std::uint32_t> rim_of(const VtuGrid& grid) {
  std::map<std::pair<std::size_t, std::size_t>, int> edges;
  for (std::size_t c = 0; c < grid.cells(); ++c) {
    const std::size_t first = grid.first_corner(c), corners = grid.end[c] - first;
    for (std::size_t k = 0; k < corners && grid.type[c] == kQuad; ++k)
      ++edges[std::minmax(grid.corner[first + k], grid.corner[first + (k + 1) % corners])];
  }
  std::vector<std::uint32_t> rim;
  for (const auto& [ends, count] : edges) {
    if (count != 1) continue;
    rim.push_back(static_cast<std::uint32_t>(ends.first));
    rim.push_back(static_cast<std::uint32_t>(ends.second));
  }
  return rim;
}

Joints read_joints(const VtuFile& file) {
  constexpr auto kPoint = VtkRows::point;
  Joints j;
  j.place = file.grid().position, j.rim = rim_of(file.grid());
  j.displacement = file.read<float>("displacement_m", kPoint, 3);
  if (file.has("gap_m")) j.gap = file.read<float>("gap_m", kPoint, 3);
  j.opening = file.read<float>("opening_m", kPoint), j.slip = file.read<float>("slip_m", kPoint);
  j.tension = file.read<float>("damage_tension", kPoint), j.shear = file.read<float>("damage_shear", kPoint);
  j.block_a = file.read<std::int32_t>("block_a", kPoint), j.block_b = file.read<std::int32_t>("block_b", kPoint);
  j.crack = file.read_indices("crack", kPoint, kCrackCount);
  return j;
}

// Columns of numbers of history.csv, by name.
Json read_history(const fs::path& path) {
  std::istringstream text(read_input_file(path.string()));
  std::string line;
  std::vector<std::string> names;
  const auto cells_of = [](const std::string& row) {
    std::vector<std::string> cells(1);
    bool quoted = false;
    for (const char c : row) {
      if (c == '"') quoted = !quoted;
      if (c == ',' && !quoted)
        cells.emplace_back();
      else if (c != '"')
        cells.back() += c;
    }
    return cells;
  };
  if (!std::getline(text, line)) throw Error(Exit::bad_input, path.string() + ": is empty; run the scene again");
  names = cells_of(line);
  Json columns = Json::object();
  for (const std::string& name : names) columns[name] = Json::array();
  for (const char* needed :
       {"time_s", "displacement_m", "horizontal_force_N", "vertical_displacement_m", "vertical_force_N"}) {
    if (!columns.contains(needed))
      throw Error(Exit::bad_input, fmt::format("{}: has no column '{}'; run the scene again", path.string(), needed));
  }
  for (int row = 2; std::getline(text, line); ++row) {
    const std::vector<std::string> cells = cells_of(line);
    if (cells.size() != names.size())
      throw Error(Exit::bad_input, fmt::format("{}: line {} has {} cells, the first one {}; run the scene again",
                                               path.string(), row, cells.size(), names.size()));
    for (std::size_t c = 0; c < names.size(); ++c) {
      double value = 0.0;
      columns[names[c]].push_back(cells[c].empty()                ? Json(nullptr)
                                  : parse_number(cells[c], value) ? Json(value)
                                                                  : Json(cells[c]));
    }
  }
  return columns;
}

fs::path frame_path(const fs::path& folder, const char* kind, std::size_t frame) {
  std::error_code none;
  if (fs::exists(folder / fmt::format("{}_{:04}.pvtu", kind, frame), none))
    throw Error(Exit::bad_input,
                fmt::format("{}: its frames are in pieces, which ParaView reads and this page does not; "
                            "run it again without output.pieces",
                            folder.string()));
  return folder / fmt::format("{}_{:04}.vtu", kind, frame);
}

// Data of a run on the page: {head: JSON, data: base64}.
struct Part {
  Json head;
  std::string data;
};

void require_results(const fs::path& folder) {
  std::error_code error;
  if (fs::exists(folder / "study.json", error))
    throw Error(Exit::bad_input, fmt::format("{}: results of a study, whose page is index.html; give a run's folder, "
                                             "as `quoin run SCENE.toml --out DIR` makes it",
                                             folder.string()));
  if (!fs::exists(folder / "summary.json", error))
    throw Error(Exit::bad_input, fmt::format("{}: no results here (summary.json is missing); give the folder of a run "
                                             "that has ended, as quoin run SCENE.toml --out {} makes it",
                                             folder.string(), folder.string()));
  if (!fs::exists(folder / "blocks.pvd", error))
    throw Error(Exit::bad_input, fmt::format("{}: the run wrote no frames (blocks.pvd is missing); run it again with "
                                             "output.frames = 20",
                                             folder.string()));
}

Json read_summary(const fs::path& path) {
  constexpr int kDeepest = 100;  // Quoin's own have 5 levels
  const Json summary = Json::parse(
      read_input_file(path.string()),
      [](int depth, Json::parse_event_t, Json&) {
        if (depth > kDeepest) throw Error(Exit::bad_input, "summary.json: nested without an end");
        return true;
      },
      false);
  if (!summary.is_object())
    throw Error(Exit::bad_input, path.string() + ": is damaged or cut off; run the scene again");
  return summary;
}

// Blocks that some stage holds or drives, by their names in the summary.
std::set<std::int32_t> held_blocks(const Json& summary) {
  std::set<std::string> bodies;
  const auto each = [](const Json& of, const char* key, const auto& look) {
    if (!of.is_object() || !of.contains(key)) return;
    for (const Json& item : of.at(key)) look(item);
  };
  const Json settings = summary.value("settings", Json());
  each(settings, "stages", [&](const Json& stage) {
    each(stage, "controls", [&](const Json& control) {
      bool holds = false;
      each(control, "velocity_m_per_s", [&](const Json& v) { holds = holds || v.is_number(); });
      if (holds && control.contains("body") && control.at("body").is_string())
        bodies.insert(control.at("body").get<std::string>());
    });
  });
  std::set<std::int32_t> held;
  const Json names = summary.value("block_names", Json());
  for (const auto& [number, name] : names.items()) {
    constexpr double kMost = 1e9;  // largest number of blocks
    double value = 0.0;
    if (name.is_string() && bodies.contains(name.get<std::string>()) && parse_number(number, value) && value >= 0.0 &&
        value < kMost)
      held.insert(static_cast<std::int32_t>(value));
  }
  return held;
}

// Data of a frame on the page.
struct Frame {
  std::vector<float> displacement, stress, rim, points, points_moved;
  std::map<BlockPair, JointSum> sums;
  JointValues joints;
  std::vector<std::uint8_t> crack, point_crack;
  // Members in their current places: corners of bars and of panels of floors, m; N and N/m of each.
  std::vector<float> member_line, member_panel, member_force, member_shear;
};

// The surface of the first frame, with the edges of joints at it.
struct Start {
  std::vector<float> places;  // places of the file's points, m
  Surface surface;
  VerticesOfBlocks vertices;
  std::vector<float> position;     // places of vertices, m
  std::vector<std::uint32_t> rim;  // points at edges of joints of the lattice; empty before a frame with any
  std::vector<float> rim_position;
  std::set<std::int32_t> held;  // blocks that some stage holds or drives
  Start(const VtuFile& blocks, std::set<std::int32_t> held_ones)
      : places(blocks.grid().position),
        surface(surface_of(blocks)),
        vertices(surface),
        position(vectors_at(surface.vertex, places)),
        held(std::move(held_ones)) {}
};

// Adds joints of blocks of any shape as points, each of which moves with the closest vertex of its block. Where blocks
// have parted, each block has one.
void add_points(const Joints& joints, const Start& start, const std::vector<float>& standing, Frame* frame) {
  for (std::size_t i = 0; i < joints.count(); ++i) {
    if (joints.crack[i] == 0) continue;
    const auto add = [&](bool on_b) {
      const std::array<float, 3> place = joints.place_on(on_b, i);
      const auto beside = start.vertices.nearest(on_b ? joints.block_b[i] : joints.block_a[i], place, standing);
      if (!beside) return false;
      for (std::size_t c = 0; c < 3; ++c) {
        const float came = frame->displacement[3 * *beside + c];
        frame->points.push_back(place[c] - came);
        frame->points_moved.push_back(came);
      }
      frame->point_crack.push_back(static_cast<std::uint8_t>(joints.crack[i]));
      return true;
    };
    if (!add(false) || joints.has_parted(i)) add(true);
  }
}

void read_members(const fs::path& path, Frame* frame) {
  if (!fs::exists(path)) return;
  const VtuFile file(path);
  const VtuGrid& grid = file.grid();
  const auto force = file.read<float>("force_N", VtkRows::cell),
             shear = file.read<float>("shear_N_per_m", VtkRows::cell);
  for (std::size_t c = 0; c < grid.cells(); ++c) {
    const bool panel = grid.type[c] == kQuad;
    for (std::size_t i = grid.first_corner(c); i < grid.end[c]; ++i) {
      for (const float x : at(grid.position, grid.corner[i]))
        (panel ? frame->member_panel : frame->member_line).push_back(x);
    }
    (panel ? frame->member_shear : frame->member_force).push_back(panel ? shear[c] : force[c]);
  }
}

Frame read_frame(const fs::path& folder, std::size_t number, Start* start) {
  const fs::path path = frame_path(folder, "blocks", number);
  const VtuFile blocks(path), joints_file(frame_path(folder, "joints", number));
  const Joints joints = read_joints(joints_file);
  if (blocks.grid().position.size() != start->places.size())
    throw Error(Exit::bad_input, fmt::format("{}: has {} points, the first frame {}; run the scene again",
                                             path.string(), blocks.grid().points(), start->places.size() / 3));
  Frame frame;
  read_members(frame_path(folder, "members", number), &frame);
  frame.sums = joint_sums(joints_file);
  const auto vertex = blocks.grid().position == start->places ? start->surface.vertex
                                                              : points_of(blocks, start->surface, start->position);
  frame.displacement = vectors_at(vertex, blocks.read<float>("displacement_m", VtkRows::point, 3));
  frame.stress = stress_of(blocks, joints_file, vertex, start->held);
  // Joints of blocks of any shape are given in their current places, next to current vertices.
  std::vector<float> standing = start->position;
  for (std::size_t i = 0; joints.rim.empty() && i < standing.size(); ++i) standing[i] += frame.displacement[i];
  frame.joints = joint_values(joints, start->vertices, standing);
  if (joints.rim.empty()) {
    add_points(joints, *start, standing, &frame);
    return frame;
  }
  if (start->rim.empty()) start->rim = joints.rim, start->rim_position = vectors_at(joints.rim, joints.place);
  for (const std::uint32_t p : start->rim) {
    if (p >= joints.count()) throw Error(Exit::bad_input, folder.string() + ": frames of different joints");
    for (const float x : at(joints.displacement, p)) frame.rim.push_back(x);
    frame.crack.push_back(static_cast<std::uint8_t>(joints.crack[p]));
  }
  return frame;
}

// Components of "#rrggbb", 0 to 255.
Json bytes_of(const std::string& colour) {
  Json bytes = Json::array();
  for (const std::size_t place : {1, 3, 5}) bytes.push_back(std::stoi(colour.substr(place, 2), nullptr, 16));
  return bytes;
}

// Colours of all elements of the page, cracks by their numbers.
Json colours() {
  Json cracks = Json::array();
  for (const CrackStyle& style : kCrackStyles) cracks.push_back({{"label", style.label}, {"colour", style.colour}});
  return {{"cracks", cracks},
          {"cold", bytes_of(kQuantityColours.cold)},
          {"middle", bytes_of(kQuantityColours.middle)},
          {"warm", bytes_of(kQuantityColours.warm)},
          {"pens", kPens}};
}

// Drops bits beyond the three digits that the page shows, which would only enlarge it.
float shortened(double value) {
  const auto exact = static_cast<float>(value);
  std::uint32_t bits = 0;
  std::memcpy(&bits, &exact, sizeof bits);
  constexpr std::uint32_t kDropped = 0xfffu;  // bits dropped of 23: the rest is exact to 1 in 2048
  bits &= ~kDropped;
  float result = 0.0F;
  std::memcpy(&result, &bits, sizeof bits);
  return result;
}

// Largest product of joints and frames whose forces a page has: more would make it too large to open.
constexpr std::size_t kMostForces = 1'500'000;

// Adds the joints of all frames, in one order.
void add_joints(const std::vector<Frame>& frames, Blob* blob) {
  std::set<BlockPair> pairs;
  for (const Frame& frame : frames) {
    for (const auto& [pair, sum] : frame.sums) pairs.insert(pair);
  }
  std::vector<std::int32_t> a, b;
  for (const auto& [first, second] : pairs) a.push_back(first), b.push_back(second);
  blob->add("joint_a", a), blob->add("joint_b", b);
  using Column = std::pair<const char*, double JointSum::*>;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    for (const auto& [name, column] :
         {Column{"area", &JointSum::area}, Column{"normal", &JointSum::normal}, Column{"shear", &JointSum::shear},
          Column{"eccentricity", &JointSum::eccentricity}, Column{"opening", &JointSum::opening},
          Column{"slip", &JointSum::slip}, Column{"damage", &JointSum::damage}}) {
      std::vector<float> values;
      for (const BlockPair& pair : pairs) {
        const auto found = frames[f].sums.find(pair);
        values.push_back(found == frames[f].sums.end() ? 0.0F : shortened(found->second.*column));
      }
      blob->add(fmt::format("joint_{}{}", name, f), values);
    }
    std::vector<std::uint8_t> cracks;
    for (const BlockPair& pair : pairs) {
      const auto found = frames[f].sums.find(pair);
      cracks.push_back(static_cast<std::uint8_t>(found == frames[f].sums.end() ? 0 : found->second.crack));
    }
    blob->add(fmt::format("joint_crack{}", f), cracks);
  }
  if (pairs.size() * frames.size() > kMostForces) return;
  using Vectors = std::pair<const char*, std::array<double, 3> JointSum::*>;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    for (const auto& [name, vector] : {Vectors{"force", &JointSum::force}, Vectors{"place", &JointSum::place},
                                       Vectors{"axis", &JointSum::direction}}) {
      std::vector<float> values;
      for (const BlockPair& pair : pairs) {
        const auto found = frames[f].sums.find(pair);
        for (std::size_t c = 0; c < 3; ++c)
          values.push_back(found == frames[f].sums.end() ? 0.0F : shortened((found->second.*vector)[c]));
      }
      blob->add(fmt::format("joint_{}{}", name, f), values);
    }
  }
}

// Largest displacement of a vertex, m.
double largest_of(const std::vector<Frame>& frames) {
  float squares = 0.0F;
  for (const Frame& frame : frames) {
    for (std::size_t i = 0; 3 * i + 2 < frame.displacement.size(); ++i) {
      const auto u = at(frame.displacement, i);
      squares = std::max(squares, u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    }
  }
  return std::sqrt(double{squares});
}

// Packs the surface and all frames in few bits, and adds arrays and ranges to *head.
std::string pack_frames(const Start& start, const std::vector<Frame>& frames, Json* head) {
  Quantised moved, rim_moved, stress, opening, slip, damage{0.0, 1.0};
  for (const Frame& frame : frames) {
    moved.see(frame.displacement), rim_moved.see(frame.rim), stress.see(frame.stress);
    opening.see(frame.joints.opening), slip.see(frame.joints.slip);
  }
  Blob blob;
  blob.add("position", start.position);
  std::vector<std::uint32_t> corners;
  for (const Triangle& t : start.surface.triangle) corners.insert(corners.end(), t.begin(), t.end());
  blob.add("triangle", corners);
  blob.add("edge", start.surface.edge);
  blob.add("rim", start.rim_position);
  blob.add("block", start.surface.block);
  add_joints(frames, &blob);
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const auto name = [f](const char* what) { return fmt::format("{}{}", what, f); };
    const Frame& frame = frames[f];
    blob.add(name("moved"), moved.words(frame.displacement));
    blob.add(name("stress"), stress.words(frame.stress));
    blob.add(name("damage"), damage.bytes(frame.joints.damage));
    blob.add(name("opening"), opening.words(frame.joints.opening));
    blob.add(name("slip"), slip.words(frame.joints.slip));
    if (frame.rim.size() == start.rim_position.size()) blob.add(name("rim_moved"), rim_moved.words(frame.rim));
    blob.add(name("member_line"), frame.member_line);
    blob.add(name("member_panel"), frame.member_panel);
    blob.add(name("member_force"), frame.member_force);
    blob.add(name("member_shear"), frame.member_shear);
    blob.add(name("crack"), frame.crack);
    blob.add(name("points"), frame.points);
    blob.add(name("points_moved"), frame.points_moved);
    blob.add(name("point_crack"), frame.point_crack);
  }
  const auto range = [](const Quantised& q) { return Json{q.lower, q.upper}; };
  (*head)["range"] = {{"stress", range(stress)},
                      {"damage", range(damage)},
                      {"opening", range(opening)},
                      {"slip", range(slip)},
                      {"moved", std::max(moved.upper, -moved.lower)},
                      {"rim_moved", std::max(rim_moved.upper, -rim_moved.lower)}};
  (*head)["largest_displacement"] = largest_of(frames);
  (*head)["arrays"] = blob.arrays();
  return blob.text();
}

Part part_of(const fs::path& folder, const OnFrame& on_frame) {
  require_results(folder);
  const std::vector<double> times = read_collection(folder, "blocks");
  if (times.empty()) throw Error(Exit::bad_input, fmt::format("{}: has no frames", (folder / "blocks.pvd").string()));
  Part part;
  part.head["name"] = fs::weakly_canonical(folder).filename().string();
  part.head["summary"] = read_summary(folder / "summary.json");
  part.head["history"] = read_history(folder / "history.csv");
  part.head["times"] = times;
  part.head["colours"] = colours();
  Start start{VtuFile(frame_path(folder, "blocks", 0)), held_blocks(part.head["summary"])};
  std::vector<Frame> frames;
  for (std::size_t f = 0; f < times.size(); ++f) {
    if (on_frame) on_frame(folder, f + 1, times.size());
    frames.push_back(read_frame(folder, f, &start));
  }
  part.data = pack_frames(start, frames, &part.head);
  return part;
}

// JSON without sequences that an HTML parser interprets.
std::string json_in_page(const Json& json) {
  std::string text;
  for (const char c : json.dump(-1, ' ', false, Json::error_handler_t::replace)) {
    if (c == '<')
      text += "\\u003c";
    else
      text += c;
  }
  return text;
}

// Files of three.js and of its mouse control.
std::vector<fs::path> three_js_files() {
  const char* given = std::getenv("QUOIN_THREE_JS");
  const fs::path folder = given ? given : "/usr/share/javascript/three";
  std::vector<fs::path> files{folder / "three.min.js", folder / "examples/js/controls/OrbitControls.js"};
  for (const fs::path& file : files) {
    std::error_code error;
    if (!fs::exists(file, error))
      throw Error(Exit::bad_input, fmt::format("{}: not found: a report needs three.js to draw; install it with "
                                               "`apt-get install libjs-three`, or set QUOIN_THREE_JS to its folder",
                                               file.string()));
  }
  return files;
}

std::string three_js() {
  std::string text;
  for (const fs::path& file : three_js_files()) {
    constexpr std::string_view end = "</script";  // in a string of theirs it would end the page's own script element
    const std::string script = read_input_file(file.string());
    std::size_t from = 0;
    for (std::size_t at = 0; (at = script.find(end, from)) != std::string::npos; from = at + 1)
      text.append(script, from, at + 1 - from).append("\\");
    text.append(script, from).append("\n");
  }
  return text;
}

}  // namespace

void require_report_library() { three_js_files(); }

namespace {

// scripts: elements with the runs of the page, or with their source.
std::string page_text(const std::string& title, const std::string& scripts) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">{}<title>{}</title>\n"
      "<style>{}</style></head><body>\n{}{}<script>{}</script>\n<script>{}</script>\n"
      "</body></html>\n",
      kPageMark, escaped(title), kReportStyle, kReportBody, scripts, three_js(), kReportScript);
}

std::string run_scripts(const Part& part) {
  return fmt::format(
      "<script type=\"application/json\" class=\"head\">{}</script>\n<script type=\"text/plain\" "
      "class=\"data\">{}</script>\n",
      json_in_page(part.head), part.data);
}

fs::path page_in(const fs::path& folder) {
  fs::path page = folder / "report.html";
  refuse_page_of_others(page);
  return page;
}

}  // namespace

std::string live_page_text(const std::string& title) {
  return page_text(title, "<script type=\"application/json\" class=\"live\">{}</script>\n");
}

struct GrowingRun::Frames {
  std::optional<Start> start;
  std::vector<Frame> all;
};

GrowingRun::GrowingRun(fs::path folder) : folder_(std::move(folder)), frames_(std::make_unique<Frames>()) {}
GrowingRun::~GrowingRun() = default;

std::string GrowingRun::part(const std::string& summary, const std::string& history, const std::vector<double>& times) {
  Json head;
  head["name"] = fs::weakly_canonical(folder_).filename().string();
  head["summary"] = Json::parse(summary);
  head["history"] = Json::parse(history);
  head["times"] = times;
  head["colours"] = colours();
  if (!frames_->start) frames_->start.emplace(VtuFile(frame_path(folder_, "blocks", 0)), held_blocks(head["summary"]));
  while (frames_->all.size() < times.size())
    frames_->all.push_back(read_frame(folder_, frames_->all.size(), &*frames_->start));
  const std::string data = pack_frames(*frames_->start, frames_->all, &head);
  return Json{{"head", head}, {"data", data}}.dump(-1, ' ', false, Json::error_handler_t::replace);
}

fs::path write_report(const std::vector<fs::path>& folders, const OnFrame& on_frame) {
  require_report_library();
  const fs::path path = page_in(folders.front());
  std::string runs, title;
  for (const fs::path& folder : folders) {
    const Part part = part_of(folder, on_frame);
    title += fmt::format("{}{}", title.empty() ? "" : " | ", part.head.at("name").get<std::string>());
    runs += run_scripts(part);
  }
  write_file(path, page_text(title, runs));
  return path;
}

fs::path write_motion_report(const fs::path& vtu, const std::string& title, const std::vector<ShownMotion>& motions,
                             bool one_way) {
  const VtuFile file(vtu);
  const Start start(file, {});
  std::vector<Frame> frames;
  Json head = {{"name", title}, {"summary", {{"title", title}, {"one_way", one_way}}}, {"labels", Json::array()}};
  head["colours"] = colours();
  head["times"] = Json::array();
  for (const ShownMotion& motion : motions) {
    Frame& frame = frames.emplace_back();
    frame.displacement = vectors_at(start.surface.vertex, file.read<float>(motion.array, VtkRows::point, 3));
    float largest = 0.0F;  // shapes of modes have no scale
    for (std::size_t i = 0; i < frame.displacement.size(); i += 3) {
      const auto u = at(frame.displacement, i / 3);
      largest = std::max(largest, std::hypot(u[0], u[1], u[2]));
    }
    for (float& u : frame.displacement) u = largest > 0.0F ? u / largest : 0.0F;
    head["labels"].push_back(motion.label), head["times"].push_back(frames.size() - 1);
  }
  const std::string data = pack_frames(start, frames, &head);
  const fs::path path = page_in(vtu.parent_path());
  write_file(path, page_text(title, run_scripts({head, data})));
  return path;
}

}  // namespace quoin
