#include "analysis/undamaged.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "base/error.h"
#include "base/index.h"
#include "law/material_point.h"
#include "members/linear.h"
#include "members/members.h"
#include "model/contact_frames.h"
#include "model/motion.h"
#include "model/world.h"
#include "model/world_results.h"
#include "scene/driven.h"
#include "scene/from_bricks.h"
#include "scene/generate.h"
#include "scene/generate_blocks.h"
#include "scene/members.h"
#include "scene/read_masses.h"
#include "sparse/stiffness_entries.h"

namespace quoin {
namespace {

using geometry::Vector;

struct JointStiffness {
  double normal, shear;  // Pa/m
};

// Stiffness of a closed point by small differences. Compression comes first, as a dry point resists shear only under
// pressure.
JointStiffness stiffness_of(const std::shared_ptr<const Material>& material, const std::string& initial_state) {
  // Far below any strength, and far above the rounding of tractions.
  constexpr double kCompression = 1e3, kShear = 1.0;  // Pa
  const quoin_stiffness_bounds& bounds = material->stiffness_bounds();
  MaterialPoint point(material, initial_state);
  JointStiffness k{};
  const double closure = bounds.normal > 0.0 ? kCompression / bounds.normal : 0.0;
  if (closure > 0.0) k.normal = -point.move_to(-closure, 0.0, 0.0).traction[0] / closure;
  if (bounds.shear > 0.0) {
    const double slip = kShear / bounds.shear;
    k.shear = point.move_to(-closure, slip, 0.0).traction[1] / slip;
  }
  return k;
}

// A world at its start, with access to its stiffness. Its solver settings scale no inertia.
class World : public blocks::World {
 public:
  explicit World(const blocks::Assembly& scene) : blocks::World(scene, SolverSettings{}) {}

  void hold(const Stage& stage, std::vector<std::string>* held);
  void fill(const std::string& file, Vibrating* v);

 private:
  void number(Vibrating* v);
  void number_body(int block, Vibrating* v);
  void draw(Vibrating* v) const;
  void add_zones(StiffnessEntries* entries) const;
  void add_points(Vibrating* v, StiffnessEntries* entries) const;
  void add_members(const Vibrating& v, StiffnessEntries* entries) const;
  void number_members(Vibrating* v);
  void add_deformations(const Vibrating& v, StiffnessEntries* entries) const;
  void add_gridpoint(int gridpoint, double weight, std::vector<UnknownShare>* shares) const;
  void add_node(const members::Node& node, double sign, const Vibrating& v, std::vector<UnknownShare>* shares) const;
  void add_side(int block, int facet, const Vector& place, double sign, const Vibrating& v,
                std::vector<UnknownShare>* shares) const;

  std::vector<std::uint8_t> held_;                  // by block: bits 0..2 translations, 3..5 rotations
  std::vector<int> first_of_body_, count_of_body_;  // unknowns, by block
  std::vector<std::array<int, 3>> of_gridpoint_;    // by gridpoint and direction; -1: held
  members::LinearMembers own_;                      // floors and beams
  std::vector<int> first_of_node_;                  // first unknown of each own node of a member; one more at the end
};

std::string axes_text(std::uint8_t bits) {
  std::string text;
  for (unsigned c = 0; c < 3; ++c) text += (bits >> c & 1u) != 0 ? std::string(" ") + "xyz"[c] : "";
  if ((bits >> 3) == 7) text += ", no rotation";
  return text;
}

// Supports as in supports_in(): fixed blocks, and blocks and components that the stage prescribes.
void World::hold(const Stage& stage, std::vector<std::string>* held) {
  const std::vector<blocks::Block>& given = assembly.blocks;
  held_.assign(given.size(), 0);
  for (std::size_t i = 0; i < given.size(); ++i) held_[i] = given[i].fixed ? 0x3f : 0;
  for (const BodyControl& control : stage.controls) {
    const unsigned bits = prescribed_by(control);
    for (const int block : blocks::find_blocks(assembly, control.body, stage.source.text)) {
      const unsigned of_gridpoints = bits & 7u;
      held_[at(block)] = static_cast<std::uint8_t>(given[at(block)].rigid ? bits : of_gridpoints);
    }
  }
  std::map<std::string, std::uint8_t> names;
  for (std::size_t i = 0; i < given.size(); ++i) {
    if (held_[i] == 0) continue;
    names[given[i].name.empty() ? blocks::label(assembly, static_cast<int>(i)) : given[i].name] = held_[i];
  }
  for (const auto& [name, bits] : names) held->push_back(name + ":" + axes_text(bits));
}

void World::number_body(int block, Vibrating* v) {
  const blocks::Body& body = bodies[at(this->blocks[block].body)];
  const unsigned held = held_[at(block)] | body.support;
  first_of_body_[at(block)] = static_cast<int>(v->unknown.size());
  for (int c = 0; c < 3; ++c) {
    if ((held >> c & 1u) != 0) continue;
    Unknown u{block, -1, {}, {}, body.x};
    u.translation[c] = 1.0;
    v->unknown.push_back(u), v->mass.push_back(body.mass);
  }
  std::vector<int> axes;
  for (int c = 0; c < 3; ++c) {
    if ((held >> (3 + c) & 1u) == 0) axes.push_back(c);
  }
  geometry::Matrix inertia;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const Vector a = body.r.row[i], b = body.r.row[j];
      inertia.row[i][j] = a.x * b.x * body.inertia.x + a.y * b.y * body.inertia.y + a.z * b.z * body.inertia.z;
    }
  }
  for (const FreeRotation& rotation : free_rotations(axes, inertia))
    v->unknown.push_back({block, -1, {}, rotation.spin, body.x}), v->mass.push_back(rotation.inertia);
  count_of_body_[at(block)] = static_cast<int>(v->unknown.size()) - first_of_body_[at(block)];
}

void World::number(Vibrating* v) {
  first_of_body_.assign(at(block_count()), 0), count_of_body_.assign(at(block_count()), 0);
  of_gridpoint_.assign(nodes.x.size(), {-1, -1, -1});
  const auto close_group = [&](const Vector& place) {
    const auto end = static_cast<int>(v->unknown.size());
    if (end == v->groups.begin.back()) return;
    v->groups.begin.push_back(end), v->groups.place.push_back(place);
  };
  v->groups.begin = {0};
  for (int i = 0; i < block_count(); ++i) {
    const blocks::ModelBlock& b = blocks[i];
    if (b.body >= 0) {
      number_body(i, v), close_group(position_of(*this, i));
      continue;
    }
    for (int n = b.first_node; n < b.first_node + b.node_count; ++n) {
      const unsigned held = held_[at(i)] | nodes.support[at(n)];
      for (int c = 0; c < 3; ++c) {
        if ((held >> c & 1u) != 0) continue;
        of_gridpoint_[at(n)][at(c)] = static_cast<int>(v->unknown.size());
        Unknown u{i, n - b.first_node};
        u.translation[c] = 1.0;
        v->unknown.push_back(u), v->mass.push_back(nodes.mass[at(n)]);
      }
      close_group(nodes.reference[at(n)]);
    }
  }
}

void World::draw(Vibrating* v) const {
  for (int i = 0; i < block_count(); ++i) {
    const blocks::ModelBlock& b = blocks[i];
    DrawnBlock& drawn = v->drawn.emplace_back();
    drawn.held = (held_[at(i)] & 7u) == 7u;
    drawn.face = b.shape->faces;  // the first gridpoints of a deformable block are its corners
    v->label.push_back(blocks::label(assembly, i));
    if (b.body >= 0) {
      for (std::size_t k = 0; k < b.shape->vertices.size(); ++k)
        drawn.point.push_back(corner_of(*this, i, static_cast<int>(k)));
      continue;
    }
    for (int n = b.first_node; n < b.first_node + b.node_count; ++n) drawn.point.push_back(nodes.reference[at(n)]);
    for (int z = 0; z < b.zone_count; ++z)
      std::ranges::copy(zone_of(*this, i, z).node, drawn.zone.emplace_back().begin());
    v->zones += b.zone_count;
  }
}

void World::add_zones(StiffnessEntries* entries) const {
  each_zone(*this, [&](const blocks::ModelBlock& b, const blocks::Zone& zone) {
    std::array<std::array<int, 3>, 4> unknown;
    for (std::size_t i = 0; i < 4; ++i) unknown[i] = of_gridpoint_[at(b.first_node + zone.node[i])];
    add_zone(zone.volume, zone.lambda, zone.mu, zone.gradient, unknown, entries);
  });
}

void World::add_gridpoint(int gridpoint, double weight, std::vector<UnknownShare>* shares) const {
  for (int c = 0; c < 3; ++c) {
    const int unknown = of_gridpoint_[at(gridpoint)][at(c)];
    if (unknown < 0 || weight == 0.0) continue;
    Vector moves;
    moves[c] = weight;
    shares->push_back({unknown, moves});
  }
}

void World::add_side(int block, int facet, const Vector& place, double sign, const Vibrating& v,
                     std::vector<UnknownShare>* shares) const {
  if (facet < 0) {
    for (int k = 0; k < count_of_body_[at(block)]; ++k) {
      const int unknown = first_of_body_[at(block)] + k;
      shares->push_back({unknown, sign * v.unknown[at(unknown)].at(place)});
    }
    return;
  }
  const blocks::Facet& f = contacts.facets[at(facet)];
  for (int i = 0; i < 3; ++i) add_gridpoint(f.node[i], sign * f.weight[i], shares);
}

void World::add_points(Vibrating* v, StiffnessEntries* entries) const {
  std::vector<UnknownShare> shares;
  for (std::size_t k = 0; k < contacts.families.size(); ++k) {
    const blocks::Family& family = contacts.families[k];
    const JointStiffness mean = stiffness_of(family.material, assembly.families[k].initial_state);
    for (std::size_t i = 0; i < family.size(); ++i) {
      const blocks::Point& p = family.point[i];
      const blocks::Location here = locate(*this, p, contacts.facets);
      if (here.jump > detection.joint_tolerance) continue;  // an open gap
      shares.clear();
      add_side(p.a, p.facet_a, here.at, -1.0, *v, &shares);
      add_side(p.b, p.facet_b, here.at, 1.0, *v, &shares);
      add_spring(shares, frame_of(*this, p).row[0],
                 p.area * mean.normal * scatter_factor(family.columns, "normal_stiffness", i),
                 p.area * mean.shear * scatter_factor(family.columns, "shear_stiffness", i), entries);
      ++v->points;
    }
  }
}

void World::add_node(const members::Node& node, double sign, const Vibrating& v,
                     std::vector<UnknownShare>* shares) const {
  if (blocks[node.block].body >= 0) return add_side(node.block, -1, node.start, sign, v, shares);
  for (const auto& [gridpoint, weight] : node.share) add_gridpoint(gridpoint, sign * weight, shares);
}

// Stiffness of members. Ties without slack are taut, springs of beddings are closed.
void World::add_members(const Vibrating& v, StiffnessEntries* entries) const {
  if (!held_by.members) return;
  std::vector<UnknownShare> shares;
  const auto& riders = held_by.members->nodes();
  for (const members::Tie& tie : held_by.members->ties()) {
    if (tie.law.slack > 0.0) continue;
    shares.clear();  // shares of its elongation along the axis
    for (std::size_t i = 0; i + 1 < tie.stops.size(); ++i) {
      const Vector along = normalized(start_of(riders, tie.stops[i + 1]) - start_of(riders, tie.stops[i]));
      const auto add_stop = [&](const members::Tie::Stop& stop, double sign) {
        for (const auto& [node, share] : stop) {
          const std::size_t first = shares.size();
          add_node(riders[at(node)], sign * share, v, &shares);
          for (std::size_t k = first; k < shares.size(); ++k) shares[k].moves = {dot(shares[k].moves, along), 0, 0};
        }
      };
      add_stop(tie.stops[i], -1.0), add_stop(tie.stops[i + 1], 1.0);
    }
    add_spring(shares, {1, 0, 0}, tie.law.stiffness, 0.0, entries);
  }
  for (const members::Dowel& dowel : held_by.members->dowels()) {
    shares.clear();
    add_node(riders[at(dowel.first)], -1.0, v, &shares), add_node(riders[at(dowel.second)], 1.0, v, &shares);
    add_spring(shares, dowel.along, dowel.law.axial, dowel.law.shear, entries);
  }
  const auto add_to_ground = [&](int node, const Vector& normal, double stiffness, double shear) {
    shares.clear();
    add_node(riders[at(node)], 1.0, v, &shares);
    add_spring(shares, normal, stiffness, shear, entries);
  };
  for (const members::Fill& fill : held_by.members->fills()) {
    for (const members::FillPoint& p : fill.points) {
      if (p.law.level != 0.0) add_to_ground(p.node, p.law.out, p.law.level * p.law.stiffness, 0.0);
    }
  }
  for (const members::Bed& bed : held_by.members->beds()) {
    for (const members::SpringPoint& p : bed.points) add_to_ground(p.node, p.out, p.law.normal, p.law.shear);
  }
}

// Numbers unknowns of floors and beams, and draws their nodes after the blocks.
void World::number_members(Vibrating* v) {
  for (const members::OwnBody& body : own_.bodies) {
    const auto drawn_as = static_cast<int>(v->drawn.size());
    DrawnBlock& drawn = v->drawn.emplace_back();
    v->label.push_back(body.label), ++v->members;
    drawn.face = body.faces;
    for (int n = body.first; n < body.end; ++n) {
      const members::OwnNode& node = own_.nodes[at(n)];
      first_of_node_.push_back(static_cast<int>(v->unknown.size()));
      for (const Vector& way : node.ways)
        v->unknown.push_back({drawn_as, n - body.first, way, {}, node.at}), v->mass.push_back(node.mass);
      for (const Vector& turn : node.turns)
        v->unknown.push_back({drawn_as, n - body.first, {}, turn, node.at}), v->mass.push_back(node.inertia);
      v->groups.begin.push_back(static_cast<int>(v->unknown.size())), v->groups.place.push_back(node.at);
      drawn.point.push_back(node.at);
    }
  }
  first_of_node_.push_back(static_cast<int>(v->unknown.size()));
}

// Stiffness of deformations from their unknowns and coefficients. Connectors and supports count as closed.
void World::add_deformations(const Vibrating& v, StiffnessEntries* entries) const {
  using Row = std::vector<std::pair<int, double>>;
  std::vector<UnknownShare> shares;
  const auto row_of = [&](const members::Deformation& d) {
    Row row;
    for (const members::Deformation::Share& share : d.shares) {
      if (share.own) {
        for (int u = first_of_node_[at(share.node)]; u < first_of_node_[at(share.node) + 1]; ++u)
          row.emplace_back(u, dot(share.way, v.unknown[at(u)].translation) + dot(share.turn, v.unknown[at(u)].spin));
        continue;
      }
      shares.clear();
      add_node(held_by.members->nodes()[at(share.node)], 1.0, v, &shares);
      for (const UnknownShare& s : shares) row.emplace_back(s.unknown, dot(share.way, s.moves));
    }
    return row;
  };
  const auto add = [&](const Row& rows, const Row& columns, double stiffness) {
    for (const auto& [i, a] : rows) {
      for (const auto& [j, b] : columns) {
        if (j <= i && a * b != 0.0) entries->emplace_back(i, j, stiffness * a * b);
      }
    }
  };
  Row before;
  for (const members::Deformation& d : own_.deformations) {
    const Row row = row_of(d);
    add(row, row, d.stiffness);
    if (d.coupling != 0.0) add(row, before, d.coupling), add(before, row, d.coupling);
    before = row;
  }
  for (const members::Rest& rest : own_.rests) {
    for (const Vector& axis : {Vector{1, 0, 0}, Vector{0, 1, 0}, Vector{0, 0, 1}}) {
      const Row row = row_of({{{true, rest.own, -1.0 * axis, {}}, {false, rest.node, axis, {}}}});
      add(row, row, rest.stiffness);
    }
  }
}

void World::fill(const std::string& file, Vibrating* v) {
  number(v);
  draw(v);
  if (held_by.members) own_ = members::linear_of(*held_by.members, file), number_members(v);
  const auto count = static_cast<Eigen::Index>(v->unknown.size());
  v->stiffness.resize(count, count);
  StiffnessEntries entries;
  add_zones(&entries);
  add_points(v, &entries);
  add_members(*v, &entries);
  add_deformations(*v, &entries);
  v->stiffness.setFromTriplets(entries.begin(), entries.end());
}

}  // namespace

SceneBlocks blocks_of(const Scene& scene) {
  SceneBlocks blocks;
  if (scene.blocks) {
    blocks.assembly = blocks::assemble(scene);
    choose_rigid_points(scene, &blocks.assembly.families);
  } else {
    Assembly bricks = assemble(scene);
    stand_on_ground(scene, bricks);
    choose_rigid_points(scene, &bricks.families);
    blocks = {blocks::from_bricks(bricks), bricks.symmetry_factor};
  }
  add_masses(scene, &blocks.assembly);
  return blocks;
}

double Vibrating::free_mass(int axis) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < unknown.size(); ++i)
    sum += mass[i] * unknown[i].translation[axis] * unknown[i].translation[axis];
  return symmetry_factor * sum;
}

void refuse_if_held(const Vibrating& v, const std::string& file) {
  if (!v.unknown.empty()) return;
  throw Error(Exit::bad_input,
              fmt::format("{}: modes: all blocks are held, so nothing can vibrate; leave some block free", file));
}

Vibrating vibrating(const Scene& scene, int stage) {
  const SceneBlocks given = blocks_of(scene);
  World world(given.assembly);
  if (scene.members && !scene.members->strips.empty())
    throw Error(
        Exit::bad_input,
        fmt::format("{}: modes: the stiffness of [[strip]] is not known here; leave strips out for the modes of "
                    "the masonry without them",
                    scene.members->strips.front().source.text));
  if (scene.members) world.hold_by_members(std::make_shared<members::Members>(*scene.members, given.assembly));
  Vibrating v;
  v.symmetry_factor = given.symmetry_factor;
  world.hold(scene.stages.empty() ? Stage{} : scene.stages[at(stage)], &v.held);
  world.fill(scene.file, &v);
  refuse_if_held(v, scene.file);
  return v;
}

}  // namespace quoin
