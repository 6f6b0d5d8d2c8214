#include "model/model.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

#include "base/error.h"
#include "model/body_groups.h"
#include "model/point_order.h"

namespace quoin {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Coordinates agree when they differ by less than this fraction of the smallest edge in sight.
constexpr double kCoordinateTolerance = 1e-6;

double smallest_edge(const Brick& a, const Brick& b) {
  double edge = a.size[0];
  for (std::size_t c = 0; c < 3; ++c) edge = std::min({edge, a.size[c], b.size[c]});
  return edge;
}

bool same_template(const BrickTemplate& t, const Brick& brick) {
  const double tolerance = 1e-9 * *std::max_element(brick.size.begin(), brick.size.end());
  for (std::size_t c = 0; c < 3; ++c) {
    if (std::abs(t.size[c] - brick.size[c]) > tolerance) return false;
  }
  return t.zones == brick.zones && t.parity == brick.parity && t.material == brick.material;
}

// One side of a joint's contact point before numbering: a template gridpoint of a deformable block, or a rigid body.
struct Side {
  int block = -1;
  int node = -1;  // of a template, or the slot of a body in a group; -1: a lone body
};

struct NewPoint {
  Side a, b;
  int joint, family, axis;
  double area;
  Vec3 position;
};

struct FaceNode {
  int node;
  Vec3 position;
};

std::vector<FaceNode> face_nodes(const Brick& brick, const BrickTemplate& shape, int face) {
  const int axis = face / 2, layer = face % 2 == 0 ? 0 : brick.zones[at(axis)];
  std::vector<FaceNode> result;
  for (int k = 0; k <= brick.zones[2]; ++k) {
    for (int j = 0; j <= brick.zones[1]; ++j) {
      for (int i = 0; i <= brick.zones[0]; ++i) {
        const int index[3] = {i, j, k};
        if (index[axis] != layer) continue;
        const int node = shape.node_index(i, j, k);
        Vec3 p = shape.node[at(node)];
        for (std::size_t c = 0; c < 3; ++c) p[c] += brick.origin[c];
        result.push_back({node, p});
      }
    }
  }
  return result;
}

// A third of each face triangle that lies whole in the joint, to its three gridpoints.
std::vector<double> face_areas(const BrickTemplate& shape, int face, const std::vector<char>& in_joint) {
  std::vector<double> area(shape.node.size(), 0.0);
  const std::size_t s = at((face / 2 + 1) % 3), t = at((face / 2 + 2) % 3);
  for (const FaceTriangle& triangle : shape.face_triangle) {
    const auto& n = triangle.node;
    if (triangle.face != face || !in_joint[at(n[0])] || !in_joint[at(n[1])] || !in_joint[at(n[2])]) continue;
    const Vec3 &p = shape.node[at(n[0])], &q = shape.node[at(n[1])], &r = shape.node[at(n[2])];
    const double twice = (q[s] - p[s]) * (r[t] - p[t]) - (q[t] - p[t]) * (r[s] - p[s]);
    for (int node : n) area[at(node)] += std::abs(twice) / 6.0;
  }
  return area;
}

std::string describe(const Assembly& assembly, const Joint& joint, std::size_t index) {
  return fmt::format("joint {} between blocks {} and {} (family '{}')", index, joint.block_a, joint.block_b,
                     assembly.families[at(joint.family)].name);
}

class PointFinder {
 public:
  PointFinder(const Assembly& assembly, const std::vector<BrickTemplate>& templates,
              const std::vector<int>& template_of)
      : assembly_(assembly), templates_(templates), template_of_(template_of) {}

  std::vector<NewPoint> find() {
    for (std::size_t j = 0; j < assembly_.joints.size(); ++j) {
      // The normal points along +axis: a joint that comes the other way round changes sides.
      Joint joint = assembly_.joints[j];
      if (joint.face_a % 2 == 0) {
        std::swap(joint.block_a, joint.block_b);
        joint.face_a += 1;
      }
      const Brick &a = assembly_.bricks[at(joint.block_a)], &b = assembly_.bricks[at(joint.block_b)];
      joint_ = static_cast<int>(j);
      family_ = joint.family;
      axis_ = joint.face_a / 2;
      tolerance_ = kCoordinateTolerance * smallest_edge(a, b);
      const double plane_a = a.origin[at(axis_)] + a.size[at(axis_)], plane_b = b.origin[at(axis_)];
      if (std::abs(plane_a - plane_b) > tolerance_) {
        throw Error(Exit::bad_input,
                    fmt::format("{}: the faces are {} m apart along axis {}; they must touch",
                                describe(assembly_, assembly_.joints[j], j), plane_b - plane_a, axis_));
      }
      const std::size_t before = points_.size();
      if (a.rigid && b.rigid) {
        rigid_to_rigid(joint, a, b);
      } else if (a.rigid || b.rigid) {
        rigid_to_deformable(joint, a, b);
      } else {
        deformable_to_deformable(joint, a, b);
      }
      if (points_.size() == before) {
        throw Error(Exit::bad_input, fmt::format("{}: no contact points; the faces do not share gridpoints",
                                                 describe(assembly_, assembly_.joints[j], j)));
      }
    }
    return std::move(points_);
  }

 private:
  void add(Side a, Side b, double area, const Vec3& position) {
    if (area > 0.0) points_.push_back({a, b, joint_, family_, axis_, area, position});
  }

  const BrickTemplate& shape(int block) const { return templates_[at(template_of_[at(block)])]; }

  void deformable_to_deformable(const Joint& joint, const Brick& a, const Brick& b) {
    const auto nodes_a = face_nodes(a, shape(joint.block_a), 2 * axis_ + 1);
    const auto nodes_b = face_nodes(b, shape(joint.block_b), 2 * axis_);
    std::vector<char> in_a(shape(joint.block_a).node.size(), 0), in_b(shape(joint.block_b).node.size(), 0);
    std::vector<std::pair<const FaceNode*, const FaceNode*>> pairs;
    for (const FaceNode& p : nodes_a) {
      for (const FaceNode& q : nodes_b) {
        if (std::abs(p.position[0] - q.position[0]) > tolerance_ ||
            std::abs(p.position[1] - q.position[1]) > tolerance_ ||
            std::abs(p.position[2] - q.position[2]) > tolerance_) {
          continue;
        }
        pairs.emplace_back(&p, &q);
        in_a[at(p.node)] = in_b[at(q.node)] = 1;
      }
    }
    const auto area_a = face_areas(shape(joint.block_a), 2 * axis_ + 1, in_a);
    const auto area_b = face_areas(shape(joint.block_b), 2 * axis_, in_b);
    for (const auto& [p, q] : pairs) {
      // With an odd number of layers the diagonals of the two faces differ: the mean of both sides is used.
      const double area = 0.5 * (area_a[at(p->node)] + area_b[at(q->node)]);
      add({joint.block_a, p->node}, {joint.block_b, q->node}, area, p->position);
    }
  }

  void rigid_to_deformable(const Joint& joint, const Brick& a, const Brick& b) {
    const Brick &rigid = a.rigid ? a : b, &soft = a.rigid ? b : a;
    const int soft_block = a.rigid ? joint.block_b : joint.block_a;
    const int face = a.rigid ? 2 * axis_ : 2 * axis_ + 1;
    const BrickTemplate& soft_shape = shape(soft_block);
    std::vector<FaceNode> inside;
    std::vector<char> in_joint(soft_shape.node.size(), 0);
    for (const FaceNode& p : face_nodes(soft, soft_shape, face)) {
      bool covered = true;
      for (std::size_t c = 0; c < 3; ++c) {
        if (c == at(axis_)) continue;
        covered = covered && p.position[c] >= rigid.origin[c] - tolerance_ &&
                  p.position[c] <= rigid.origin[c] + rigid.size[c] + tolerance_;
      }
      if (!covered) continue;
      inside.push_back(p);
      in_joint[at(p.node)] = 1;
    }
    const auto area = face_areas(soft_shape, face, in_joint);
    for (const FaceNode& p : inside) {
      const Side soft_side{soft_block, p.node}, rigid_side{a.rigid ? joint.block_a : joint.block_b, -1};
      add(a.rigid ? rigid_side : soft_side, a.rigid ? soft_side : rigid_side, area[at(p.node)], p.position);
    }
  }

  // A grid over the overlap with points on its edges and corners, weights of the trapezoidal rule: rigid blocks turn
  // about their true corners. The zones of block a over the overlap set the number of points, 2 x 2 at least.
  void rigid_to_rigid(const Joint& joint, const Brick& a, const Brick& b) {
    const std::size_t s = at((axis_ + 1) % 3), t = at((axis_ + 2) % 3);
    double low[3], length[3];
    int cells[3];
    for (std::size_t c : {s, t}) {
      low[c] = std::max(a.origin[c], b.origin[c]);
      length[c] = std::min(a.origin[c] + a.size[c], b.origin[c] + b.size[c]) - low[c];
      if (length[c] <= tolerance_) return;
      cells[c] = std::max(1, static_cast<int>(std::lround(a.zones[c] * length[c] / a.size[c])));
    }
    for (int j = 0; j <= cells[t]; ++j) {
      for (int i = 0; i <= cells[s]; ++i) {
        Vec3 p{};
        p[at(axis_)] = b.origin[at(axis_)];
        p[s] = low[s] + length[s] * i / cells[s];
        p[t] = low[t] + length[t] * j / cells[t];
        const double weight = (i == 0 || i == cells[s] ? 0.5 : 1.0) * (j == 0 || j == cells[t] ? 0.5 : 1.0);
        add({joint.block_a, -1}, {joint.block_b, -1}, weight * length[s] * length[t] / (cells[s] * cells[t]), p);
      }
    }
  }

  const Assembly& assembly_;
  const std::vector<BrickTemplate>& templates_;
  const std::vector<int>& template_of_;
  std::vector<NewPoint> points_;
  int joint_ = 0, family_ = 0, axis_ = 0;
  double tolerance_ = 0.0;
};

Vec3 offset_between(const Assembly& assembly, int first, int block) {
  const Vec3 &from = assembly.bricks[at(first)].origin, &to = assembly.bricks[at(block)].origin;
  return {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
}

// Units that are alike: the same templates at the same distance.
struct UnitClass {
  std::vector<std::vector<int>> units;  // blocks of each
};

// Deformable blocks by unit, in the order of their first blocks. Blocks of a unit that is cut into more than two stand
// alone.
std::vector<UnitClass> unit_classes(const Assembly& assembly, const std::vector<int>& template_of) {
  std::map<int, std::vector<int>> blocks_of;
  for (std::size_t i = 0; i < assembly.bricks.size(); ++i) {
    if (!assembly.bricks[i].rigid && assembly.bricks[i].unit >= 0)
      blocks_of[assembly.bricks[i].unit].push_back(static_cast<int>(i));
  }
  std::vector<UnitClass> classes;
  const auto alike = [&](const std::vector<int>& x, const std::vector<int>& y) {
    for (std::size_t b = 0; b < std::min(x.size(), y.size()); ++b) {
      if (template_of[at(x[b])] != template_of[at(y[b])]) return false;
      const Brick& brick = assembly.bricks[at(x[b])];
      const double tolerance = 1e-9 * *std::max_element(brick.size.begin(), brick.size.end());
      const Vec3 p = offset_between(assembly, x[0], x[b]), q = offset_between(assembly, y[0], y[b]);
      for (std::size_t c = 0; c < 3; ++c) {
        if (std::abs(p[c] - q[c]) > tolerance) return false;
      }
    }
    return x.size() == y.size();
  };
  for (std::size_t i = 0; i < assembly.bricks.size(); ++i) {
    const Brick& brick = assembly.bricks[i];
    if (brick.rigid) continue;
    std::vector<int> unit{static_cast<int>(i)};
    if (brick.unit >= 0 && blocks_of[brick.unit].size() == kUnitBlocks) unit = blocks_of[brick.unit];
    if (unit[0] != static_cast<int>(i)) continue;
    const auto found =
        std::find_if(classes.begin(), classes.end(), [&](const UnitClass& c) { return alike(c.units[0], unit); });
    (found == classes.end() ? classes.emplace_back() : *found).units.push_back(unit);
  }
  return classes;
}

void check_input(const Assembly& assembly) {
  for (std::size_t i = 0; i < assembly.bricks.size(); ++i) {
    const Brick& brick = assembly.bricks[i];
    if (brick.material < 0 || at(brick.material) >= assembly.materials.size()) {
      throw Error(Exit::bad_input, fmt::format("block {}: material {} does not exist", i, brick.material));
    }
    const BlockMaterial& material = assembly.materials[at(brick.material)];
    for (std::size_t c = 0; c < 3; ++c) {
      if (!(brick.size[c] > 0.0) || brick.zones[c] < 1) {
        throw Error(Exit::bad_input, fmt::format("block {}: size {} m and zones {} along axis {} must be positive", i,
                                                 brick.size[c], brick.zones[c], c));
      }
    }
    if (!(material.density > 0.0)) {
      throw Error(Exit::bad_input,
                  fmt::format("material '{}': density {} kg/m3 must be positive", material.name, material.density));
    }
    if (!brick.rigid &&
        (!(material.young_modulus > 0.0) || !(material.poisson_ratio > -1.0 && material.poisson_ratio < 0.5))) {
      throw Error(Exit::bad_input,
                  fmt::format("material '{}': Young's modulus {} Pa must be positive and Poisson's ratio "
                              "{} between -1 and 0.5",
                              material.name, material.young_modulus, material.poisson_ratio));
    }
  }
  for (std::size_t j = 0; j < assembly.joints.size(); ++j) {
    const Joint& joint = assembly.joints[j];
    const auto bad = [&](int block) { return block < 0 || at(block) >= assembly.bricks.size(); };
    if (bad(joint.block_a) || bad(joint.block_b) || joint.block_a == joint.block_b || joint.face_a < 0 ||
        joint.face_a > 5 || joint.family < 0 || at(joint.family) >= assembly.families.size()) {
      throw Error(Exit::bad_input,
                  fmt::format("joint {}: blocks {} and {}, face {}, family {}: no such block, face or family", j,
                              joint.block_a, joint.block_b, joint.face_a, joint.family));
    }
  }
}

// A model from its assembly, step by step; each needs those before it.
class ModelBuilder {
 public:
  explicit ModelBuilder(Model& model) : m(model) {}

  void build(const std::vector<std::shared_ptr<const Material>>& materials) {
    place_blocks();
    group_units();
    points_ = PointFinder(m.assembly, m.templates, template_of_).find();
    group_bodies();
    give_points_their_slots();
    order_points();
    attach_points();
    note_runs_of_points();
    make_families(materials);
    make_chunks();
    const std::vector<PointsOfNode> points_of = points_of_blocks();
    fill_slots_of_blocks(points_of, widths_of_slots(points_of));
    fill_slots_of_bodies();
    note_runs_of_slots();
    lay_out_gridpoints();
  }

 private:
  struct BodyPlace {
    int group = -1, lane = -1;
  };
  // By gridpoint of a block's template and by face: its contact points; how many places there are for them.
  using PointsOfNode = std::vector<std::array<std::vector<std::int32_t>, 6>>;
  using SlotWidths = std::vector<std::array<std::size_t, 6>>;

  int body_of(const Side& side) const { return m.place[at(side.block)].body; }  // -1: deformable

  // Of a gridpoint, or of the slave of a body in a group.
  std::int32_t offset_of(const Side& side) const {
    const Model::BlockPlace& where = m.place[at(side.block)];
    if (where.body >= 0) {
      const BodyPlace& lane = body_place_[at(where.body)];
      return (m.body_groups[at(lane.group)].first_line + side.node) * kLine + lane.lane;
    }
    return (m.groups[at(where.group)].first_line + side.node) * kLine + where.lane;
  }

  // Deformable ones learn their template, rigid ones their body.
  void place_blocks() {
    template_of_.assign(m.assembly.bricks.size(), -1);
    m.place.resize(m.assembly.bricks.size());
    for (std::size_t i = 0; i < m.assembly.bricks.size(); ++i) {
      const Brick& brick = m.assembly.bricks[i];
      if (brick.rigid) {
        RigidBody body;
        body.block = static_cast<int>(i);
        body.name = brick.body;
        const auto& [lx, ly, lz] = brick.size;
        body.centre = {brick.origin[0] + 0.5 * lx, brick.origin[1] + 0.5 * ly, brick.origin[2] + 0.5 * lz};
        body.mass = m.assembly.materials[at(brick.material)].density * lx * ly * lz;
        body.inertia = {body.mass * (ly * ly + lz * lz) / 12.0, body.mass * (lz * lz + lx * lx) / 12.0,
                        body.mass * (lx * lx + ly * ly) / 12.0};
        if (m.assembly.symmetry_plane_z0 && std::abs(brick.origin[2]) <= kCoordinateTolerance * lz) {
          body.held = {false, false, true, true, true, false};
        }
        m.place[i].body = static_cast<int>(m.bodies.size());
        m.bodies.push_back(std::move(body));
        continue;
      }
      const auto found =
          std::find_if(m.templates.begin(), m.templates.end(), [&](const auto& t) { return same_template(t, brick); });
      template_of_[i] = static_cast<int>(found - m.templates.begin());
      if (found == m.templates.end())
        m.templates.push_back(make_brick_template(brick, m.assembly.materials[at(brick.material)]));
    }
  }

  // Unit i of n goes to lane i / G of unit group i mod G, G = ceil(n/8): neighbours in the order of the assembly share
  // a lane, so that a joint which a regular wall repeats joins the same two gridpoints in all lanes and needs no
  // gathers.
  void group_units() {
    for (const UnitClass& kind : unit_classes(m.assembly, template_of_)) {
      const std::size_t count = kind.units.size(), group_count = (count + kLanes - 1) / kLanes;
      const std::size_t first_group = m.groups.size(), block_count = kind.units[0].size();
      for (std::size_t g = 0; g < group_count; ++g) {
        m.unit_groups.push_back({static_cast<int>(m.groups.size()), static_cast<int>(block_count)});
        for (std::size_t b = 0; b < block_count; ++b) {
          BlockGroup group;
          group.brick_template = template_of_[at(kind.units[0][b])];
          group.offset = offset_between(m.assembly, kind.units[0][0], kind.units[0][b]);
          group.first_line = m.line_count;
          m.groups.push_back(group);
          m.line_count += m.templates[at(group.brick_template)].node_count;
        }
      }
      for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t b = 0; b < block_count; ++b) {
          const int block = kind.units[i][b];
          Model::BlockPlace& where = m.place[at(block)];
          where.group = static_cast<int>(first_group + i % group_count * block_count + b);
          where.lane = static_cast<int>(i / group_count);
          m.groups[at(where.group)].block[at(where.lane)] = block;
          m.groups[at(where.group)].block_count = where.lane + 1;
        }
      }
    }
    m.block_line_count = m.line_count;
  }

  std::vector<std::vector<BodyPoint>> points_of_bodies() const {
    const auto as_seen_by = [&](const RigidBody& body, const NewPoint& p, bool side_a) {
      const Vec3 &x = p.position, &centre = body.centre;
      return BodyPoint{2 * p.axis + (side_a ? 1 : 0), {x[0] - centre[0], x[1] - centre[1], x[2] - centre[2]}};
    };
    std::vector<std::vector<BodyPoint>> seen(m.bodies.size());
    for (const NewPoint& p : points_) {
      const int a = body_of(p.a), b = body_of(p.b);
      if (a >= 0) seen[at(a)].push_back(as_seen_by(m.bodies[at(a)], p, true));
      if (b >= 0) seen[at(b)].push_back(as_seen_by(m.bodies[at(b)], p, false));
    }
    return seen;
  }

  // Bodies that are alike into groups of 8 lanes.
  void group_bodies() {
    body_place_.resize(m.bodies.size());
    next_slot_.resize(m.bodies.size());
    for (const BodyClass& kind : body_classes(m.bodies, points_of_bodies())) {
      BodySlots& places = m.body_slots.emplace_back();
      for (const BodyPoint& slot : kind.slot) {
        const std::size_t axis = at(slot.face / 2);
        places.arm.push_back({slot.arm[(axis + 1) % 3], slot.arm[(axis + 2) % 3]});
        places.face[at(slot.face)].normal_arm = slot.arm[axis];
      }
      for (int face = 0; face < 6; ++face) places.face[at(face)].slot_end = kind.first_slot(face + 1);
      // Body i goes to lane i / G of group i mod G, as units do.
      const int first_group = static_cast<int>(m.body_groups.size());
      const int count = (static_cast<int>(kind.body.size()) + kLanes - 1) / kLanes;
      for (int g = 0; g < count; ++g) {
        BodyGroup group;
        group.slots = static_cast<int>(m.body_slots.size()) - 1;
        group.first_line = m.line_count;
        m.line_count += places.slot_count();
        group.body.fill(kind.body[at(g)]);
        m.body_groups.push_back(group);
      }
      for (int i = 0; i < static_cast<int>(kind.body.size()); ++i) {
        const int body = kind.body[at(i)];
        BodyPlace& where = body_place_[at(body)];
        where = {first_group + i % count, i / count};
        m.body_groups[at(where.group)].body[at(where.lane)] = body;
        m.body_groups[at(where.group)].body_count = where.lane + 1;
        // A face that the body uses has the points of the class in the same order.
        for (int face = 0; face < 6; ++face) next_slot_[at(body)][at(face)] = kind.first_slot(face);
      }
    }
    for (std::size_t b = 0; b < m.bodies.size(); ++b) {
      if (body_place_[b].group < 0) m.lone_bodies.push_back(static_cast<int>(b));
    }
  }

  void give_points_their_slots() {
    for (NewPoint& p : points_) {
      for (Side* side : {&p.a, &p.b}) {
        const int body = body_of(*side);
        if (body >= 0 && body_place_[at(body)].group >= 0)
          side->node = next_slot_[at(body)][at(2 * p.axis + (side == &p.a ? 1 : 0))]++;
      }
    }
  }

  void order_points() {
    std::vector<PointEnds> ends;
    for (const NewPoint& p : points_)
      ends.push_back(
          {p.family, p.axis, p.joint, p.a.node >= 0 ? offset_of(p.a) : -1, p.b.node >= 0 ? offset_of(p.b) : -1});
    std::vector<NewPoint> sorted;
    for (const std::size_t i : point_order(ends)) sorted.push_back(points_[i]);
    points_.swap(sorted);
    m.point_count = static_cast<std::int32_t>(points_.size());
  }

  // Slaves of lone bodies go behind all other lines.
  void attach_points() {
    const std::int32_t grouped_lines = m.line_count;
    std::int32_t lone_slave_count = 0;
    for (std::int32_t i = 0; i < m.point_count; ++i) {
      const NewPoint& p = points_[at(i)];
      const auto attach = [&](const Side& side, double sign) {
        if (body_of(side) < 0) return offset_of(side);
        std::int32_t offset = (grouped_lines + lone_slave_count / kLanes) * kLine + lone_slave_count % kLanes;
        if (side.node >= 0)
          offset = offset_of(side);
        else
          ++lone_slave_count;
        RigidBody& body = m.bodies[at(m.place[at(side.block)].body)];
        body.point.push_back(i);
        body.slave.push_back(offset);
        body.arm.push_back(
            {p.position[0] - body.centre[0], p.position[1] - body.centre[1], p.position[2] - body.centre[2]});
        body.sign.push_back(sign);
        return offset;
      };
      m.node_a.push_back(attach(p.a, +1.0));
      m.node_b.push_back(attach(p.b, -1.0));
      m.area.push_back(p.area);
      m.point_joint.push_back(p.joint);
      m.point_position.push_back(p.position);
      m.point_axis.push_back(static_cast<std::uint8_t>(p.axis));
    }
    m.line_count = grouped_lines + (lone_slave_count + kLanes - 1) / kLanes;
  }

  void note_runs_of_points() {
    m.point_run.assign(at(m.point_count), 1);
    for (int i = m.point_count - 2; i >= 0; --i) {
      const bool in_step = m.node_a[at(i + 1)] == m.node_a[at(i)] + 1 && m.node_b[at(i + 1)] == m.node_b[at(i)] + 1;
      if (in_step && m.point_run[at(i + 1)] < kLanes)
        m.point_run[at(i)] = static_cast<std::uint8_t>(m.point_run[at(i + 1)] + 1);
      else if (in_step)
        m.point_run[at(i)] = kLanes;
    }
  }

  void make_families(const std::vector<std::shared_ptr<const Material>>& materials) {
    for (std::size_t f = 0; f < m.assembly.families.size(); ++f) {
      ContactFamily family;
      family.name = m.assembly.families[f].name;
      family.material = materials[f];
      const quoin_stiffness_bounds bounds = family.material->stiffness_bounds();
      family.normal_stiffness = bounds.normal;
      family.shear_stiffness = bounds.shear;
      family.first_point = m.families.empty() ? 0 : m.families.back().first_point + m.families.back().point_count;
      while (family.first_point + family.point_count < m.point_count &&
             points_[at(family.first_point + family.point_count)].family == static_cast<int>(f)) {
        ++family.point_count;
      }
      m.families.push_back(family);
    }
  }

  void make_chunks() {
    for (std::int32_t i = 0; i < m.point_count; ++i) {
      const NewPoint& p = points_[at(i)];
      if (m.chunks.empty() || m.chunks.back().family != p.family || m.chunks.back().axis != p.axis ||
          m.chunks.back().point_count == kChunk) {
        m.chunks.push_back({p.family, p.axis, i, 0});
      }
      ++m.chunks.back().point_count;
    }
  }

  std::vector<PointsOfNode> points_of_blocks() const {
    std::vector<PointsOfNode> points_of(m.assembly.bricks.size());
    for (std::size_t i = 0; i < m.assembly.bricks.size(); ++i) {
      if (template_of_[i] >= 0) points_of[i].resize(m.templates[at(template_of_[i])].node.size());
    }
    for (std::int32_t i = 0; i < m.point_count; ++i) {
      const NewPoint& p = points_[at(i)];
      if (body_of(p.a) < 0) points_of[at(p.a.block)][at(p.a.node)][at(2 * p.axis + 1)].push_back(i);
      if (body_of(p.b) < 0) points_of[at(p.b.block)][at(p.b.node)][at(2 * p.axis)].push_back(i);
    }
    return points_of;
  }

  // For each gridpoint of a template and each of its faces as many slots as its busiest block needs.
  std::vector<SlotWidths> widths_of_slots(const std::vector<PointsOfNode>& points_of) {
    m.slots.resize(m.templates.size());
    std::vector<SlotWidths> width(m.templates.size());
    for (std::size_t t = 0; t < m.templates.size(); ++t) {
      width[t].resize(m.templates[t].node.size());
      for (std::size_t i = 0; i < m.assembly.bricks.size(); ++i) {
        if (template_of_[i] != static_cast<int>(t)) continue;
        for (std::size_t n = 0; n < width[t].size(); ++n) {
          for (std::size_t face = 0; face < 6; ++face)
            width[t][n][face] = std::max(width[t][n][face], points_of[i][n][face].size());
        }
      }
      for (const auto& faces : width[t]) {
        for (std::size_t face = 0; face < 6; ++face)
          m.slots[t].sign.insert(m.slots[t].sign.end(), faces[face], face % 2 == 1 ? 1.0 : -1.0);
        m.slots[t].slot_end.push_back(m.slots[t].slot_count());
      }
    }
    return width;
  }

  void fill_slots_of_blocks(const std::vector<PointsOfNode>& points_of, const std::vector<SlotWidths>& width) {
    for (BlockGroup& group : m.groups) {
      const std::size_t t = at(group.brick_template);
      group.first_slot = static_cast<std::int32_t>(m.slot_point.size()) / kLanes;
      m.slot_point.resize(m.slot_point.size() + at(m.slots[t].slot_count() * kLanes), m.point_count);
      for (int lane = 0; lane < group.block_count; ++lane) {
        int slot = group.first_slot;
        for (std::size_t n = 0; n < width[t].size(); ++n) {
          for (std::size_t face = 0; face < 6; ++face) {
            const auto& here = points_of[at(group.block[at(lane)])][n][face];
            for (std::size_t i = 0; i < here.size(); ++i)
              m.slot_point[at((slot + static_cast<int>(i)) * kLanes + lane)] = here[i];
            slot += static_cast<int>(width[t][n][face]);
          }
        }
      }
    }
  }

  void fill_slots_of_bodies() {
    for (BodyGroup& group : m.body_groups) {
      group.first_slot = static_cast<std::int32_t>(m.slot_point.size()) / kLanes;
      m.slot_point.resize(m.slot_point.size() + at(m.body_slots[at(group.slots)].slot_count() * kLanes), m.point_count);
    }
    for (std::int32_t i = 0; i < m.point_count; ++i) {
      for (const Side& side : {points_[at(i)].a, points_[at(i)].b}) {
        if (body_of(side) < 0 || side.node < 0) continue;
        const BodyPlace& where = body_place_[at(body_of(side))];
        m.slot_point[at((m.body_groups[at(where.group)].first_slot + side.node) * kLanes + where.lane)] = i;
      }
    }
  }

  void note_runs_of_slots() {
    const auto add_runs = [&](int first_slot, int slot_count, int lanes_in_use) {
      for (int slot = first_slot; slot < first_slot + slot_count; ++slot) {
        const std::int32_t* point = m.slot_point.data() + slot * kLanes;
        bool in_step = true;
        for (int lane = 1; lane < lanes_in_use; ++lane) in_step = in_step && point[lane] == point[0] + lane;
        const bool empty = std::all_of(point, point + kLanes, [&](std::int32_t p) { return p == m.point_count; });
        m.slot_run.push_back(empty ? Model::kEmptySlot : in_step ? point[0] : -1);
      }
    };
    for (const BlockGroup& group : m.groups)
      add_runs(group.first_slot, m.slots[at(group.brick_template)].slot_count(), kLanes);
    // What lanes without a body read does not matter: nothing of them is kept.
    for (const BodyGroup& group : m.body_groups)
      add_runs(group.first_slot, m.body_slots[at(group.slots)].slot_count(), group.body_count);
  }

  // Positions, masses, constraints.
  void lay_out_gridpoints() {
    m.position.assign(at(m.line_count * kLanes), Vec3{});
    m.node_mass.assign(at(m.line_count * kLine), 0.0);
    m.node_free.assign(at(m.line_count * kLine), 0.0);
    for (const BlockGroup& group : m.groups) {
      const BrickTemplate& shape = m.templates[at(group.brick_template)];
      for (int n = 0; n < shape.node_count; ++n) {
        for (int lane = 0; lane < group.block_count; ++lane) {
          const Brick& brick = m.assembly.bricks[at(group.block[at(lane)])];
          Vec3& p = m.position[at((group.first_line + n) * kLanes + lane)];
          for (std::size_t c = 0; c < 3; ++c) p[c] = brick.origin[c] + shape.node[at(n)][c];
          const bool on_symmetry_plane =
              m.assembly.symmetry_plane_z0 && std::abs(p[2]) <= kCoordinateTolerance * brick.size[2];
          for (int c = 0; c < 3; ++c) {
            const std::size_t i = at((group.first_line + n) * kLine + kLanes * c + lane);
            m.node_mass[i] = shape.node_mass[at(n)];
            m.node_free[i] = c == 2 && on_symmetry_plane ? 0.0 : 1.0;
          }
        }
      }
    }
    for (const RigidBody& body : m.bodies) {
      for (std::size_t i = 0; i < body.slave.size(); ++i) {
        m.position[at(body.slave[i] / kLine * kLanes + body.slave[i] % kLanes)] = m.point_position[at(body.point[i])];
      }
    }
  }

  Model& m;
  std::vector<int> template_of_;  // by block; -1: rigid
  std::vector<NewPoint> points_;
  std::vector<BodyPlace> body_place_;          // by body; none: a lone body
  std::vector<std::array<int, 6>> next_slot_;  // by body and face
};

// Properties that scatter, now that it is known where the points are.
void draw_columns(Model& m) {
  std::vector<PlacedBlock> blocks;
  for (const Brick& brick : m.assembly.bricks) blocks.push_back({brick.unit, brick.course});
  for (std::size_t f = 0; f < m.families.size(); ++f) {
    const JointFamily& description = m.assembly.families[f];
    ContactFamily& family = m.families[f];
    if (!description.scatters()) continue;
    std::vector<PlacedPoint> points;
    for (int i = family.first_point; i < family.first_point + family.point_count; ++i) {
      const Joint& joint = m.assembly.joints[at(m.point_joint[at(i)])];
      points.push_back({m.point_position[at(i)], m.area[at(i)], joint.block_a, joint.block_b});
    }
    family.columns = draw_properties(description, *family.material, points, blocks);
    const quoin_stiffness_bounds bounds = stiffness_bounds_of(description, *family.material, family.columns);
    family.normal_stiffness = bounds.normal, family.shear_stiffness = bounds.shear;
  }
}

}  // namespace

std::vector<std::shared_ptr<const Material>> make_materials(const Assembly& assembly) {
  std::vector<std::shared_ptr<const Material>> materials;
  for (const JointFamily& family : assembly.families) {
    materials.push_back(std::make_shared<const Material>(Law::find(family.law), family.properties));
  }
  return materials;
}

Model::Model(Assembly input, std::vector<std::shared_ptr<const Material>> materials) : assembly(std::move(input)) {
  check_input(assembly);
  if (materials.size() != assembly.families.size()) {
    throw Error(Exit::bad_input,
                fmt::format("{} joint families, but {} materials", assembly.families.size(), materials.size()));
  }
  ModelBuilder(*this).build(materials);
  draw_columns(*this);
}

std::vector<int> Model::bodies_named(const std::string& name) const {
  std::vector<int> found;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (!name.empty() && bodies[i].name == name) found.push_back(static_cast<int>(i));
  }
  return found;
}

std::vector<int> Model::deformable_blocks_named(const std::string& name) const {
  std::vector<int> found;
  for (std::size_t i = 0; i < assembly.bricks.size(); ++i) {
    if (!name.empty() && !assembly.bricks[i].rigid && assembly.bricks[i].body == name)
      found.push_back(static_cast<int>(i));
  }
  return found;
}

double Model::total_mass() const {
  double mass = 0.0;
  for (const BlockGroup& group : groups) {
    const auto& m = templates[at(group.brick_template)].node_mass;
    mass += group.block_count * std::accumulate(m.begin(), m.end(), 0.0);
  }
  for (const RigidBody& body : bodies) mass += body.mass;
  return mass;
}

std::size_t Model::zone_count() const {
  std::size_t count = 0;
  for (const BlockGroup& group : groups)
    count += at(group.block_count) * templates[at(group.brick_template)].zone.size();
  return count;
}

}  // namespace quoin
