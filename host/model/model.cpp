#include "model/model.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "base/error.h"
#include "base/index.h"
#include "model/body_groups.h"
#include "model/point_finder.h"
#include "model/point_order.h"
#include "model/scattered_points.h"

namespace quoin {
namespace {

bool same_template(const BrickTemplate& t, const Brick& brick) {
  const double tolerance = 1e-9 * *std::max_element(brick.size.begin(), brick.size.end());
  for (std::size_t c = 0; c < 3; ++c) {
    if (std::abs(t.size[c] - brick.size[c]) > tolerance) return false;
  }
  return t.zones == brick.zones && t.parity == brick.parity && t.material == brick.material;
}

Vec3 offset_between(const Assembly& assembly, int first, int block) {
  return assembly.bricks[at(block)].origin - assembly.bricks[at(first)].origin;
}

// Congruent units: the same templates at the same offsets.
struct UnitClass {
  std::vector<std::vector<int>> units;  // blocks of each unit
};

// Deformable blocks by unit, in the order of their first blocks. Where a unit is cut into more than two blocks, each of
// them is a unit by itself.
std::vector<UnitClass> unit_classes(const Assembly& assembly, const std::vector<int>& template_of) {
  std::map<int, std::vector<int>> blocks_of;
  for (std::size_t i = 0; i < assembly.bricks.size(); ++i) {
    if (!assembly.bricks[i].rigid && assembly.bricks[i].unit >= 0)
      blocks_of[assembly.bricks[i].unit].push_back(static_cast<int>(i));
  }
  std::vector<UnitClass> classes;
  const auto congruent = [&](const std::vector<int>& x, const std::vector<int>& y) {
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
        std::find_if(classes.begin(), classes.end(), [&](const UnitClass& c) { return congruent(c.units[0], unit); });
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

// Marks slots whose lanes in use have consecutive points.
void note_runs_of_slots(Model& m, int first_slot, int slot_count, int lanes_in_use) {
  for (int slot = first_slot; slot < first_slot + slot_count; ++slot) {
    const std::int32_t* point = m.slot_point.data() + slot * kLanes;
    bool in_step = true;
    for (int lane = 1; lane < lanes_in_use; ++lane) in_step = in_step && point[lane] == point[0] + lane;
    const bool empty = std::all_of(point, point + kLanes, [&](std::int32_t p) { return p == m.point_count; });
    m.slot_run[at(slot)] = empty ? Model::kEmptySlot : in_step ? point[0] : -1;
  }
}

// Builds the outline of a model from its assembly; each step needs those before it.
class ModelBuilder {
 public:
  explicit ModelBuilder(Model& model) : m(model) {}

  void build(const std::vector<std::shared_ptr<const Material>>& materials) {
    place_blocks();
    group_units();
    find_points();
    group_bodies();
    give_points_their_slots();
    make_families(materials);
    order_points();
    make_chunks();
    attach_bodies();
    widen_slots();
    fill_slots_of_bodies();
    size_arrays();
  }

 private:
  struct BodyPlace {
    int group = -1, lane = -1;
  };
  // A contact point before it has a number: gridpoints of templates, slots of bodies in groups, -1 for lone bodies.
  struct Nodes {
    std::int32_t a, b;
  };

  int body_of(const Side& side) const { return body_of(side.block); }
  int body_of(int block) const { return m.place[at(block)].body; }  // -1: deformable

  // Offset of a gridpoint, or of the slave of a body in a group; -1: the side of a lone body.
  std::int32_t offset_if_any(int block, std::int32_t node) const {
    const Model::BlockPlace& where = m.place[at(block)];
    if (node < 0) return -1;
    if (where.body >= 0) {
      const BodyPlace& lane = body_place_[at(where.body)];
      return (m.body_groups[at(lane.group)].first_line + node) * kLine + lane.lane;
    }
    return (m.groups[at(where.group)].first_line + node) * kLine + where.lane;
  }

  // Sets the template of deformable blocks, and the body of rigid ones.
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
        if (brick.load_height) body.centre[1] = *brick.load_height;
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

  // Unit i of n is in lane i / G of unit group i mod G, G = ceil(n/8). So neighbours in the order of the assembly share
  // a lane. A joint that a regular wall repeats then joins the same two gridpoints in all lanes and needs no gathers.
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

  // Finds all contact points. It stores those of bodies in full, as they are part of the outline.
  void find_points() {
    PointFinder finder(m);
    for (std::size_t j = 0; j < m.assembly.joints.size(); ++j) {
      first_of_joint_.push_back(static_cast<std::int32_t>(nodes_.size()));
      for (const NewPoint& p : finder.find(j)) {
        if (body_of(p.a) >= 0 || body_of(p.b) >= 0) {
          found_of_bodies_.push_back(static_cast<std::int32_t>(nodes_.size()));
          of_bodies_.push_back(p);
        }
        nodes_.push_back({p.a.node, p.b.node});
      }
    }
    m.point_count = static_cast<std::int32_t>(nodes_.size());
  }

  std::vector<std::vector<BodyPoint>> points_of_bodies() const {
    const auto as_seen_by = [&](const RigidBody& body, const NewPoint& p, bool side_a) {
      return BodyPoint{2 * p.axis + (side_a ? 1 : 0), p.position - body.centre};
    };
    std::vector<std::vector<BodyPoint>> seen(m.bodies.size());
    for (const NewPoint& p : of_bodies_) {
      const int a = body_of(p.a), b = body_of(p.b);
      if (a >= 0) seen[at(a)].push_back(as_seen_by(m.bodies[at(a)], p, true));
      if (b >= 0) seen[at(b)].push_back(as_seen_by(m.bodies[at(b)], p, false));
    }
    return seen;
  }

  // Puts congruent bodies into groups of 8 lanes.
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
      // Body i is in lane i / G of group i mod G, as units are.
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
    for (std::size_t i = 0; i < of_bodies_.size(); ++i) {
      Nodes& nodes = nodes_[at(found_of_bodies_[i])];
      for (const bool side_a : {true, false}) {
        const int body = body_of(side_a ? of_bodies_[i].a : of_bodies_[i].b);
        if (body >= 0 && body_place_[at(body)].group >= 0)
          (side_a ? nodes.a : nodes.b) = next_slot_[at(body)][at(2 * of_bodies_[i].axis + (side_a ? 1 : 0))]++;
      }
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
      m.families.push_back(family);
    }
  }

  // Orders points family by family and axis by axis, as they are stored. An order of all at once would take more
  // memory.
  void order_points() {
    m.point_joint.reserve(nodes_.size());
    m.point_in_joint.reserve(nodes_.size());
    for (std::size_t f = 0; f < m.families.size(); ++f) {
      m.families[f].first_point = static_cast<std::int32_t>(m.point_joint.size());
      for (int axis = 0; axis < 3; ++axis) {
        const auto is_here = [&](const Joint& joint) { return at(joint.family) == f && joint.face_a / 2 == axis; };
        std::size_t count = 0;
        for (std::size_t j = 0; j < m.assembly.joints.size(); ++j)
          count += is_here(m.assembly.joints[j]) ? at(end_of_joint(j) - first_of_joint_[j]) : 0;
        std::vector<PointEnds> ends;
        std::vector<std::int32_t> in_joint;
        ends.reserve(count), in_joint.reserve(count);
        for (std::size_t j = 0; j < m.assembly.joints.size(); ++j) {
          const Joint& joint = m.assembly.joints[j];
          if (!is_here(joint)) continue;
          const Model::Sides sides = Model::sides_of(joint);
          for (std::int32_t i = first_of_joint_[j]; i < end_of_joint(j); ++i) {
            const Nodes& nodes = nodes_[at(i)];
            ends.push_back({joint.family, axis, static_cast<int>(j), offset_if_any(sides.a, nodes.a),
                            offset_if_any(sides.b, nodes.b)});
            in_joint.push_back(i - first_of_joint_[j]);
          }
        }
        for (const std::uint32_t i : point_order(ends)) {
          m.point_joint.push_back(ends[i].joint);
          m.point_in_joint.push_back(in_joint[i]);
        }
      }
      m.families[f].point_count = static_cast<std::int32_t>(m.point_joint.size()) - m.families[f].first_point;
    }
  }

  void make_chunks() {
    for (std::int32_t i = 0; i < m.point_count; ++i) {
      const Joint& joint = m.assembly.joints[at(m.point_joint[at(i)])];
      const int axis = joint.face_a / 2;
      if (m.chunks.empty() || m.chunks.back().family != joint.family || m.chunks.back().axis != axis ||
          m.chunks.back().point_count == kChunk) {
        m.chunks.push_back({joint.family, axis, i, 0});
      }
      ++m.chunks.back().point_count;
    }
  }

  // Gives bodies their points and slaves. Slaves of lone bodies follow all other lines.
  void attach_bodies() {
    const std::int32_t grouped_lines = m.line_count;
    std::int32_t lone_slave_count = 0;
    for (std::int32_t i = 0; i < m.point_count; ++i) {
      const Model::Sides sides = m.sides_of(i);
      if (body_of(sides.a) < 0 && body_of(sides.b) < 0) continue;
      const std::int32_t found = first_of_joint_[at(m.point_joint[at(i)])] + m.point_in_joint[at(i)];
      const auto there = std::lower_bound(found_of_bodies_.begin(), found_of_bodies_.end(), found);
      const Vec3& position = of_bodies_[at(static_cast<int>(there - found_of_bodies_.begin()))].position;
      const auto attach = [&](int block, std::int32_t node, double sign) {
        if (body_of(block) < 0) return;
        std::int32_t offset = offset_if_any(block, node);
        if (offset < 0) {
          offset = (grouped_lines + lone_slave_count / kLanes) * kLine + lone_slave_count % kLanes;
          ++lone_slave_count;
        }
        RigidBody& body = m.bodies[at(body_of(block))];
        body.point.push_back(i);
        body.slave.push_back(offset);
        body.arm.push_back(position - body.centre);
        body.sign.push_back(sign);
      };
      attach(sides.a, nodes_[at(found)].a, +1.0);
      attach(sides.b, nodes_[at(found)].b, -1.0);
    }
    m.line_count = grouped_lines + (lone_slave_count + kLanes - 1) / kLanes;
  }

  // Gives each gridpoint of a template, on each of its faces, as many slots as its busiest block needs.
  void widen_slots() {
    std::vector<std::size_t> first_node{0};
    for (std::size_t i = 0; i < m.assembly.bricks.size(); ++i) {
      const bool deformable = body_of(static_cast<int>(i)) < 0;
      first_node.push_back(first_node.back() + (deformable ? m.template_of(static_cast<int>(i)).node.size() : 0));
    }
    std::vector<std::array<std::uint16_t, 6>> points_of_node(first_node.back());
    for (std::size_t j = 0; j < m.assembly.joints.size(); ++j) {
      const Joint& joint = m.assembly.joints[j];
      const Model::Sides sides = Model::sides_of(joint);
      const std::size_t axis = at(joint.face_a / 2);
      for (std::int32_t i = first_of_joint_[j]; i < end_of_joint(j); ++i) {
        const Nodes& nodes = nodes_[at(i)];
        if (body_of(sides.a) < 0) ++points_of_node[first_node[at(sides.a)] + at(nodes.a)][2 * axis + 1];
        if (body_of(sides.b) < 0) ++points_of_node[first_node[at(sides.b)] + at(nodes.b)][2 * axis];
      }
    }
    std::vector<std::vector<std::array<std::uint16_t, 6>>> width;
    for (const BrickTemplate& shape : m.templates) width.emplace_back(shape.node.size());
    for (std::size_t i = 0; i < m.assembly.bricks.size(); ++i) {
      if (body_of(static_cast<int>(i)) >= 0) continue;
      auto& widest = width[at(m.groups[at(m.place[i].group)].brick_template)];
      for (std::size_t n = 0; n < widest.size(); ++n) {
        for (std::size_t face = 0; face < 6; ++face)
          widest[n][face] = std::max(widest[n][face], points_of_node[first_node[i] + n][face]);
      }
    }
    m.slots.resize(m.templates.size());
    for (std::size_t t = 0; t < m.templates.size(); ++t) {
      for (const auto& faces : width[t]) {
        for (std::size_t face = 0; face < 6; ++face) {
          m.slots[t].sign.insert(m.slots[t].sign.end(), faces[face], face % 2 == 1 ? 1.0 : -1.0);
          m.slots[t].face.insert(m.slots[t].face.end(), faces[face], static_cast<std::uint8_t>(face));
        }
        m.slots[t].slot_end.push_back(m.slots[t].slot_count());
      }
    }
    std::int32_t slots = 0;
    for (BlockGroup& group : m.groups) {
      group.first_slot = slots;
      slots += m.slots[at(group.brick_template)].slot_count();
    }
    for (BodyGroup& group : m.body_groups) {
      group.first_slot = slots;
      slots += m.body_slots[at(group.slots)].slot_count();
    }
    m.slot_point = LaneVector<std::int32_t>(at(slots) * kLanes);
    m.slot_run = LaneVector<std::int32_t>(at(slots));
  }

  void fill_slots_of_bodies() {
    for (const BodyGroup& group : m.body_groups) {
      const int slots = m.body_slots[at(group.slots)].slot_count();
      std::fill_n(m.slot_point.begin() + group.first_slot * kLanes, slots * kLanes, m.point_count);
      for (int lane = 0; lane < group.body_count; ++lane) {
        const RigidBody& body = m.bodies[at(group.body[at(lane)])];
        for (std::size_t i = 0; i < body.point.size(); ++i) {
          const int slot = group.first_slot + body.slave[i] / kLine - group.first_line;
          m.slot_point[at(slot * kLanes + lane)] = body.point[i];
        }
      }
      // Lanes without a body may read any point, as their results are not stored.
      note_runs_of_slots(m, group.first_slot, slots, group.body_count);
    }
  }

  void size_arrays() {
    const std::size_t points = at(m.point_count), doubles = at(m.line_count) * kLine;
    m.node_mass = m.node_free = LaneVector<double>(doubles);
    m.node_a = m.node_b = LaneVector<std::int32_t>(points);
    m.area = LaneVector<double>(points);
    m.point_run = m.point_axis = LaneVector<std::uint8_t>(points);
    m.point_position = LaneVector<Vec3>(points);
  }

  std::int32_t end_of_joint(std::size_t j) const {
    return j + 1 < first_of_joint_.size() ? first_of_joint_[j + 1] : static_cast<std::int32_t>(nodes_.size());
  }

  Model& m;
  std::vector<int> template_of_;               // by block; -1: rigid
  std::vector<std::int32_t> first_of_joint_;   // first contact point of each joint, in the order of the finder
  std::vector<Nodes> nodes_;                   // gridpoints of each point, in the order of the finder
  std::vector<NewPoint> of_bodies_;            // points with a rigid block on one side or both
  std::vector<std::int32_t> found_of_bodies_;  // numbers of these points in the order of the finder
  std::vector<BodyPlace> body_place_;          // by body; group -1: a lone body
  std::vector<std::array<int, 6>> next_slot_;  // by body and face
};

// Lays out unit groups and chunks in the arrays of a model.
class ModelFiller {
 public:
  explicit ModelFiller(Model& model) : m(model) {}

  void fill_chunks(std::span<const int> chunks) {
    struct Wanted {
      std::int32_t joint, in_joint, point;
    };
    std::vector<Wanted> wanted;
    for (const int c : chunks) {
      const ContactChunk& chunk = m.chunks[at(c)];
      for (std::int32_t p = chunk.first_point; p < chunk.first_point + chunk.point_count; ++p)
        wanted.push_back({m.point_joint[at(p)], m.point_in_joint[at(p)], p});
    }
    std::sort(wanted.begin(), wanted.end(), [](const Wanted& x, const Wanted& y) {
      return std::pair(x.joint, x.in_joint) < std::pair(y.joint, y.in_joint);
    });
    PointFinder finder(m);
    const std::vector<NewPoint>* found = nullptr;
    int joint = -1;
    for (const Wanted& w : wanted) {
      if (w.joint != joint) found = &finder.find(at(joint = w.joint));
      fill_point(w.point, (*found)[at(w.in_joint)]);
    }
    for (const int c : chunks) note_runs_of_points(m.chunks[at(c)]);
  }

  // Masses and constraints of the gridpoints of a unit group.
  void weigh_unit(const UnitGroup& unit) {
    for (int g = unit.first_group; g < unit.first_group + unit.group_count; ++g) {
      const BlockGroup& group = m.groups[at(g)];
      const BrickTemplate& shape = m.templates[at(group.brick_template)];
      for (int n = 0; n < shape.node_count; ++n) {
        for (int lane = 0; lane < group.block_count; ++lane) {
          const int block = group.block[at(lane)];
          const bool on_symmetry_plane =
              m.assembly.symmetry_plane_z0 && std::abs(m.gridpoint_position(block, n)[2]) <=
                                                  kCoordinateTolerance * m.assembly.bricks[at(block)].size[2];
          for (int c = 0; c < 3; ++c) {
            const std::size_t i = at((group.first_line + n) * kLine + kLanes * c + lane);
            m.node_mass[i] = shape.node_mass[at(n)];
            m.node_free[i] = c == 2 && on_symmetry_plane ? 0.0 : 1.0;
          }
        }
      }
    }
  }

  void empty_slots(const UnitGroup& unit) {
    for (int g = unit.first_group; g < unit.first_group + unit.group_count; ++g) {
      const BlockGroup& group = m.groups[at(g)];
      std::fill_n(m.slot_point.begin() + group.first_slot * kLanes, slots_of(group).slot_count() * kLanes,
                  m.point_count);
    }
  }

  // Puts a point into the first empty slot of its gridpoint and face; points come in ascending order.
  void fill_slot(std::int32_t point, bool side_a, const std::vector<bool>& of_units) {
    const Model::Sides sides = m.sides_of(point);
    const Model::BlockPlace& where = m.place[at(side_a ? sides.a : sides.b)];
    if (where.group < 0 || !of_units[at(where.group)]) return;
    const BlockGroup& group = m.groups[at(where.group)];
    const ContactSlots& slots = slots_of(group);
    const std::int32_t node = (side_a ? m.node_a : m.node_b)[at(point)] / kLine - group.first_line;
    int slot = node > 0 ? slots.slot_end[at(node - 1)] : 0;
    const int face = 2 * m.point_axis[at(point)] + (side_a ? 1 : 0);
    while (slots.face[at(slot)] != face ||
           m.slot_point[at((group.first_slot + slot) * kLanes + where.lane)] != m.point_count)
      ++slot;
    m.slot_point[at((group.first_slot + slot) * kLanes + where.lane)] = point;
  }

  void finish_unit(const UnitGroup& unit) {
    for (int g = unit.first_group; g < unit.first_group + unit.group_count; ++g)
      note_runs_of_slots(m, m.groups[at(g)].first_slot, slots_of(m.groups[at(g)]).slot_count(), kLanes);
  }

 private:
  const ContactSlots& slots_of(const BlockGroup& group) const { return m.slots[at(group.brick_template)]; }

  void fill_point(std::int32_t i, const NewPoint& p) {
    const auto offset = [&](const Side& side) {
      const Model::BlockPlace& where = m.place[at(side.block)];
      if (where.body < 0) return (m.groups[at(where.group)].first_line + side.node) * kLine + where.lane;
      const RigidBody& body = m.bodies[at(where.body)];
      return body
          .slave[at(static_cast<int>(std::lower_bound(body.point.begin(), body.point.end(), i) - body.point.begin()))];
    };
    m.node_a[at(i)] = offset(p.a);
    m.node_b[at(i)] = offset(p.b);
    m.area[at(i)] = p.area;
    m.point_position[at(i)] = p.position;
    m.point_axis[at(i)] = static_cast<std::uint8_t>(p.axis);
  }

  void note_runs_of_points(const ContactChunk& chunk) {
    const std::int32_t last = chunk.first_point + chunk.point_count - 1;
    m.point_run[at(last)] = 1;
    for (std::int32_t i = last - 1; i >= chunk.first_point; --i) {
      const bool in_step = m.node_a[at(i + 1)] == m.node_a[at(i)] + 1 && m.node_b[at(i + 1)] == m.node_b[at(i)] + 1;
      const int longer = in_step ? m.point_run[at(i + 1)] + 1 : 1;
      m.point_run[at(i)] = static_cast<std::uint8_t>(std::min(longer, kLanes));
    }
  }

  Model& m;
};

}  // namespace

std::vector<std::shared_ptr<const Material>> make_materials(const Assembly& assembly) {
  std::vector<std::shared_ptr<const Material>> materials;
  for (const JointFamily& family : assembly.families) {
    materials.push_back(std::make_shared<const Material>(Law::find(family.law), family.properties));
  }
  return materials;
}

Model::Model(Assembly input, std::vector<std::shared_ptr<const Material>> materials, LayOut laid_out)
    : assembly(std::move(input)) {
  check_input(assembly);
  if (materials.size() != assembly.families.size()) {
    throw Error(Exit::bad_input,
                fmt::format("{} joint families, but {} materials", assembly.families.size(), materials.size()));
  }
  ModelBuilder(*this).build(materials);
  unit_laid_out_.resize(unit_groups.size());
  chunk_laid_out_.resize(chunks.size());
  make_columns(*this);
  if (laid_out == LayOut::nothing) return;
  lay_out_all();
  bound_stiffness(*this);
}

void Model::lay_out(std::span<const int> units, std::span<const int> chunks_wanted) {
  std::vector<int> new_chunks;
  for (const int c : chunks_wanted) {
    if (!chunk_laid_out_[at(c)]) new_chunks.push_back(c);
    chunk_laid_out_[at(c)] = true;
  }
  if (!new_chunks.empty()) ++layouts_;
  ModelFiller filler(*this);
  filler.fill_chunks(new_chunks);
  draw_columns(*this, new_chunks);
  std::vector<int> new_units;
  std::vector<bool> is_new(groups.size());
  for (const int u : units) {
    if (unit_laid_out_[at(u)]) continue;
    unit_laid_out_[at(u)] = true;
    new_units.push_back(u);
    filler.weigh_unit(unit_groups[at(u)]);
    filler.empty_slots(unit_groups[at(u)]);
    for (int g = 0; g < unit_groups[at(u)].group_count; ++g) is_new[at(unit_groups[at(u)].first_group + g)] = true;
  }
  if (new_units.empty()) return;
  for (const int c : chunks_wanted) {
    for (std::int32_t p = chunks[at(c)].first_point; p < chunks[at(c)].first_point + chunks[at(c)].point_count; ++p) {
      filler.fill_slot(p, true, is_new);
      filler.fill_slot(p, false, is_new);
    }
  }
  for (const int u : new_units) filler.finish_unit(unit_groups[at(u)]);
}

void Model::weigh(int unit) {
  if (!unit_laid_out_[at(unit)]) ModelFiller(*this).weigh_unit(unit_groups[at(unit)]);
}

void Model::lay_out_all() {
  std::vector<int> all_units(unit_groups.size()), all_chunks(chunks.size());
  std::iota(all_units.begin(), all_units.end(), 0);
  std::iota(all_chunks.begin(), all_chunks.end(), 0);
  lay_out(all_units, all_chunks);
}

void Model::keep_alone(std::span<const int> units, std::span<const int> chunks_kept) {
  std::vector<bool> unit_stays(unit_groups.size()), chunk_stays(chunks.size());
  for (const int u : units) unit_stays[at(u)] = true;
  for (const int c : chunks_kept) chunk_stays[at(c)] = true;
  each_row(unit_stays, false, [&](std::size_t first, std::size_t end) {
    const Extent of = extent_of_units(first, end);
    release_part(node_mass, of.first_line * kLine, of.end_line * kLine);
    release_part(node_free, of.first_line * kLine, of.end_line * kLine);
    release_part(slot_point, of.first_slot * kLanes, of.end_slot * kLanes);
    release_part(slot_run, of.first_slot, of.end_slot);
    std::fill(unit_laid_out_.begin() + first, unit_laid_out_.begin() + end, false);
  });
  each_row(chunk_stays, false, [&](std::size_t first, std::size_t end) {
    const std::size_t p = at(chunks[first].first_point),
                      q = at(chunks[end - 1].first_point + chunks[end - 1].point_count);
    for (auto* column : {&node_a, &node_b}) release_part(*column, p, q);
    for (auto* column : {&point_run, &point_axis}) release_part(*column, p, q);
    release_part(area, p, q);
    release_part(point_position, p, q);
    release_columns(*this, p, q);
    std::fill(chunk_laid_out_.begin() + first, chunk_laid_out_.begin() + end, false);
  });
}

Model::Extent Model::extent_of_units(std::size_t first, std::size_t end) const {
  const UnitGroup& last_unit = unit_groups[end - 1];
  const BlockGroup& from = groups[at(unit_groups[first].first_group)];
  const BlockGroup& last = groups[at(last_unit.first_group + last_unit.group_count - 1)];
  return {at(from.first_line), at(last.first_line + templates[at(last.brick_template)].node_count), at(from.first_slot),
          at(last.first_slot + slots[at(last.brick_template)].slot_count())};
}

std::vector<int> Model::blocks_named(const std::string& name) const {
  std::vector<int> found;
  for (const RigidBody& body : bodies)
    if (!name.empty() && body.name == name) found.push_back(body.block);
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
