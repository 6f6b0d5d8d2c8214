#include "blocks/generate.h"

#include <fmt/format.h>

#include <numbers>

#include "geometry/mesh_file.h"
#include "scene/error.h"
#include "scene/read_scene.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

constexpr double degree = std::numbers::pi / 180;

void add_block(const BlockSpec& spec, int material, Assembly& assembly) {
  Block b;
  b.name = spec.name;
  b.material = material;
  b.rigid = spec.rigid, b.zone_edge = spec.zone_edge, b.divisions = spec.divisions, b.fixed = spec.fixed;
  b.position = vector(spec.position);
  b.orientation = rotation(degree * vector(spec.rotation));
  try {
    if (spec.box_size) {
      assembly.add(box(vector(*spec.box_lower), vector(*spec.box_size)), b);
    } else if (!spec.mesh.empty()) {
      for (NamedShape& s : read_mesh_file(spec.mesh, spec.scale)) {
        b.name = spec.name.empty() ? s.name : spec.name + "/" + s.name;
        assembly.add(std::move(s.shape), b);
      }
    } else {
      std::vector<Vector> points;
      for (const Vec3& p : spec.vertices) points.push_back(vector(p));
      assembly.add(spec.faces.empty() ? from_vertices(points, spec.name) : from_faces(points, spec.faces, spec.name),
                   b);
    }
  } catch (const Error& e) {
    throw Error(e.exit_code, fmt::format("{}: {}", spec.source.text, e.what()));
  }
}

// Courses of units; pieces where they meet openings and trimmed ends. Pieces shorter than a tenth of a unit join their
// neighbour.
void add_wall(const DryWallSpec& w, int material, Assembly& assembly) {
  const double length = w.unit[0], height = w.unit[1], thickness = w.unit[2], total = w.units_per_course * length;
  const Quaternion turn = rotation({0, -w.direction * degree, 0});
  const double tiny = 1e-9 * length;
  struct Lintel {
    double from, to, bottom;
  };
  const auto add = [&](double from, double to, int course, const std::string& suffix) {
    Block b;
    b.name = fmt::format("{}/{}{}", w.name.empty() ? "wall" : w.name, course, suffix);
    b.material = material, b.rigid = w.rigid, b.zone_edge = w.zone_edge, b.course = course;
    b.position = vector(w.origin);
    b.orientation = turn;
    assembly.add(box({from, course * height, 0}, {to - from, height, thickness}), b);
  };
  for (int c = 0; c < w.courses; ++c) {
    const double start = w.trim_start[c % 2], end = total - w.trim_end[c % 2];
    double shift = 0.0;
    if (w.bond == "running") shift = ((c % 2 == 1) != (w.first_course == "half")) ? 0.5 : 0.0;
    if (w.bond == "third") shift = (c % 3) / 3.0;
    if (w.bond == "stack" && w.first_course == "half") shift = 0.5;
    std::vector<double> cuts{start, end};
    for (double x = -shift * length; x < end - tiny; x += length) {
      if (x > start + tiny) cuts.push_back(x);
    }
    std::vector<std::pair<double, double>> gaps;  // no unit here
    std::vector<std::pair<double, double>> lintels;
    const double bottom = c * height, top = bottom + height;
    for (const auto& o : w.openings) {
      if (bottom < o.head - tiny && top > o.sill + tiny) {
        gaps.push_back({o.from, o.to});
        cuts.push_back(o.from), cuts.push_back(o.to);
      } else if (o.bearing > 0 && bottom >= o.head - tiny && bottom < o.head + height - tiny) {
        lintels.push_back({std::max(start, o.from - o.bearing), std::min(end, o.to + o.bearing)});
        cuts.push_back(lintels.back().first), cuts.push_back(lintels.back().second);
      }
    }
    std::sort(cuts.begin(), cuts.end());
    std::vector<double> kept;
    const auto needed = [&](double x) {
      bool is = std::abs(x - start) < tiny || std::abs(x - end) < tiny;
      for (const auto& g : gaps) is |= std::abs(x - g.first) < tiny || std::abs(x - g.second) < tiny;
      for (const auto& l : lintels) is |= std::abs(x - l.first) < tiny || std::abs(x - l.second) < tiny;
      return is;
    };
    for (double x : cuts) {
      if (x < start - tiny || x > end + tiny) continue;
      bool inside_lintel = false;
      for (const auto& l : lintels) inside_lintel |= x > l.first + tiny && x < l.second - tiny;
      if (inside_lintel) continue;
      if (!kept.empty() && x - kept.back() < 0.1 * length) {
        if (needed(x) && !needed(kept.back()))
          kept.back() = x;
        else if (needed(x) && x - kept.back() > tiny)
          kept.push_back(x);
        continue;
      }
      kept.push_back(x);
    }
    int number = 0;
    for (size_t i = 0; i + 1 < kept.size(); ++i) {
      const double from = kept[i], to = kept[i + 1], middle = 0.5 * (from + to);
      bool is_gap = false;
      for (const auto& g : gaps) is_gap |= middle > g.first && middle < g.second;
      if (!is_gap) add(from, to, c, fmt::format("/{}", number++));
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

}  // namespace

Assembly assemble(const Scene& scene) {
  const BlocksSpec& spec = *scene.blocks;
  Assembly assembly;
  std::map<std::string, int> material;
  for (const auto& [name, m] : scene.materials) {
    material[name] = int(assembly.materials.size());
    assembly.materials.push_back(m);
  }
  std::map<std::string, int> family{{"none", -1}};
  for (const auto& [name, f] : scene.joints) {
    family[name] = int(assembly.families.size());
    assembly.families.push_back(f);
  }
  for (const BlockSpec& b : spec.blocks) add_block(b, material.at(b.material), assembly);
  for (const DryWallSpec& w : spec.walls) add_wall(w, material.at(w.material), assembly);
  for (const ArchSpec& a : spec.arches) add_arch(a, material.at(a.material), assembly);
  if (assembly.blocks.empty())
    throw Error(Exit::bad_input, scene.file + ": no block; add [[block]], [[dry_wall]] or [[arch]]");

  std::vector<std::string> names;
  for (const Block& b : assembly.blocks) names.push_back(b.name);
  const int fallback = family.at(spec.default_joint);
  struct Rule {
    JointRule rule;
    int family;
  };
  std::vector<Rule> rules;
  for (const JointRule& r : spec.rules) rules.push_back({r, family.at(r.family)});
  assembly.family_of = [=](const Meeting& m) {
    const bool vertical = std::abs(m.normal.y) > 0.7071;
    const std::string &a = names[m.block_a], &b = names[m.block_b];
    for (const Rule& r : rules) {
      if ((r.rule.normal == "vertical" && !vertical) || (r.rule.normal == "horizontal" && vertical)) continue;
      const auto& [p, q] = r.rule.between;
      if ((a.starts_with(p) && b.starts_with(q)) || (a.starts_with(q) && b.starts_with(p))) return r.family;
    }
    return fallback;
  };
  const auto& c = spec.contact;
  assembly.contact.skin = c.skin;
  assembly.contact.joint_tolerance = c.joint_tolerance;
  assembly.contact.point_spacing = c.point_spacing;
  assembly.contact.small_displacement = c.small_displacement;
  assembly.contact.cubic_points = c.cubic_points;
  return assembly;
}

std::vector<int> find_blocks(const Assembly& assembly, const std::string& name, const std::string& where) {
  std::vector<std::string> names;
  std::vector<int> found;
  for (size_t i = 0; i < assembly.blocks.size(); ++i) {
    names.push_back(assembly.blocks[i].name);
    if (assembly.blocks[i].name == name) found.push_back(int(i));
  }
  if (found.size() > 1 && !assembly.shared_names) {
    throw Error(Exit::bad_input,
                fmt::format("{}: blocks #{} and #{} are both called '{}'; give them names of their own", where,
                            found[0], found[1], name));
  }
  if (!found.empty()) return found;
  throw Error(Exit::bad_input, fmt::format("{}: no block is called '{}'{}", where, name, did_you_mean(name, names)));
}

}  // namespace quoin::blocks
