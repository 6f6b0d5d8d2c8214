#include "scene/to_bricks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "geometry/broad_phase.h"
#include "scene/brick_overlap.h"
#include "scene/driven.h"
#include "scene/generate_blocks.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

// Relative tolerances, over a length: of edges that are straight, and of faces that touch. The lattice requires the
// second.
constexpr double kStraight = 1e-9, kTouching = 1e-6;

// Reason why the lattice cannot have this scene. to_bricks() catches it.
struct Unfit {
  std::string why;
};
template <class... Args>
[[noreturn]] void unfit(fmt::format_string<Args...> text, Args&&... args) {
  throw Unfit{fmt::format(text, std::forward<Args>(args)...)};
}

// ---- Blocks --------------------------------------------------------------------------------------------------------

// Restores right angles that the digits of a rotation in degrees have lost.
Matrix without_rounding(Matrix turned) {
  for (Vector& row : turned.row) {
    for (int c = 0; c < 3; ++c) {
      if (std::abs(row[c] - std::round(row[c])) < kStraight) row[c] = std::round(row[c]);
    }
  }
  return turned;
}

std::string at_block(const Assembly& assembly, int i) { return "block " + label(assembly, i); }

std::vector<Brick> bricks_of(const Assembly& assembly) {
  std::vector<Brick> bricks;
  for (int i = 0; i < int(assembly.blocks.size()); ++i) {
    const Block& block = assembly.blocks[size_t(i)];
    const std::optional<Brick> brick = as_brick(assembly, i);
    if (!brick) unfit("{} is no box along the axes", at_block(assembly, i));
    if (block.fixed && !block.rigid)
      unfit("{} is fixed and deformable; the lattice holds rigid blocks only", at_block(assembly, i));
    bricks.push_back(*brick);
  }
  return bricks;
}

// ---- Joints --------------------------------------------------------------------------------------------------------

// Whether a gridline of a deformable brick is at x along an axis.
bool on_gridline(const Brick& brick, size_t axis, double x, double tolerance) {
  const double spacing = brick.size[axis] / brick.zones[axis];
  const double lines = (x - brick.origin[axis]) / spacing;
  return std::abs(lines - std::round(lines)) * spacing <= tolerance;
}

class JointFinder {
 public:
  JointFinder(const Assembly& assembly, const std::vector<Brick>& bricks) : assembly_(assembly), bricks_(bricks) {
    double least = 1e300;
    for (const Brick& brick : bricks) least = std::min(least, least_extent(brick));
    skin_ = assembly.contact.skin > 0.0 ? assembly.contact.skin : 0.05 * least;
    grid_ = kTouching * least;
  }

  std::vector<Joint> find() {
    std::vector<Box> boxes;
    for (const Brick& brick : bricks_) {
      const Vector margin = 0.5 * Vector{skin_, skin_, skin_};
      boxes.push_back({vector(brick.origin) - margin, vector(brick.origin) + vector(brick.size) + margin});
    }
    for (const Pair& pair : overlapping_pairs(boxes)) compare(pair.a, pair.b);
    if (found_.empty()) unfit("no two blocks touch");
    std::sort(found_.begin(), found_.end(), [](const Found& x, const Found& y) { return x.place < y.place; });
    std::vector<Joint> joints;
    for (const Found& f : found_) joints.push_back(f.joint);
    return joints;
  }

 private:
  struct Found {
    std::tuple<bool, long, long, long> place;  // a bed; y, z, x of the overlap's lower corner
    Joint joint;
  };

  std::string both(int a, int b) const {
    return fmt::format("blocks {} and {}", label(assembly_, a), label(assembly_, b));
  }

  void compare(int i, int j) {
    const Block &first = assembly_.blocks[size_t(i)], &second = assembly_.blocks[size_t(j)];
    if (first.is_support() && second.is_support()) return;
    const Overlap o = overlap_of(bricks_[size_t(i)], bricks_[size_t(j)]);
    const double tolerance = kTouching * std::min(least_extent(bricks_[size_t(i)]), least_extent(bricks_[size_t(j)]));
    size_t normal = 0;
    for (size_t c = 1; c < 3; ++c) {
      if (o.gap(c) > o.gap(normal)) normal = c;
    }
    const size_t s = (normal + 1) % 3, t = (normal + 2) % 3;
    if (o.gap(s) >= -tolerance || o.gap(t) >= -tolerance) return;  // side by side at an edge or a corner
    if (o.gap(normal) < -tolerance) unfit("{} overlap by {:.3g} m", both(i, j), -o.gap(normal));

    const bool in_order = bricks_[size_t(i)].origin[normal] < bricks_[size_t(j)].origin[normal];
    const int a = in_order ? i : j, b = in_order ? j : i;
    Vector along;
    along[int(normal)] = 1.0;
    const int family = assembly_.family_of ? assembly_.family_of({a, b, along}) : 0;
    if (family < 0) return;
    if (o.gap(normal) > tolerance)
      unfit("{} stand {:.3g} m apart, and may close the gap; on the lattice faces touch", both(i, j), o.gap(normal));
    for (const int side : {a, b}) {
      const Brick& brick = bricks_[size_t(side)];
      for (const size_t c : {s, t}) {
        if (brick.rigid || (on_gridline(brick, c, o.from[c], tolerance) && on_gridline(brick, c, o.to[c], tolerance)))
          continue;
        unfit("the joint of {} ends between two gridpoints of {}", both(i, j), label(assembly_, side));
      }
    }
    const Brick &below = bricks_[size_t(a)], &above = bricks_[size_t(b)];
    for (const size_t c : {s, t}) {
      if (below.rigid || above.rigid) continue;
      const double difference = below.size[c] / below.zones[c] - above.size[c] / above.zones[c];
      if (std::abs(difference) * below.zones[c] > tolerance)
        unfit("{} have zones of {:.4g} and {:.4g} m in their joint, whose gridpoints do not meet", both(i, j),
              below.size[c] / below.zones[c], above.size[c] / above.zones[c]);
    }
    if (below.rigid && above.rigid && assembly_.contact.point_spacing > 0.0)
      unfit(
          "contact.point_spacing asks for other points in the joints of rigid blocks than the lattice has: corners, or "
          "contact.cubic_points");
    const auto cell = [&](size_t c) { return std::lround(o.from[c] / grid_); };
    found_.push_back({{normal == 1, cell(1), cell(2), cell(0)}, {a, b, 2 * int(normal) + 1, family}});
  }

  const Assembly& assembly_;
  const std::vector<Brick>& bricks_;
  double skin_ = 0.0, grid_ = 0.0;  // m; coordinates closer than grid_ are the same
  std::vector<Found> found_;
};

// ---- Stages --------------------------------------------------------------------------------------------------------

class StageWriter {
 public:
  StageWriter(const Assembly& assembly, const std::vector<Brick>& bricks, const Scene& scene)
      : assembly_(assembly),
        bricks_(bricks),
        watched_(scene.output.monitor),
        file_(scene.file),
        stays_(scene.solver.large_motion == LargeMotion::never) {}

  Stage on_bodies(const Stage& given) const {
    const auto refuse = [&](const std::string& what) { unfit("stage '{}' {}", given.name, what); };
    Stage stage = given;
    stage.forces.clear(), stage.pressures.clear();
    if (const std::string acts = beyond_lattice(stage); !acts.empty()) refuse(acts);
    if (given.solver && damping_of(*given.solver).splits_motion()) refuse("has damping by block of its own");
    if (given.solver && damping_of(*given.solver).has_maxwell()) refuse("has maxwell_damping");
    if (stage.monitor.empty()) stage.monitor = watched_;
    if (!stage.monitor.empty())
      rigid(stage.monitor, given, "watches",
            given.monitor.empty() ? file_ + ": output.monitor" : given.source.text + ": monitor");
    std::set<std::string> controlled;
    for (const BodyControl& control : stage.controls) {
      const bool loads =
          std::all_of(control.kind.begin(), control.kind.end(), [](DofKind kind) { return kind == DofKind::free; });
      if (loads)
        find_blocks(assembly_, control.body, given.source.text);  // deformable ones can be loaded, too
      else
        rigid(control.body, given, "moves");
      controlled.insert(control.body);
      if (control.omega != Vec3{}) refuse(fmt::format("turns '{}'", control.body));
    }
    for (size_t i = 0; i < assembly_.blocks.size(); ++i) {
      if (!assembly_.blocks[i].fixed || controlled.contains(bricks_[i].body)) continue;
      stage.controls.push_back({});
      stage.controls.back().body = bricks_[i].body;
    }
    for (const PointForce& force : given.forces) {
      const Brick& brick = rigid(force.block, given, "pushes");
      BodyControl& control = control_of(force.block, stage);
      // An arm along the force counts, too, as soon as the block turns.
      Vector arm = vector(force.point) - centre_of(brick);
      if (stays_) arm = cross(arm, normalized(vector(force.force)));
      if (control.may_turn && norm(arm) > kStraight * least_extent(brick))
        refuse(fmt::format("pushes '{}', which may turn, beside its centre", force.block));
      add(vector(force.force), &control);
    }
    for (const FacePressure& pressure : given.pressures) {
      const Brick& brick = rigid(pressure.block, given, "presses");
      size_t axis = 0;
      for (size_t c = 1; c < 3; ++c) {
        if (std::abs(pressure.normal[c]) > std::abs(pressure.normal[axis])) axis = c;
      }
      if (!stays_ && control_of(pressure.block, stage).may_turn)
        refuse(fmt::format("presses a face of '{}', which may turn", pressure.block));
      const double area = brick.size[(axis + 1) % 3] * brick.size[(axis + 2) % 3];
      Vector force;
      force[int(axis)] = (pressure.normal[axis] > 0.0 ? -1.0 : 1.0) * pressure.pressure * area;
      add(force, &control_of(pressure.block, stage));
    }
    return stage;
  }

 private:
  static Vector centre_of(const Brick& brick) { return vector(brick.origin) + 0.5 * vector(brick.size); }

  // where: of the name, for messages; empty: the stage.
  const Brick& rigid(const std::string& name, const Stage& stage, const char* does,
                     const std::string& where = "") const {
    const Brick& brick =
        bricks_[size_t(find_blocks(assembly_, name, where.empty() ? stage.source.text : where).front())];
    if (!brick.rigid)
      unfit("stage '{}' {} '{}', a deformable block; on the lattice stages act on rigid ones", stage.name, does, name);
    return brick;
  }

  // Adds a force. The support carries its components along directions that are held.
  static void add(const Vector& force, BodyControl* control) {
    for (size_t c = 0; c < 3; ++c) {
      if (control->kind[c] == DofKind::free) control->force[c] += force[int(c)];
    }
  }

  const Assembly& assembly_;
  const std::vector<Brick>& bricks_;
  std::string watched_, file_;
  bool stays_;  // whether blocks never go over to large motion
};

// Names bodies after their blocks; a fixed block without a name has its label.
void name_bodies(const Assembly& assembly, std::vector<Brick>* bricks) {
  std::map<std::string, int> count;
  for (const Block& block : assembly.blocks) ++count[block.name];
  for (size_t i = 0; i < bricks->size(); ++i) {
    const Block& block = assembly.blocks[i];
    (*bricks)[i].name = block.name;
    (*bricks)[i].body = !block.name.empty() && count[block.name] == 1 ? block.name
                        : block.fixed                                 ? label(assembly, int(i))
                                                                      : "";
  }
}

std::string text_of(const BodyControl& control) {
  std::string text = fmt::format("{} {}", control.may_turn ? "turns" : "held", control.in_cycles);
  for (size_t c = 0; c < 3; ++c)
    text += control.kind[c] == DofKind::free ? fmt::format(" N {}", control.force[c])
                                             : fmt::format(" m/s {}", control.velocity[c]);
  return text;
}

// Where many bodies have controls, gives one name to those with equal ones in all stages, so that they share SIMD
// groups. Few keep their names, for monitors and for the columns of their reactions. Bodies without control or monitor
// have no name.
void share_names(std::vector<Stage>* stages, std::vector<Brick>* bricks) {
  constexpr size_t kFew = 12;                   // as many have columns of reactions
  std::map<std::string, std::string> controls;  // by body, of all stages
  for (size_t i = 0; i < stages->size(); ++i) {
    for (const BodyControl& control : (*stages)[i].controls)
      controls[control.body] += fmt::format("stage {} {};", i, text_of(control));
  }
  const bool few = controls.size() <= kFew;
  for (const Stage& stage : *stages) {
    if (!stage.monitor.empty()) controls[stage.monitor] += "watched as " + stage.monitor;
  }
  std::map<std::string, std::vector<std::string>> by_control;
  for (const Brick& brick : *bricks) {
    const auto found = controls.find(brick.body);
    if (found != controls.end()) by_control[(brick.rigid ? "rigid " : "loaded ") + found->second].push_back(brick.body);
  }
  std::map<std::string, std::string> shared;
  for (const auto& [control, bodies] : by_control) {
    for (const std::string& body : bodies)
      shared[body] = bodies.size() == 1 || few ? body : fmt::format("{} and {} more", bodies[0], bodies.size() - 1);
  }
  for (Brick& brick : *bricks) {
    const auto found = shared.find(brick.body);
    brick.body = found == shared.end() ? "" : found->second;
  }
  for (Stage& stage : *stages) {
    std::set<std::string> seen;
    for (BodyControl& control : stage.controls) control.body = shared.at(control.body);
    std::erase_if(stage.controls, [&](const BodyControl& control) { return !seen.insert(control.body).second; });
  }
}

OnLattice made_of(const Assembly& assembly, const Scene& scene) {
  if (assembly.contact.small_displacement == 0.0) unfit("large motion is asked for from the start");
  if (damping_of(scene.solver).impacts) unfit("solver.damping = \"{}\"", name_of(scene.solver.damping));
  OnLattice made{{}, scene};
  made.bricks.materials = assembly.materials;
  made.bricks.families = assembly.families;
  made.bricks.bricks = bricks_of(assembly);
  name_bodies(assembly, &made.bricks.bricks);
  auto& bricks = made.bricks.bricks;
  const bool zoned = std::any_of(bricks.begin(), bricks.end(), [](const Brick& b) { return !b.rigid; });
  for (size_t i = 0; i < bricks.size(); ++i) {
    bricks[i].beam = zoned && bricks[i].rigid;
    bricks[i].fixed = assembly.blocks[i].fixed, bricks[i].freed = assembly.blocks[i].freed;
  }
  made.bricks.joints = JointFinder(assembly, bricks).find();
  const StageWriter writer(assembly, bricks, scene);
  for (Stage& stage : made.scene.stages) stage = writer.on_bodies(stage);
  share_names(&made.scene.stages, &bricks);
  return made;
}

}  // namespace

std::optional<Brick> as_brick(const Assembly& assembly, int index) {
  const Block& block = assembly.blocks[size_t(index)];
  const ConvexPolyhedron& shape = assembly.shapes[size_t(block.shape)];
  const auto corner = brick_corners(shape);
  if (!corner || block.zoning) return std::nullopt;
  const Matrix turned = without_rounding(matrix(block.orientation));
  const auto along = [&](int bits) {  // from the first corner
    return turned * (shape.vertices[size_t((*corner)[size_t(bits)])] - shape.vertices[size_t((*corner)[0])]);
  };
  double longest = 0.0;
  for (int k = 0; k < 3; ++k) longest = std::max(longest, norm(along(1 << k)));

  Brick brick;
  std::array<int, 3> divisions{1, 1, 1};
  if (!block.rigid) divisions = block.divisions[0] > 0 ? block.divisions : brick_divisions(shape, block.zone_edge);
  int lowest = 0, turned_zones = 0;  // bits of the lowest corner, and its index among the block's gridpoints
  std::array<bool, 3> taken{};
  for (int k = 0; k < 3; ++k) {
    const Vector edge = along(1 << k);
    size_t axis = 0;
    for (size_t c = 1; c < 3; ++c) {
      if (std::abs(edge[int(c)]) > std::abs(edge[int(axis)])) axis = c;
    }
    if (taken[axis]) return std::nullopt;
    taken[axis] = true;
    brick.size[axis] = std::abs(edge[int(axis)]);
    brick.zones[axis] = divisions[size_t(k)];
    if (edge[int(axis)] < 0.0) lowest |= 1 << k, turned_zones += divisions[size_t(k)];
  }
  for (int bits = 0; bits < 8; ++bits) {
    Vector straight;
    for (int k = 0; k < 3; ++k) {
      if (bits >> k & 1) straight += along(1 << k);
    }
    const Vector off = along(bits) - straight;
    for (int c = 0; c < 3; ++c) {
      if (std::abs(off[c]) > kStraight * longest) return std::nullopt;
    }
  }
  for (int k = 0; k < 3; ++k) {
    const Vector edge = along(1 << k);
    const double length = norm(edge), straight = std::max({std::abs(edge.x), std::abs(edge.y), std::abs(edge.z)});
    if (std::abs(edge.x) + std::abs(edge.y) + std::abs(edge.z) - straight > kStraight * length) return std::nullopt;
  }
  brick.origin = array(block.position + turned * shape.vertices[size_t((*corner)[size_t(lowest)])]);
  brick.material = block.material;
  brick.rigid = block.rigid;
  brick.unit = block.unit, brick.course = block.course;
  // Gridpoints with an even sum of indices are corners of the middle zones of pattern 0 on the lattice, of pattern 1 in
  // blocks of any shape.
  if (!block.rigid) brick.parity = (turned_zones + 1 + block.parity) % 2;
  return brick;
}

std::optional<OnLattice> to_bricks(const Assembly& assembly, const Scene& scene, std::string* why_not) {
  try {
    return made_of(assembly, scene);
  } catch (const Unfit& reason) {
    *why_not = reason.why;
    return std::nullopt;
  }
}

}  // namespace quoin::blocks
