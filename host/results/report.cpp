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
#include "results/read_vtu.h"
#include "results/report_parts.h"

namespace quoin {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;
using Triangle = std::array<std::int32_t, 3>;

constexpr std::uint8_t kPolygon = 7, kTetrahedron = 10, kHexahedron = 12;
constexpr double kSharp = 0.94;  // cosine of the angle between two triangles from which on their edge is drawn

// Arrays one after the other, and where each of them is.
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
  // Compressed by zlib, in base64.
  std::string text() const {
    uLongf size = compressBound(bytes_.size());
    std::string packed(size, '\0');
    // As small as by the best one, which takes five times as long.
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

// Values over all frames in few bits: what is stored times `step`, plus `lower`, is the value.
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

// The surface of all blocks as triangles of the file's points, of which it keeps those on the surface.
struct Surface {
  std::vector<std::uint32_t> vertex;  // of the file, by vertex of the surface
  std::vector<Triangle> triangle;     // of vertices of the surface
  std::vector<std::uint32_t> edge;    // pairs of these: sharp edges
  std::vector<std::int32_t> block;    // by vertex
  std::set<std::int32_t> beams;       // rigid blocks beside the masonry, on the lattice
};

std::vector<Triangle> triangles_of(const VtuFile& blocks) {
  const auto connectivity = blocks.read<std::int64_t>("connectivity"), offsets = blocks.read<std::int64_t>("offsets");
  const auto types = blocks.read<std::uint8_t>("types");
  std::map<Triangle, std::pair<int, Triangle>> faces;  // of tetrahedra, by their sorted corners: how often, as it is
  std::vector<Triangle> result;
  for (std::size_t c = 0; c < types.size(); ++c) {
    const auto first = static_cast<std::size_t>(c == 0 ? 0 : offsets[c - 1]);
    const auto corner = [&](int k) {
      return static_cast<std::int32_t>(connectivity[first + static_cast<std::size_t>(k)]);
    };
    if (types[c] == kTetrahedron) {
      for (const auto& f : {std::array{0, 2, 1}, std::array{0, 1, 3}, std::array{1, 2, 3}, std::array{0, 3, 2}}) {
        const Triangle face{corner(f[0]), corner(f[1]), corner(f[2])};
        Triangle sorted = face;
        std::sort(sorted.begin(), sorted.end());
        auto& seen = faces[sorted];
        ++seen.first, seen.second = face;
      }
    } else if (types[c] == kHexahedron) {
      constexpr int kQuads[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
      for (const auto& q : kQuads) {
        result.push_back({corner(q[0]), corner(q[1]), corner(q[2])});
        result.push_back({corner(q[0]), corner(q[2]), corner(q[3])});
      }
    } else if (types[c] == kPolygon) {
      const int corners = static_cast<int>(offsets[c]) - static_cast<int>(first);
      for (int k = 2; k < corners; ++k) result.push_back({corner(0), corner(k - 1), corner(k)});
    }
  }
  for (const auto& [sorted, seen] : faces) {
    if (seen.first == 1) result.push_back(seen.second);
  }
  return result;
}

Surface surface_of(const VtuFile& blocks, const std::vector<float>& points) {
  Surface s;
  s.triangle = triangles_of(blocks);
  std::vector<std::int32_t> number(points.size() / 3, -1);
  for (const Triangle& t : s.triangle) {
    for (const std::int32_t p : t) number[static_cast<std::size_t>(p)] = 0;
  }
  for (std::size_t p = 0; p < number.size(); ++p) {
    if (number[p] < 0) continue;
    number[p] = static_cast<std::int32_t>(s.vertex.size());
    s.vertex.push_back(static_cast<std::uint32_t>(p));
  }
  std::map<std::pair<std::int32_t, std::int32_t>, std::vector<Eigen::Vector3f>> edges;  // normals beside them
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
  // Cells say which block they are of, and so which their corners are of.
  const auto connectivity = blocks.read<std::int64_t>("connectivity"), offsets = blocks.read<std::int64_t>("offsets");
  const auto block = blocks.read<std::int32_t>("block");
  std::vector<std::int32_t> of_point(points.size() / 3, -1);
  for (std::size_t c = 0, i = 0; c < offsets.size(); ++c) {
    for (; i < static_cast<std::size_t>(offsets[c]); ++i)
      of_point[static_cast<std::size_t>(connectivity[i])] = block[c];
  }
  for (const std::uint32_t p : s.vertex) s.block.push_back(of_point[p]);
  const auto types = blocks.read<std::uint8_t>("types");
  const auto unit = blocks.read<std::int32_t>("unit");
  for (std::size_t c = 0; c < types.size(); ++c) {
    if (types[c] == kHexahedron && unit[c] < 0) s.beams.insert(block[c]);
  }
  return s;
}

// By vertex of the surface: the file's point, where a run has gone over to large motion and numbers them anew.
std::vector<std::uint32_t> points_of(const VtuFile& blocks, const Surface& surface, const std::vector<float>& start) {
  const auto position = blocks.read<float>("position");
  const auto connectivity = blocks.read<std::int64_t>("connectivity"), offsets = blocks.read<std::int64_t>("offsets");
  const auto block = blocks.read<std::int32_t>("block");
  std::map<std::pair<std::int32_t, std::array<float, 3>>, std::uint32_t> found;
  for (std::size_t c = 0, i = 0; c < offsets.size(); ++c) {
    for (; i < static_cast<std::size_t>(offsets[c]); ++i) {
      const auto p = static_cast<std::size_t>(connectivity[i]);
      found[{block[c], at(position, p)}] = static_cast<std::uint32_t>(p);
    }
  }
  std::vector<std::uint32_t> points;
  for (std::size_t v = 0; v < surface.vertex.size(); ++v) {
    const auto place = found.find({surface.block[v], at(start, v)});
    points.push_back(place == found.end() ? surface.vertex[v] : place->second);
  }
  return points;
}

// At these points, from cells: the smallest principal stress (compression < 0), the mean of those around.
std::vector<float> stress_of(const VtuFile& blocks, const std::vector<std::uint32_t>& of_points, std::size_t points) {
  const auto stress = blocks.read<float>("stress_Pa");
  const auto connectivity = blocks.read<std::int64_t>("connectivity"), offsets = blocks.read<std::int64_t>("offsets");
  std::vector<double> sum(points, 0.0), count(points, 0.0);
  for (std::size_t c = 0, i = 0; c < offsets.size(); ++c) {
    const float* t = stress.data() + 6 * c;  // xx yy zz xy yz zx
    Eigen::Matrix3d tensor;
    tensor << t[0], t[3], t[5], t[3], t[1], t[4], t[5], t[4], t[2];
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    const double least = solver.computeDirect(tensor, Eigen::EigenvaluesOnly).eigenvalues()[0];
    for (; i < static_cast<std::size_t>(offsets[c]); ++i) {
      sum[static_cast<std::size_t>(connectivity[i])] += least;
      count[static_cast<std::size_t>(connectivity[i])] += 1.0;
    }
  }
  std::vector<float> result;
  for (const std::uint32_t p : of_points) result.push_back(static_cast<float>(sum[p] / std::max(1.0, count[p])));
  return result;
}

// What the joints say at the vertices of their blocks: the largest of the points next to each.
struct JointValues {
  std::vector<float> damage, opening, slip;
};

// Of those blocks that show what their joints say.
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
  // Index of the vertex of the block that is closest to the place; none: the block has no surface.
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

JointValues joint_values(const VtuFile& joints, const VerticesOfBlocks& vertices, const std::vector<float>& positions) {
  const auto place = joints.read<float>("position"), opening = joints.read<float>("opening_m"),
             slip = joints.read<float>("slip_m"), tension = joints.read<float>("damage_tension"),
             shear = joints.read<float>("damage_shear");
  const auto block_a = joints.read<std::int32_t>("block_a"), block_b = joints.read<std::int32_t>("block_b");
  JointValues values;
  for (auto* column : {&values.damage, &values.opening, &values.slip}) column->assign(positions.size() / 3, 0.0F);
  for (std::size_t i = 0; i < opening.size(); ++i) {
    for (const std::int32_t block : {block_a[i], block_b[i]}) {
      const auto v = vertices.nearest(block, at(place, i), positions);
      if (!v) continue;
      const auto raise = [&](std::vector<float>& column, float value) {
        if (value > column[*v]) column[*v] = value;
      };
      raise(values.damage, std::max(tension[i], shear[i]));
      raise(values.opening, opening[i]);
      raise(values.slip, std::abs(slip[i]));
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

// Edges that only one quad has: where a joint comes to the surface.
std::vector<std::uint32_t> rim_of(const VtuFile& joints) {
  const auto connectivity = joints.read<std::int64_t>("connectivity"), offsets = joints.read<std::int64_t>("offsets");
  std::map<std::pair<std::int64_t, std::int64_t>, int> edges;
  for (std::size_t c = 0; c < offsets.size(); ++c) {
    const std::size_t first = c == 0 ? 0 : static_cast<std::size_t>(offsets[c - 1]);
    const auto corners = static_cast<std::size_t>(offsets[c]) - first;
    for (std::size_t k = 0; k < corners && corners > 2; ++k) {
      const std::int64_t a = connectivity[first + k], b = connectivity[first + (k + 1) % corners];
      ++edges[std::minmax(a, b)];
    }
  }
  std::vector<std::uint32_t> rim;
  for (const auto& [ends, count] : edges) {
    if (count != 1) continue;
    rim.push_back(static_cast<std::uint32_t>(ends.first));
    rim.push_back(static_cast<std::uint32_t>(ends.second));
  }
  return rim;
}

// history.csv: columns of numbers, by name.
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
  while (std::getline(text, line)) {
    const std::vector<std::string> cells = cells_of(line);
    for (std::size_t c = 0; c < std::min(names.size(), cells.size()); ++c) {
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

// A run as the page reads it: {head: JSON, data: base64}.
struct Part {
  Json head;
  std::string data;
};

Part part_of(const fs::path& folder, const OnFrame& on_frame) {
  std::error_code error;
  if (!fs::exists(folder / "summary.json", error))
    throw Error(Exit::bad_input, fmt::format("{}: no results here (summary.json is missing); give the folder of a run "
                                             "that has ended, as quoin run SCENE.toml --out {} makes it",
                                             folder.string(), folder.string()));
  if (!fs::exists(folder / "blocks.pvd", error))
    throw Error(Exit::bad_input, fmt::format("{}: the run wrote no frames (blocks.pvd is missing); run it again with "
                                             "output.frames = 20",
                                             folder.string()));
  const std::vector<double> times = read_collection(folder, "blocks");
  if (times.empty()) throw Error(Exit::bad_input, fmt::format("{}: has no frames", (folder / "blocks.pvd").string()));
  Part part;
  part.head["name"] = fs::weakly_canonical(folder).filename().string();
  part.head["summary"] = Json::parse(read_input_file((folder / "summary.json").string()));
  part.head["history"] = read_history(folder / "history.csv");
  part.head["times"] = times;

  const VtuFile first(frame_path(folder, "blocks", 0));
  const auto points = first.read<float>("position");
  const Surface surface = surface_of(first, points);
  const std::vector<float> start = vectors_at(surface.vertex, points);
  const VerticesOfBlocks vertices(surface);

  struct Frame {
    std::vector<float> displacement, stress, rim, points, points_moved;
    JointValues joints;
    std::vector<std::uint8_t> crack, point_crack;
  };
  std::vector<Frame> frames;
  std::vector<std::uint32_t> rim;
  std::vector<float> rim_start;
  Quantised moved, rim_moved, stress, opening, slip, damage{0.0, 1.0};
  for (std::size_t f = 0; f < times.size(); ++f) {
    if (on_frame) on_frame(folder, f + 1, times.size());
    const VtuFile blocks(frame_path(folder, "blocks", f)), joints(frame_path(folder, "joints", f));
    Frame& frame = frames.emplace_back();
    const auto displacement = blocks.read<float>("displacement_m");
    if (displacement.size() != points.size())
      throw Error(Exit::bad_input,
                  fmt::format("{}: has {} points, the first frame {}; run the scene again",
                              frame_path(folder, "blocks", f).string(), displacement.size() / 3, points.size() / 3));
    const auto vertex = blocks.read<float>("position") == points ? surface.vertex : points_of(blocks, surface, start);
    frame.displacement = vectors_at(vertex, displacement);
    frame.stress = stress_of(blocks, vertex, points.size() / 3);
    const std::vector<std::uint32_t> rim_now = rim_of(joints);
    const auto place = joints.read<float>("position"), carried = joints.read<float>("displacement_m");
    const auto crack = joints.read<std::int32_t>("crack"), block_a = joints.read<std::int32_t>("block_a"),
               block_b = joints.read<std::int32_t>("block_b");
    // Joints of blocks of any shape are points, given where they stand: beside the vertices of now.
    std::vector<float> standing = start;
    for (std::size_t i = 0; rim_now.empty() && i < standing.size(); ++i) standing[i] += frame.displacement[i];
    frame.joints = joint_values(joints, vertices, standing);
    if (!rim_now.empty()) {
      if (f == 0 || rim.empty()) {
        rim = rim_now;
        for (const std::uint32_t p : rim) {
          for (const float x : at(place, p)) rim_start.push_back(x);
        }
      }
      for (const std::uint32_t p : rim) {
        if (p >= crack.size()) throw Error(Exit::bad_input, folder.string() + ": frames of different joints");
        for (const float x : at(carried, p)) frame.rim.push_back(x);
        frame.crack.push_back(static_cast<std::uint8_t>(crack[p]));
      }
    } else {
      for (std::size_t i = 0; i < crack.size(); ++i) {
        if (crack[i] == 0) continue;
        auto vertex_beside = vertices.nearest(block_a[i], at(place, i), standing);
        if (!vertex_beside) vertex_beside = vertices.nearest(block_b[i], at(place, i), standing);
        if (!vertex_beside) continue;
        for (std::size_t c = 0; c < 3; ++c) {
          const float came = frame.displacement[3 * *vertex_beside + c];
          frame.points.push_back(at(place, i)[c] - came);
          frame.points_moved.push_back(came);
        }
        frame.point_crack.push_back(static_cast<std::uint8_t>(crack[i]));
      }
    }
    moved.see(frame.displacement), rim_moved.see(frame.rim), stress.see(frame.stress);
    opening.see(frame.joints.opening), slip.see(frame.joints.slip);
  }

  Blob blob;
  blob.add("position", start);
  std::vector<std::uint32_t> corners;
  for (const Triangle& t : surface.triangle) corners.insert(corners.end(), t.begin(), t.end());
  blob.add("triangle", corners);
  blob.add("edge", surface.edge);
  blob.add("rim", rim_start);
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const auto name = [f](const char* what) { return fmt::format("{}{}", what, f); };
    const Frame& frame = frames[f];
    blob.add(name("moved"), moved.words(frame.displacement));
    blob.add(name("stress"), stress.bytes(frame.stress));
    blob.add(name("damage"), damage.bytes(frame.joints.damage));
    blob.add(name("opening"), opening.bytes(frame.joints.opening));
    blob.add(name("slip"), slip.bytes(frame.joints.slip));
    if (frame.rim.size() == rim_start.size()) blob.add(name("rim_moved"), rim_moved.words(frame.rim));
    blob.add(name("crack"), frame.crack);
    blob.add(name("points"), frame.points);
    blob.add(name("points_moved"), frame.points_moved);
    blob.add(name("point_crack"), frame.point_crack);
  }
  const auto range = [](const Quantised& q) { return Json{q.lower, q.upper}; };
  part.head["range"] = {{"stress", range(stress)},
                        {"damage", range(damage)},
                        {"opening", range(opening)},
                        {"slip", range(slip)},
                        {"moved", std::max(moved.upper, -moved.lower)},
                        {"rim_moved", std::max(rim_moved.upper, -rim_moved.lower)}};
  part.head["arrays"] = blob.arrays();
  part.data = blob.text();
  return part;
}

// JSON that no HTML parser takes for anything else.
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

// three.js, and what turns the model by mouse.
std::string three_js() {
  const char* given = std::getenv("QUOIN_THREE_JS");
  const fs::path folder = given ? given : "/usr/share/javascript/three";
  std::string text;
  for (const char* name : {"three.min.js", "examples/js/controls/OrbitControls.js"}) {
    std::error_code error;
    if (!fs::exists(folder / name, error))
      throw Error(Exit::bad_input, fmt::format("{}: not found: a report needs three.js to draw; install it with "
                                               "`apt-get install libjs-three`, or set QUOIN_THREE_JS to its folder",
                                               (folder / name).string()));
    constexpr std::string_view end = "</script";  // in a string of theirs: it would end ours
    const std::string script = read_input_file((folder / name).string());
    std::size_t from = 0;
    for (std::size_t at = 0; (at = script.find(end, from)) != std::string::npos; from = at + 1)
      text.append(script, from, at + 1 - from).append("\\");
    text.append(script, from).append("\n");
  }
  return text;
}

}  // namespace

fs::path write_report(const std::vector<fs::path>& folders, const OnFrame& on_frame) {
  const std::string library = three_js();
  std::string runs, title;
  for (const fs::path& folder : folders) {
    const Part part = part_of(folder, on_frame);
    title += fmt::format("{}{}", title.empty() ? "" : " | ", part.head.at("name").get<std::string>());
    runs += fmt::format(
        "<script type=\"application/json\" class=\"head\">{}</script>\n<script type=\"text/plain\" "
        "class=\"data\">{}</script>\n",
        json_in_page(part.head), part.data);
  }
  const fs::path path = folders.front() / "report.html";
  write_file(path, fmt::format("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{}</title>\n"
                               "<style>{}</style></head><body>\n{}{}<script>{}</script>\n<script>{}</script>\n"
                               "</body></html>\n",
                               escaped(title), kReportStyle, kReportBody, runs, library, kReportScript));
  return path;
}

}  // namespace quoin
