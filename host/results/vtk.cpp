#include "results/vtk.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <optional>
#include <set>

#include "base/attempt.h"
#include "members/members.h"
#include "results/joint_table.h"
#include "results/parted_joints.h"
#include "results/vtk_file.h"
#include "step/collect.h"
#include "step/large_motion.h"
#include "step/results.h"

namespace quoin {

namespace {

constexpr std::uint8_t kVtkVertex = 1, kVtkLine = 3, kVtkPolygon = 7, kVtkQuad = 9, kVtkTetrahedron = 10,
                       kVtkHexahedron = 12;
constexpr const char* kStressComponents =
    " ComponentName0=\"xx\" ComponentName1=\"yy\" ComponentName2=\"zz\" ComponentName3=\"xy\" ComponentName4=\"yz\" "
    "ComponentName5=\"zx\"";
constexpr const char* kTractionComponents =
    " ComponentName0=\"sigma\" ComponentName1=\"tau_s\" ComponentName2=\"tau_t\"";

// First arrays of every grid.
enum : std::size_t { kPosition, kConnectivity, kOffsets, kTypes, kFirstField };

std::vector<VtkArray> arrays_of_grid() {
  return {{"Points", "position", kVtkType<float>, 3},
          {"Cells", "connectivity", kVtkType<std::int64_t>, 1, VtkRows::corner},
          {"Cells", "offsets", kVtkType<std::int64_t>, 1, VtkRows::cell},
          {"Cells", "types", kVtkType<std::uint8_t>, 1, VtkRows::cell}};
}

// Rows of the arrays of a grid, as bytes. Cells count corners, and offsets, as if these rows were the first ones.
class Rows {
 public:
  explicit Rows(std::size_t arrays = 0) : bytes_(arrays) {}
  template <class T>
  void add(std::size_t array, T value) {
    bytes_[array].append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void add(std::size_t array, const Vec3& v) {
    for (const double x : v) add(array, static_cast<float>(x));
  }
  void add_corner(std::int64_t point) { add(kConnectivity, point); }
  void end_cell(std::uint8_t type) {
    add(kOffsets, static_cast<std::int64_t>(corners()));
    add(kTypes, type);
  }
  std::uint64_t points() const { return bytes_[kPosition].size() / (3 * sizeof(float)); }
  std::uint64_t corners() const { return bytes_[kConnectivity].size() / sizeof(std::int64_t); }
  std::size_t arrays() const { return bytes_.size(); }

  // Renumbers corners and offsets for a file with points and corners before these rows.
  void move_behind(std::uint64_t points_before, std::uint64_t corners_before) {
    shift(bytes_[kConnectivity], points_before), shift(bytes_[kOffsets], corners_before);
  }
  void append_to(VtkFile& file) const {
    for (std::size_t i = 0; i < bytes_.size(); ++i) file.append(i, bytes_[i]);
  }

  std::string packed() const {
    std::string all;
    for (const std::string& bytes : bytes_) {
      const std::uint64_t size = bytes.size();
      all.append(reinterpret_cast<const char*>(&size), sizeof size);
      all += bytes;
    }
    return all;
  }
  static Rows unpacked(const std::string& all) {
    Rows rows;
    for (std::size_t place = 0; place < all.size();) {
      std::uint64_t size = 0;
      std::memcpy(&size, all.data() + place, sizeof size);
      rows.bytes_.push_back(all.substr(place + sizeof size, size));
      place += sizeof size + size;
    }
    return rows;
  }

 private:
  static void shift(std::string& bytes, std::uint64_t by) {
    for (std::size_t place = 0; place < bytes.size(); place += sizeof by) {
      std::uint64_t value = 0;
      std::memcpy(&value, bytes.data() + place, sizeof value);
      value += by;
      std::memcpy(bytes.data() + place, &value, sizeof value);
    }
  }
  std::vector<std::string> bytes_;
};

// ---- Blocks --------------------------------------------------------------------------------------------------------

enum BlockField : std::size_t { kDisplacement = kFirstField, kStress, kBlock, kUnit, kCourse, kBlockArrays };

std::vector<VtkArray> arrays_of_blocks() {
  std::vector<VtkArray> arrays = arrays_of_grid();
  arrays.push_back({"PointData", "displacement_m", kVtkType<float>, 3});
  arrays.push_back({"CellData", "stress_Pa", kVtkType<float>, 6, VtkRows::cell, kStressComponents});
  for (const char* name : {"block", "unit", "course"})
    arrays.push_back({"CellData", name, kVtkType<std::int32_t>, 1, VtkRows::cell});
  return arrays;
}

// Cells of a block: a hexahedron for a rigid brick, faces of other rigid blocks, zones of deformable ones.
VtkSizes sizes_of_block(const Simulation& simulation, int block) {
  const BlockSize size = block_size(simulation, block);
  if (size.zones > 0) return {size.gridpoints, size.zones, 4 * size.zones};
  if (!simulation.large_motion()) return {size.gridpoints, 1, 8};
  return {size.gridpoints, size.faces, size.face_corners};
}

void add_block(const Simulation& simulation, int b, Rows& rows) {
  const auto mesh = block_mesh(simulation, b);
  const auto first = static_cast<std::int64_t>(rows.points());
  for (const Vec3& p : mesh.gridpoint) rows.add(kPosition, p);
  for (const Vec3& u : block_displacement(simulation, b)) rows.add(kDisplacement, u);
  const auto add_cell = [&](const auto& corners, std::uint8_t type) {
    for (const int corner : corners) rows.add_corner(first + corner);
    rows.end_cell(type);
    rows.add(kBlock, std::int32_t{b}), rows.add(kUnit, std::int32_t{mesh.unit});
    rows.add(kCourse, std::int32_t{mesh.course});
  };
  for (const auto& zone : mesh.zone) add_cell(zone, kVtkTetrahedron);
  for (const auto& tensor : block_stress(simulation, b)) {
    for (const double s : tensor) rows.add(kStress, static_cast<float>(s));
  }
  if (!mesh.zone.empty()) return;
  if (!simulation.large_motion())
    add_cell(std::array{0, 1, 3, 2, 4, 5, 7, 6}, kVtkHexahedron);
  else
    for (const auto& face : mesh.face) add_cell(face, kVtkPolygon);
  for (std::uint64_t i = 0; i < 6 * sizes_of_block(simulation, b).cells; ++i) rows.add(kStress, 0.0F);
}

// ---- Joints --------------------------------------------------------------------------------------------------------

enum JointField : std::size_t {
  kMeanDisplacement = kFirstField,
  kTraction,
  kNormal,
  kShearAxis,
  kArea,
  kBlockA,
  kBlockB,
  kOpening,
  kSlip,
  kDamageTension,
  kDamageShear,
  kClosure,
  kFamily,
  kCondition,
  kCrack,
  kFirstState
};

// Names of state variables of all laws.
std::vector<std::string> state_ids(const Simulation& simulation) {
  std::set<std::string> ids;
  for (const ContactFamily& f : simulation.model().families) {
    const quoin_law& law = f.material->api();
    for (uint64_t s = 0; s < law.state_count; ++s) {
      if (keeps_state(simulation, law.states[s]->id)) ids.insert(law.states[s]->id);
    }
  }
  return {ids.begin(), ids.end()};
}

std::vector<VtkArray> arrays_of_joints(const Simulation& simulation, const std::vector<std::string>& states) {
  std::vector<VtkArray> arrays = arrays_of_grid();
  const auto add = [&](const char* name, const char* type, int components = 1, const char* named = "") {
    arrays.push_back({"PointData", name, type, components, VtkRows::point, named});
  };
  add("displacement_m", kVtkType<float>, 3);
  add("traction_Pa", kVtkType<float>, 3, kTractionComponents);
  add("normal", kVtkType<float>, 3), add("shear_axis", kVtkType<float>, 3);
  add("area_m2", kVtkType<float>);
  add("block_a", kVtkType<std::int32_t>), add("block_b", kVtkType<std::int32_t>);
  for (const char* name : {"opening_m", "slip_m", "damage_tension", "damage_shear", "plastic_closure_m"})
    add(name, kVtkType<float>);
  for (const char* name : {"family", "condition", "crack"}) add(name, kVtkType<std::int32_t>);
  for (const std::string& id : states) arrays.push_back({"PointData", "state_" + id, kVtkType<float>});
  if (simulation.large_motion()) add("gap_m", kVtkType<float>, 3);  // must be the last array
  return arrays;
}

// Adds a point without the law's state variables.
void add_point(const Simulation& simulation, const JointPoint& p, Rows& rows) {
  const auto number = [&](std::size_t field, double value) { rows.add(field, static_cast<float>(value)); };
  const auto code = [&](std::size_t field, auto value) { rows.add(field, static_cast<std::int32_t>(value)); };
  if (simulation.large_motion()) rows.add_corner(static_cast<std::int64_t>(rows.points())), rows.end_cell(kVtkVertex);
  rows.add(kPosition, p.contact.position);
  rows.add(kMeanDisplacement, p.displacement);
  rows.add(kTraction, p.contact.traction);
  rows.add(kNormal, p.contact.normal);
  rows.add(kShearAxis, p.contact.s);
  number(kArea, p.contact.area);
  code(kBlockA, p.contact.block_a), code(kBlockB, p.contact.block_b);
  number(kOpening, p.opening), number(kSlip, p.slip);
  number(kDamageTension, p.damage_tension), number(kDamageShear, p.damage_shear);
  number(kClosure, p.closure);
  code(kFamily, p.contact.family), code(kCondition, p.contact.condition), code(kCrack, p.crack);
  if (simulation.large_motion()) rows.add(rows.arrays() - 1, p.gap);
}

// Adds the points of a range. Quads are added separately, and not in large motion.
void add_points(const Simulation& simulation, const Surfaces& surfaces, const std::vector<std::string>& states,
                const PointRange& range, bool own_alone, Rows& rows) {
  const std::vector<JointPoint> points = surfaces.joint_points(simulation, range, own_alone);
  for (const JointPoint& p : points) add_point(simulation, p, rows);
  for (std::size_t k = 0; k < states.size() && !points.empty(); ++k) {
    const std::vector<double> column = law_state(simulation, states[k], range);
    for (const JointPoint& p : points)
      rows.add(kFirstState + k, static_cast<float>(column[static_cast<std::size_t>(p.contact.index - range.first)]));
  }
}

// Adds points of joints that begin at these blocks, whose blocks have parted.
void add_parted_points(const Simulation& simulation, const std::vector<std::string>& states, const ResultRun& run,
                       Rows& rows) {
  for (const PartedPoint& p : parted_points(simulation, run.first, run.end)) {
    add_point(simulation, p.joint, rows);
    const Law& law = simulation.model().families[static_cast<std::size_t>(p.joint.contact.family)].material->law();
    for (std::size_t k = 0; k < states.size(); ++k) {
      const int state = law.state_index(states[k]);
      rows.add(kFirstState + k,
               state < 0 ? std::nanf("") : static_cast<float>(p.state[static_cast<std::size_t>(state)]));
    }
  }
}

// ---- Members -------------------------------------------------------------------------------------------------------

// Writes ties and strips as lines, floors as quadrilaterals, in their current places.
void write_members(const std::filesystem::path& path, const members::Members& members, bool compressed) {
  std::vector<VtkArray> arrays = arrays_of_grid();
  for (const char* name : {"force_N", "plastic_m", "moment_Nm", "shear_N_per_m", "plastic_shear"})
    arrays.push_back({"CellData", name, kVtkType<float>, 1, VtkRows::cell});
  for (const char* name : {"kind", "member", "broken"})
    arrays.push_back({"CellData", name, kVtkType<std::int32_t>, 1, VtkRows::cell});
  Rows rows(arrays.size());
  std::size_t cells = 0;
  const auto add = [&](std::span<const geometry::Vector> corners, std::uint8_t shape,
                       const std::array<double, 5>& values, const std::array<int, 3>& numbers) {
    const auto first = static_cast<std::int64_t>(rows.points());
    for (const geometry::Vector& corner : corners) rows.add(kPosition, geometry::array(corner));
    for (std::size_t k = 0; k < corners.size(); ++k) rows.add_corner(first + static_cast<std::int64_t>(k));
    rows.end_cell(shape);
    std::size_t field = kFirstField;
    for (const double value : values) rows.add(field++, static_cast<float>(value));
    for (const int value : numbers) rows.add(field++, static_cast<std::int32_t>(value));
    ++cells;
  };
  for (const members::Line& line : members.lines())
    add(std::array{line.from, line.to}, kVtkLine, {line.force, line.plastic, line.moment, 0.0, 0.0},
        {line.kind, line.member, static_cast<int>(line.broken)});
  for (std::size_t f = 0; f < members.floors().size(); ++f) {
    for (const members::Floor::Panel& panel : members.floors()[f].panels())
      add(panel.corner, kVtkQuad, {0.0, 0.0, 0.0, panel.shear, panel.plastic},
          {members::kFloor, static_cast<int>(f), 0});
  }
  VtkFile file(path, arrays, {rows.points(), cells, rows.corners()}, compressed);
  rows.append_to(file);
  file.finish();
}

std::filesystem::path members_file(const std::filesystem::path& folder, size_t frame) {
  return folder / fmt::format("members_{:04}.vtu", frame);
}

const members::Members* members_of(const Simulation& simulation) {
  return simulation.large_motion() ? simulation.large_motion()->held_by.members.get() : nullptr;
}

// ---- Files ---------------------------------------------------------------------------------------------------------

constexpr std::array kKinds{"blocks", "joints"};  // kinds of file that may be in pieces

std::string piece_name(const char* kind, size_t frame, int rank) {
  return fmt::format("{}_{:04}_r{}.vtu", kind, frame, rank);
}

// A file to which rows are appended until it fails: other ranks send theirs all the same. Rows of a sink that is not
// open are dropped.
class Sink {
 public:
  explicit Sink(Attempt& attempt) : attempt_(attempt) {}
  void open(const std::filesystem::path& path, std::vector<VtkArray> arrays, const VtkSizes& sizes, bool compressed) {
    attempt_([&] { file_.emplace(path, std::move(arrays), sizes, compressed); });
  }
  // first_point: index in the file of the point that cells count from.
  void take(Rows rows, std::optional<std::uint64_t> first_point = {}) {
    if (!file_) return;
    attempt_([&] {
      const std::uint64_t points = rows.points(), corners = rows.corners();
      rows.move_behind(first_point.value_or(points_), corners_);
      rows.append_to(*file_);
      points_ += points, corners_ += corners;
    });
  }
  void finish() {
    if (file_) attempt_([&] { file_->finish(); });
  }

 private:
  Attempt& attempt_;
  std::optional<VtkFile> file_;
  std::uint64_t points_ = 0, corners_ = 0;
};

using Run = ResultRun;

// File and contents of a frame.
struct Target {
  std::filesystem::path path;
  bool compressed = false;
  bool piece = false;    // only the blocks of this rank
  bool written = false;  // whether this rank writes it; else it only sends rows to rank 0
};

void write_blocks(const Simulation& simulation, const Target& target, Attempt& attempt) {
  Sink sink(attempt);
  const std::vector<Run> runs = runs_of_blocks(simulation);
  VtkSizes sizes;
  for (const Run& run : runs) {
    for (int b = run.first; b < run.end && target.written; ++b) {
      if (!target.piece || owns_block(simulation, b)) sizes += sizes_of_block(simulation, b);
    }
  }
  if (target.written) sink.open(target.path, arrays_of_blocks(), sizes, target.compressed);
  const auto rows_of = [&](const Run& run) {
    Rows rows(kBlockArrays);
    for (int b = run.first; b < run.end; ++b) add_block(simulation, b, rows);
    return rows;
  };
  if (target.piece) {
    for (const Run& run : runs) {
      if (owns_block(simulation, run.first)) sink.take(rows_of(run));
    }
  } else {
    collect_at_first(
        simulation, runs, [&](const Run& run) { return rows_of(run).packed(); },
        [&](const std::string& rows) { sink.take(Rows::unpacked(rows)); });
  }
  if (target.written) sink.finish();
}

void write_joints(const Simulation& simulation, const Surfaces& surfaces, const Target& target, Attempt& attempt) {
  Sink sink(attempt);
  const std::vector<std::string> states = state_ids(simulation);
  const std::size_t arrays = arrays_of_joints(simulation, states).size();
  const bool quads = !simulation.large_motion();
  const auto points_of = [&](const Run& run) {
    Rows rows(arrays);
    add_points(simulation, surfaces, states, {run.first, run.end}, target.piece, rows);
    return rows;
  };
  // place: index of a contact point in the file.
  const auto quads_of = [&](std::span<const Surfaces::Quad> some, const auto& place) {
    Rows rows(arrays);
    for (const Surfaces::Quad& quad : some) {
      for (const int corner : quad) rows.add_corner(place(corner));
      rows.end_cell(kVtkQuad);
    }
    return rows;
  };
  const auto parted_of = [&](const Run& run) {
    Rows rows(arrays);
    add_parted_points(simulation, states, run, rows);
    return rows;
  };
  const std::vector<Run> of_blocks = quads ? std::vector<Run>{} : runs_of_blocks(simulation);
  const auto count_parted = [&](const auto& is_here) {
    std::uint64_t count = 0;
    for (const Run& run : of_blocks) count += is_here(run) ? parted_of(run).points() : 0;
    return count;
  };
  constexpr std::uint64_t kAbsolute = 0;  // corners of quads are indices of points in the file
  const std::vector<Run> runs = runs_of_points(simulation);
  if (target.piece) {
    // Points of joints that begin at blocks of this rank, in their order.
    LaneVector<std::int32_t> place(static_cast<std::size_t>(simulation.point_count()));  // from 1; 0: of another rank
    std::int32_t next = 0;
    each_own_point(simulation, [&](std::int32_t point) { place[static_cast<std::size_t>(point)] = ++next; });
    std::vector<Surfaces::Quad> own;
    for (std::size_t i = 0; quads && i < surfaces.quads(simulation).size(); ++i) {
      const Surfaces::Quad& quad = surfaces.quads(simulation)[i];
      if (place[static_cast<std::size_t>(quad[0])] > 0) own.push_back(quad);
    }
    const auto is_own = [&](const Run& run) { return owns_block(simulation, run.first); };
    const std::uint64_t points = static_cast<std::uint64_t>(next) + count_parted(is_own);
    sink.open(target.path, arrays_of_joints(simulation, states),
              {points, quads ? own.size() : points, quads ? 4 * own.size() : points}, target.compressed);
    for (const Run& run : runs) sink.take(points_of(run));
    for (const Run& run : of_blocks) {
      if (is_own(run)) sink.take(parted_of(run));
    }
    sink.take(quads_of(own, [&](int point) { return std::int64_t{place[static_cast<std::size_t>(point)]} - 1; }),
              kAbsolute);
    sink.finish();
    return;
  }
  const std::vector<Run> of_joints = quads ? runs_of_joints(simulation) : std::vector<Run>{};
  const auto quads_in = [&](const Run& run) { return surfaces.quads_of_joints(simulation, run.first, run.end); };
  double more = static_cast<double>(count_parted([&](const Run& run) { return brings(simulation, run); }));
  for (const Run& run : of_joints) more += brings(simulation, run) ? static_cast<double>(quads_in(run).size()) : 0.0;
  const auto parted_or_quads = static_cast<std::uint64_t>(sum_brought(simulation, more));
  if (target.written) {
    const auto alive = static_cast<std::uint64_t>(simulation.point_count()), points = alive + parted_or_quads;
    sink.open(target.path, arrays_of_joints(simulation, states),
              quads ? VtkSizes{alive, parted_or_quads, 4 * parted_or_quads} : VtkSizes{points, points, points},
              target.compressed);
  }
  collect_at_first(
      simulation, runs, [&](const Run& run) { return points_of(run).packed(); },
      [&](const std::string& rows) { sink.take(Rows::unpacked(rows)); });
  collect_at_first(
      simulation, of_blocks, [&](const Run& run) { return parted_of(run).packed(); },
      [&](const std::string& rows) { sink.take(Rows::unpacked(rows)); });
  collect_at_first(
      simulation, of_joints,
      [&](const Run& run) { return quads_of(quads_in(run), [](int point) { return point; }).packed(); },
      [&](const std::string& rows) { sink.take(Rows::unpacked(rows), kAbsolute); });
  if (target.written) sink.finish();
}

// ---- Forces --------------------------------------------------------------------------------------------------------

// Writes one point per joint, at the centre of its compression.
void write_forces(const std::filesystem::path& path, const std::map<BlockPair, JointSum>& sums, bool compressed) {
  std::vector<VtkArray> arrays = arrays_of_grid();
  using Value = std::array<double, 3> JointSum::*;
  using Number = double JointSum::*;
  for (const char* name : {"force_N", "normal"}) arrays.push_back({"PointData", name, kVtkType<float>, 3});
  const auto number_of = [](const JointSum& sum, std::size_t k) {
    double along = 0.0, squares = 0.0;
    for (std::size_t c = 0; c < 3; ++c) along += sum.force[c] * sum.direction[c];
    for (std::size_t c = 0; c < 3; ++c) squares += std::pow(sum.force[c] - along * sum.direction[c], 2.0);
    constexpr Number kOthers[] = {&JointSum::eccentricity, &JointSum::area, &JointSum::opening, &JointSum::slip,
                                  &JointSum::damage};
    return k == 0 ? along : k == 1 ? std::sqrt(squares) : sum.*kOthers[k - 2];
  };
  constexpr const char* kNumbers[] = {"normal_force_N", "shear_force_N", "eccentricity", "area_m2",
                                      "opening_m",      "slip_m",        "damage"};
  for (const char* name : kNumbers) arrays.push_back({"PointData", name, kVtkType<float>});
  for (const char* name : {"crack", "block_a", "block_b"})
    arrays.push_back({"PointData", name, kVtkType<std::int32_t>});
  Rows rows(arrays.size());
  for (const auto& [pair, sum] : sums) {
    rows.add_corner(static_cast<std::int64_t>(rows.points())), rows.end_cell(kVtkVertex);
    std::size_t field = kPosition;
    rows.add(field, sum.place), field = kFirstField;
    for (const Value value : {&JointSum::force, &JointSum::direction}) rows.add(field++, sum.*value);
    for (std::size_t k = 0; k < std::size(kNumbers); ++k) rows.add(field++, static_cast<float>(number_of(sum, k)));
    for (const std::int32_t code : {std::int32_t{sum.crack}, pair.first, pair.second}) rows.add(field++, code);
  }
  VtkFile file(path, arrays, {sums.size(), sums.size(), sums.size()}, compressed);
  rows.append_to(file);
  file.finish();
}

}  // namespace

double frame_bytes(const Simulation& simulation, const Surfaces& surfaces) {
  constexpr double kHeads = 10000.0;
  VtkSizes of_blocks;
  for (int b = 0; b < simulation.block_count(); ++b) of_blocks += sizes_of_block(simulation, b);
  double bytes = kHeads;
  const auto add = [&](const std::vector<VtkArray>& arrays, const VtkSizes& sizes) {
    for (const VtkArray& array : arrays) bytes += static_cast<double>(array.bytes(sizes));
  };
  add(arrays_of_blocks(), of_blocks);
  // With ranks, the number of quads per point is that of this rank's points.
  const auto points = static_cast<std::uint64_t>(simulation.point_count());
  VtkSizes of_joints{points, points, points};
  if (!simulation.large_motion()) {
    double here = 0.0;
    for (const ContactChunk& chunk : simulation.model().chunks) {
      const auto index = static_cast<int>(&chunk - simulation.model().chunks.data());
      here += simulation.model().has_laid_out(index) ? chunk.point_count : 0;
    }
    const double share = here > 0.0 ? static_cast<double>(points) / here : 0.0;
    of_joints.cells = static_cast<std::uint64_t>(share * static_cast<double>(surfaces.quads(simulation).size()));
    of_joints.corners = 4 * of_joints.cells;
  }
  add(arrays_of_joints(simulation, state_ids(simulation)), of_joints);
  return bytes;
}

VtkSeries::VtkSeries(std::filesystem::path folder, const Surfaces& surfaces, std::vector<double> before,
                     bool compressed, Pieces pieces)
    : folder_(std::move(folder)),
      surfaces_(surfaces),
      times_(std::move(before)),
      compressed_(compressed),
      pieces_(pieces) {}

void VtkSeries::add_frame(const Simulation& simulation) { add(simulation, false); }
void VtkSeries::add_piece(const Simulation& simulation) { add(simulation, pieces_.count > 1); }

void VtkSeries::add(const Simulation& simulation, bool piece) {
  const size_t frame = times_.size();
  Attempt attempt;
  for (const char* kind : kKinds) {
    const bool blocks = kind == kKinds[0];
    const std::string name = piece ? piece_name(kind, frame, pieces_.rank) : fmt::format("{}_{:04}.vtu", kind, frame);
    const Target target{folder_ / name, compressed_, piece, !attempt.failed()};
    if (blocks)
      write_blocks(simulation, target, attempt);
    else
      write_joints(simulation, surfaces_, target, attempt);
    if (!blocks && !piece)
      attempt([&] {
        write_forces(folder_ / fmt::format("forces_{:04}.vtu", frame), joint_sums(VtuFile(target.path)), compressed_);
      });
    if (!piece || pieces_.rank > 0) continue;
    std::vector<std::string> all;
    for (int r = 0; r < pieces_.count; ++r) all.push_back(piece_name(kind, frame, r));
    attempt([&] {
      write_vtk_index(folder_ / fmt::format("{}_{:04}.pvtu", kind, frame),
                      blocks ? arrays_of_blocks() : arrays_of_joints(simulation, state_ids(simulation)), all);
    });
  }
  if (const members::Members* const members = pieces_.rank == 0 ? members_of(simulation) : nullptr)
    attempt([&] { write_members(members_file(folder_, frame), *members, compressed_); });
  attempt.rethrow();
  times_.push_back(simulation.time());
}

void VtkSeries::leave_out(const Simulation& simulation) {
  if (pieces_.count <= 1) collect_frame(simulation, surfaces_);
}

void collect_frame(const Simulation& simulation, const Surfaces& surfaces) {
  Attempt nothing;
  write_blocks(simulation, {}, nothing);
  write_joints(simulation, surfaces, {}, nothing);
}

void VtkSeries::finish() const {
  write_collection(folder_, "blocks", times_);
  write_collection(folder_, "joints", times_);
  if (pieces_.count <= 1) write_collection(folder_, "forces", times_);
  if (!times_.empty() && std::filesystem::exists(members_file(folder_, 0)))
    write_collection(folder_, "members", times_);
}

}  // namespace quoin
