#include "scene/generate_blocks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <numbers>
#include <set>

#include "base/error.h"
#include "base/printable.h"
#include "geometry/drawn_shape.h"
#include "geometry/mesh_file.h"
#include "scene/driven.h"
#include "scene/from_bricks.h"
#include "scene/generate.h"
#include "scene/masonry_place.h"
#include "scene/read_scene.h"
#include "scene/to_bricks.h"
#include "scene/weight_axis.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

constexpr double degree = std::numbers::pi / 180;

// Adds notes on blocks of a mesh that differ from their objects in the file.
void note_mesh(const BlockSpec& spec, const std::vector<NamedShape>& shapes, Assembly& assembly) {
  std::string warped, plates;
  double worst = 0.0;
  long count = 0;
  for (const NamedShape& s : shapes) {
    if (s.plate) plates += (plates.empty() ? "" : ", ") + printable(s.name);
    if (s.warp == 0.0) continue;
    ++count;
    if (s.warp > worst) worst = s.warp, warped = printable(s.name);
  }
  if (count > 0)
    assembly.notes.push_back(
        fmt::format("{}: {} of {} blocks have faces that no plane fits, and were made planar: their surfaces moved by "
                    "{:.2g} m at most ({})",
                    spec.mesh, count, shapes.size(), worst, warped));
  if (!plates.empty())
    assembly.notes.push_back(
        fmt::format("{}: supports drawn as a flat face, now fixed plates behind it: {}", spec.mesh, plates));
}

// Adds every block of a mesh file: a copy of `like`, which the table describes, with its own name and fixity.
void add_mesh(const BlockSpec& spec, Block like, Assembly& assembly) {
  const auto name_of = [&](const std::string& own) {
    return printable(spec.name.empty() ? own : spec.name + "/" + own);
  };
  std::vector<bool> found(spec.fixed_names.size(), false);
  std::vector<std::string> names;
  std::vector<NamedShape> shapes = read_mesh_file(spec.mesh, spec.scale, [&](const std::string& own) {
    names.push_back(own);
    bool fixed = spec.fixed;
    for (size_t i = 0; i < found.size(); ++i) {
      if (spec.fixed_names[i] == own || spec.fixed_names[i] == name_of(own)) fixed = found[i] = true;
    }
    return fixed;
  });
  for (size_t i = 0; i < found.size(); ++i) {
    if (!found[i])
      throw Error(Exit::bad_input, fmt::format("fixed: no block of {} is called '{}'{}", spec.mesh, spec.fixed_names[i],
                                               did_you_mean(spec.fixed_names[i], names)));
  }
  note_mesh(spec, shapes, assembly);
  for (NamedShape& s : shapes) {
    like.name = name_of(s.name);
    like.fixed = s.support;
    assembly.add(std::move(s.shape), like);
  }
}

void add_block(const BlockSpec& spec, int material, int unit, Assembly& assembly) {
  Block b;
  b.name = spec.name;
  b.unit = unit;
  b.material = material;
  b.rigid = spec.rigid, b.zone_edge = spec.zone_edge, b.divisions = spec.divisions, b.fixed = spec.fixed;
  b.position = vector(spec.position);
  b.orientation = rotation(degree * vector(spec.rotation));
  try {
    if (spec.box_size) {
      assembly.add(box(vector(*spec.box_lower), vector(*spec.box_size)), b);
    } else if (!spec.mesh.empty()) {
      add_mesh(spec, b, assembly);
    } else {
      std::vector<Vector> points;
      for (const Vec3& p : spec.vertices) points.push_back(vector(p));
      if (!spec.tetrahedra.empty()) {
        ZonedShape zoned = from_tetrahedra(points, spec.tetrahedra, spec.name);
        b.zoning = std::make_shared<const Zoning>(std::move(zoned.zoning));
        assembly.add(std::move(zoned.shape), b);
        return;
      }
      if (spec.faces.empty()) {
        assembly.add(from_vertices(points, spec.name), b);
        return;
      }
      DrawnShape drawn = from_drawn({spec.name, points, spec.faces});
      if (drawn.warp > 0.0)
        assembly.notes.push_back(
            fmt::format("block {}: has faces that no plane fits, and was made planar: its surface "
                        "moved by {:.2g} m at most",
                        spec.name, drawn.warp));
      assembly.add(std::move(drawn.shape), b);
    }
  } catch (const Error& e) {
    throw Error(e.exit_code, fmt::format("{}: {}", spec.source.text, e.what()));
  }
}

// One course of a dry wall: its cuts between units, and its gaps. Places are along the wall, m.
class Course {
 public:
  Course(const DryWallSpec& w, int index) : w_(w), length_(w.unit[0]), tiny_(1e-9 * w.unit[0]) {
    start_ = w.trim_start[index % 2], end_ = w.units_per_course * length_ - w.trim_end[index % 2];
    if (w.bond == "running") shift_ = ((index % 2 == 1) != (w.first_course == "half")) ? 0.5 : 0.0;
    if (w.bond == "third") shift_ = (index % 3) / 3.0;
    if (w.bond == "stack" && w.first_course == "half") shift_ = 0.5;
    cut(index * w.unit[1]);
  }

  // Ends of the pieces of the course.
  std::vector<double> ends() const {
    std::vector<double> kept;
    for (double x : cuts_) {
      if (x < start_ - tiny_ || x > end_ + tiny_) continue;
      const bool inside_lintel = std::any_of(
          lintels_.begin(), lintels_.end(), [&](const auto& l) { return x > l.first + tiny_ && x < l.second - tiny_; });
      if (inside_lintel) continue;
      if (!kept.empty() && x - kept.back() < 0.1 * length_) {
        if (needed(x) && !needed(kept.back()))
          kept.back() = x;
        else if (needed(x) && x - kept.back() > tiny_)
          kept.push_back(x);
        continue;
      }
      kept.push_back(x);
    }
    return kept;
  }

  bool is_gap(double x) const { return is_in(gaps_, x); }
  bool is_lintel(double x) const { return is_in(lintels_, x); }
  // Middle of the whole unit that the piece is cut from. The end of the piece when either part would be too small for a
  // block.
  double middle_of_unit(double from, double to) const {
    const double unit = std::floor((0.5 * (from + to)) / length_ + shift_), x = (unit - shift_ + 0.5) * length_;
    return x > from + 0.1 * length_ && x < to - 0.1 * length_ ? x : to;
  }

 private:
  using Parts = std::vector<std::pair<double, double>>;
  static bool is_in(const Parts& parts, double x) {
    return std::any_of(parts.begin(), parts.end(), [x](const auto& p) { return x > p.first && x < p.second; });
  }

  void cut(double bottom) {
    const double height = w_.unit[1], top = bottom + height;
    cuts_ = {start_, end_};
    for (double x = -shift_ * length_; x < end_ - tiny_; x += length_) {
      if (x > start_ + tiny_) cuts_.push_back(x);
    }
    for (const auto& o : w_.openings) {
      if (bottom < o.head - tiny_ && top > o.sill + tiny_) {
        gaps_.push_back({o.from, o.to});
        cuts_.push_back(o.from), cuts_.push_back(o.to);
      } else if (o.bearing > 0 && bottom >= o.head - tiny_ && bottom < o.head + height - tiny_) {
        lintels_.push_back({std::max(start_, o.from - o.bearing), std::min(end_, o.to + o.bearing)});
        cuts_.push_back(lintels_.back().first), cuts_.push_back(lintels_.back().second);
      }
    }
    std::sort(cuts_.begin(), cuts_.end());
  }

  // Whether x is an end of the course, of a gap or of a lintel.
  bool needed(double x) const {
    const auto here = [&](double place) { return std::abs(x - place) < tiny_; };
    const auto ends_here = [&](const auto& part) { return here(part.first) || here(part.second); };
    return here(start_) || here(end_) || std::any_of(gaps_.begin(), gaps_.end(), ends_here) ||
           std::any_of(lintels_.begin(), lintels_.end(), ends_here);
  }

  const DryWallSpec& w_;
  double length_, tiny_;
  double start_ = 0.0, end_ = 0.0, shift_ = 0.0;  // shift: offset of the bond, in units
  std::vector<double> cuts_;
  Parts gaps_, lintels_;
};

// Adds courses of units, cut at openings and trimmed ends. Pieces shorter than a tenth of a unit are merged with their
// neighbour. next_unit: number of the next masonry unit.
void add_wall(const DryWallSpec& w, int material, int* next_unit, Assembly& assembly) {
  const double length = w.unit[0], height = w.unit[1], thickness = w.unit[2];
  const Quaternion turn = rotation({0, -w.direction * degree, 0});
  const auto add = [&](double from, double to, int course, const std::string& suffix) {
    Block b;
    b.name = fmt::format("{}/{}{}", w.name.empty() ? "wall" : w.name, course, suffix);
    b.material = material, b.rigid = w.rigid, b.zone_edge = w.zone_edge, b.course = course, b.unit = *next_unit;
    if (w.zones[0] > 0) {
      b.divisions = w.zones;
      b.divisions[0] = std::max(1, int(std::lround(w.zones[0] * (to - from) / (length / 2))));
    }
    b.position = vector(w.origin);
    b.orientation = turn;
    assembly.add(box({from, course * height, 0}, {to - from, height, thickness}), b);
  };
  for (int c = 0; c < w.courses; ++c) {
    const Course course(w, c);
    const std::vector<double> ends = course.ends();
    int number = 0;
    for (size_t i = 0; i + 1 < ends.size(); ++i) {
      const double from = ends[i], to = ends[i + 1], middle = 0.5 * (from + to);
      if (course.is_gap(middle)) continue;
      const std::string name = fmt::format("/{}", number++);
      const double cut = w.mid_unit_joints && !course.is_lintel(middle) ? course.middle_of_unit(from, to) : to;
      if (cut < to) {
        add(from, cut, c, name + "/a");
        add(cut, to, c, name + "/b");
      } else {
        add(from, to, c, name);
      }
      ++*next_unit;
    }
  }
}

void add_arch(const ArchSpec& a, int material, Assembly& assembly) {
  const double first = a.angles[0] * degree, step = (a.angles[1] - a.angles[0]) * degree / a.voussoirs;
  const int extra = a.abutments ? 1 : 0;
  for (int i = -extra; i < a.voussoirs + extra; ++i) {
    std::vector<Vector> p;
    for (double angle : {first + step * i, first + step * (i + 1)}) {
      for (double r : {a.radius - a.thickness / 2, a.radius + a.thickness / 2}) {
        for (double z : {0.0, a.depth}) p.push_back({r * std::cos(angle), r * std::sin(angle), z});
      }
    }
    Block b;
    b.name = fmt::format("{}/{}", a.name.empty() ? "arch" : a.name, i);
    b.material = material, b.rigid = a.rigid, b.zone_edge = a.zone_edge;
    b.fixed = i < 0 || i >= a.voussoirs;
    if (b.fixed) b.rigid = true;
    b.position = vector(a.centre);
    assembly.add(from_vertices(p, b.name), b);
  }
}

// Alternates zones of boxes on one grid like the fields of a chessboard, from the lowest corner of all on. So the
// diagonals of faces in contact coincide, whatever the number of zones.
void match_diagonals(int first_block, Assembly& assembly) {
  std::map<int, Brick> boxes;
  Vector lowest{1e300, 1e300, 1e300};
  for (int i = first_block; i < int(assembly.blocks.size()); ++i) {
    if (assembly.blocks[size_t(i)].rigid || assembly.blocks[size_t(i)].divisions[0] == 0) continue;
    if (const std::optional<Brick> box = as_brick(assembly, i)) {
      boxes.emplace(i, *box);
      lowest = min(lowest, vector(box->origin));
    }
  }
  for (const auto& [i, box] : boxes) {
    long squares = 0;
    for (size_t c = 0; c < 3; ++c)
      squares += std::lround((box.origin[c] - lowest[int(c)]) * box.zones[c] / box.size[c]);
    if (squares % 2 != box.parity) assembly.blocks[size_t(i)].parity ^= 1;
  }
}

// Adds the scene's wall or building as blocks beside others. Every one has a name, and the lower beam is fixed.
void add_bricks_of(const Scene& scene, const quoin::Assembly& bricks, Assembly* assembly) {
  if (bricks.symmetry_plane_z0)
    throw Error(Exit::bad_input, scene.file +
                                     ": wall.half_thickness: not beside blocks of any shape, which would "
                                     "stand at half a wall; remove it");
  add_bricks(bricks, assembly);
  std::map<int, int> in_course;
  for (Block& block : assembly->blocks) {
    if (block.name.starts_with("bottom_beam")) block.fixed = true;
    if (block.course >= 0 && (block.name.empty() || scene.wall))
      block.name = fmt::format("{}/{}/{}", scene.wall ? "wall" : "building", block.course, in_course[block.course]++);
  }
  assembly->materials = bricks.materials;
}

// Returns the function that chooses the family of two blocks in contact. Inside the wall it is that of the wall's
// joints, otherwise that of the first rule that fits.
std::function<int(const Meeting&)> families_of(const Scene& scene, const Assembly& assembly,
                                               const quoin::Assembly* bricks) {
  std::map<std::string, int> family{{"none", kNoFamily}};
  for (int next = 0; const auto& [name, f] : scene.joints) family[name] = next++;
  struct Rule {
    JointRule rule;
    int family;
  };
  std::vector<Rule> rules;
  for (const JointRule& r : scene.blocks->rules) rules.push_back({r, family.at(r.family)});
  std::vector<std::string> names;
  std::vector<int> units;
  for (const Block& b : assembly.blocks) names.push_back(b.name), units.push_back(b.unit);
  for (const JointRule& r : scene.blocks->rules) {
    for (const std::string& prefix : r.between) {
      const auto begins = [&](const std::string& name) { return name.starts_with(prefix); };
      if (std::any_of(names.begin(), names.end(), begins)) continue;
      throw Error(Exit::bad_input, fmt::format("{}: joint_rule.between: no block has a name that begins with '{}'{}",
                                               scene.file, prefix, did_you_mean(prefix, names)));
    }
  }
  const auto with_mortar = [families = assembly.families, units](int of, const Meeting& m) {
    const auto placed = [&](int block) { return PlacedBlock{units[size_t(block)], -1}; };
    const bool lacks =
        of >= 0 && lacks_mortar(families[size_t(of)], m.block_a, placed(m.block_a), m.block_b, placed(m.block_b));
    return lacks ? kNoFamily : of;
  };
  std::optional<FamilyOfBricks> of_bricks;
  if (bricks) of_bricks.emplace(*bricks);
  const int upright = upright_axis(scene);
  return [=, brick_count = bricks ? int(bricks->bricks.size()) : 0,
          fallback = family.at(scene.blocks->default_joint)](const Meeting& m) {
    if (std::max(m.block_a, m.block_b) < brick_count) return (*of_bricks)(m.block_a, m.block_b);
    const size_t i = size_t(m.block_a), j = size_t(m.block_b);
    const bool vertical = std::abs(m.normal[upright]) > 0.7071, inside = units[i] >= 0 && units[i] == units[j];
    const std::string &a = names[i], &b = names[j];
    for (const Rule& r : rules) {
      if ((r.rule.normal == "vertical" && !vertical) || (r.rule.normal == "horizontal" && vertical)) continue;
      if (r.rule.inside_units && !inside) continue;
      const auto& [p, q] = r.rule.between;
      if ((a.starts_with(p) && b.starts_with(q)) || (a.starts_with(q) && b.starts_with(p)))
        return with_mortar(r.family, m);
    }
    return with_mortar(fallback, m);
  };
}

// Makes faces of blocks one that rounded coordinates have divided. Zones of mesh files keep their faces.
void unite_faces_of_blocks(Assembly& assembly) {
  const double tolerance = joint_tolerance_of(assembly);
  double worst = 0.0;
  long count = 0;
  std::string farthest, divided;
  std::vector<bool> seen(assembly.shapes.size(), false);
  for (size_t i = 0; i < assembly.blocks.size(); ++i) {
    const Block& block = assembly.blocks[i];
    if (block.zoning || seen[size_t(block.shape)]) continue;
    seen[size_t(block.shape)] = true;
    const double moved = unite_faces(assembly.shapes[size_t(block.shape)], tolerance);
    if (moved < 0.0) divided += (divided.empty() ? "" : ", ") + label(assembly, int(i));
    if (moved <= 0.0) continue;
    ++count;
    if (moved > worst) worst = moved, farthest = label(assembly, int(i));
  }
  if (count > 0)
    assembly.notes.push_back(fmt::format(
        "{} blocks have faces whose corners lie in one plane within contact.joint_tolerance ({:.2g} m), and "
        "were made planar: corners moved by {:.2g} m at most (block {})",
        count, tolerance, worst, farthest));
  if (!divided.empty())
    assembly.notes.push_back(fmt::format(
        "blocks with faces in one plane within contact.joint_tolerance ({:.2g} m) which cannot be made one, "
        "so that joints may lack part of them; give their corners more digits: {}",
        tolerance, divided));
}

}  // namespace

Assembly assemble(const Scene& scene) {
  const BlocksSpec& spec = *scene.blocks;
  auto assembly = with_materials<Assembly>(scene.materials, scene.joints);
  const auto index_of = [&](const std::string& material) { return quoin::index_of(scene.materials, material); };
  std::optional<quoin::Assembly> bricks;
  if (scene.wall || scene.building) add_bricks_of(scene, bricks.emplace(quoin::assemble(scene)), &assembly);
  int next_unit = 0;
  for (const Block& b : assembly.blocks) next_unit = std::max(next_unit, b.unit + 1);
  std::map<std::string, int> units;
  for (const BlockSpec& b : spec.blocks) {
    const int unit = b.unit.empty() ? -1 : units.try_emplace(b.unit, next_unit).first->second;
    if (unit == next_unit) ++next_unit;
    add_block(b, index_of(b.material), unit, assembly);
  }
  for (const DryWallSpec& w : spec.walls) add_wall(w, index_of(w.material), &next_unit, assembly);
  for (const ArchSpec& a : spec.arches) add_arch(a, index_of(a.material), assembly);
  if (assembly.blocks.empty())
    throw Error(Exit::bad_input, scene.file + ": no block; add [[block]], [[dry_wall]] or [[arch]]");
  match_diagonals(bricks ? int(bricks->bricks.size()) : 0, assembly);

  assembly.family_of = families_of(scene, assembly, bricks ? &*bricks : nullptr);
  const auto& c = spec.contact;
  assembly.contact.skin = c.skin;
  assembly.contact.joint_tolerance = c.joint_tolerance;
  assembly.contact.point_spacing = c.point_spacing;
  assembly.contact.small_displacement = c.small_displacement;
  if (bricks) assembly.contact.joint_motion = kJointMotion;
  unite_faces_of_blocks(assembly);
  mark_freed_blocks(scene, &assembly);
  return assembly;
}

void mark_freed_blocks(const Scene& scene, Assembly* assembly) {
  std::set<std::string> freed;
  for (const Stage& stage : scene.stages) {
    for (const BodyControl& control : stage.controls) {
      if (prescribed_by(control) != kAllPrescribed) freed.insert(control.body);
    }
  }
  for (Block& block : assembly->blocks)
    block.freed = block.fixed && (freed.contains(block.name) || freed.contains(block.name_in_stages()));
}

double joint_tolerance_of(const Assembly& assembly) {
  if (assembly.contact.joint_tolerance > 0) return assembly.contact.joint_tolerance;
  double least = 1e300;
  for (const Block& block : assembly.blocks)
    least = std::min(least, least_extent(assembly.shapes[size_t(block.shape)]));
  return 1e-4 * least;
}

int Assembly::add(ConvexPolyhedron shape, Block block) {
  block.shape = int(shapes.size());
  shapes.push_back(std::move(shape));
  blocks.push_back(std::move(block));
  return int(blocks.size()) - 1;
}

std::string label(const Assembly& a, int block) {
  const Block& b = a.blocks[block];
  return b.name.empty() ? fmt::format("#{}", block) : fmt::format("#{} '{}'", block, b.name);
}

namespace {

// The names that blocks have. Units of walls and buildings have none.
std::string names_text(std::vector<std::string> names) {
  constexpr std::size_t kListed = 8;
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  std::erase(names, "");
  if (names.empty()) return "no block of this scene has a name";
  const bool whole = names.size() <= kListed;
  names.resize(std::min(names.size(), kListed));
  return fmt::format("blocks with a name here: {}{}", fmt::join(names, ", "), whole ? "" : ", ...");
}

}  // namespace

std::vector<int> find_blocks(const Assembly& assembly, const std::string& name, const std::string& where) {
  std::vector<std::string> names;
  std::vector<int> found;
  for (size_t i = 0; i < assembly.blocks.size(); ++i) {
    names.push_back(assembly.blocks[i].name);
    if (assembly.blocks[i].name == name || assembly.blocks[i].name_in_stages() == name) found.push_back(int(i));
  }
  if (found.size() > 1 && !assembly.shared_names) {
    throw Error(Exit::bad_input,
                fmt::format("{}: blocks #{} and #{} are both called '{}'; give them names of their own", where,
                            found[0], found[1], name));
  }
  if (!found.empty()) return found;
  std::string hint = did_you_mean(name, names);
  if (hint.empty()) hint = "; " + names_text(std::move(names));
  throw Error(Exit::bad_input, fmt::format("{}: no block is called '{}'{}", where, name, hint));
}

}  // namespace quoin::blocks
