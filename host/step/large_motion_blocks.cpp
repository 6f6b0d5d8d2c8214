// Blocks in a step of large motion, piece by piece: their forces and their motion.
#include <algorithm>
#include <cmath>

#include "members/members.h"
#include "model/world_results.h"
#include "model/zone_kernels.h"
#include "step/contact_kernels.h"
#include "step/deformable_kernels.h"
#include "step/large_motion.h"
#include "step/rigid_kernels.h"
#include "step/rigid_motion_kernels.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

bool deforms_too_much(const Model& m, int block, const BlockSums& sums) {
  return !(sums.deformation <= kLargestDeformation * m.blocks[size_t(block)].least_extent);
}

constexpr size_t kRow = 4;  // doubles a gridpoint in rows that kernels read

Vector in_lane(const ByLane (&column)[3], int lane) {
  return {column[0].of[lane], column[1].of[lane], column[2].of[lane]};
}
Rigid motion_in(const ByLane (&column)[2][3], int lane) { return {in_lane(column[0], lane), in_lane(column[1], lane)}; }

// Whether all motions of the body are held at zero velocity.
bool is_at_rest(const Body& b) {
  const auto still = [](const Vector& v) { return v.x == 0.0 && v.y == 0.0 && v.z == 0.0; };
  return b.held == 0x3f && still(b.v) && still(b.omega) && still(b.held_v) && still(b.held_omega);
}

RigidInertia inertia_in(const InertiaLanes& lanes, int lane) {
  uint8_t held = 0;
  for (int k = 0; k < 3; ++k) held = uint8_t(held | int(lanes.held[k].of[lane] != 0.0) << k);
  const Matrix second{{in_lane(lanes.second[0], lane), in_lane(lanes.second[1], lane), in_lane(lanes.second[2], lane)}};
  return {in_lane(lanes.centre, lane), lanes.mass.of[lane], second, held};
}

template <class Visit>
void each_member_force(const Model& m, int block, const Visit& visit) {
  if (!m.held_by.members) return;
  for (const int node : m.held_by.members->nodes_of(block)) visit(m.held_by.members->nodes()[size_t(node)]);
}

}  // namespace

Wrench loads_on_body(const Model& m, int block) {
  const Matrix& r = m.bodies[size_t(m.blocks[size_t(block)].body)].r;
  Wrench sum;
  const auto add = [&](const Vector& force, const Vector& arm) {
    sum.force += force;
    sum.torque += cross(r * arm, force);
  };
  if (!m.actions.applied.empty()) {
    const Wrench& applied = m.actions.applied[size_t(block)];
    add(applied.force, m.blocks[size_t(block)].load_arm);
    sum.torque += applied.torque;
  }
  for (const Load& l : m.actions.loads) {
    if (l.block == block) add(l.scale * l.force, l.arm);
  }
  for (const Pressure& p : m.actions.pressures) {
    if (p.block == block) add(p.scale * p.value * (r * p.push), p.arm);
  }
  return sum;
}

namespace {

void forces_on_body(Model& m, int block) {
  Body& body = m.bodies[size_t(m.blocks[size_t(block)].body)];
  body.force = {}, body.torque = {};
  for (const PairTouch& touch : m.sides.pair.of(block)) {
    const RigidPair& pair = *touch.pair;
    if (touch.side_a)
      body.force += pair.force, body.torque += pair.moment_a;
    else
      body.force -= pair.force, body.torque += pair.moment_b;
  }
  for (const RowTouch row : m.sides.wrench.of(block)) {
    const auto& force = m.chunks.rows[row].force;
    const auto& moment = m.chunks.rows[row + 1].force;
    body.force += {force[0], force[1], force[2]}, body.torque += {moment[0], moment[1], moment[2]};
  }
  for (const Touch& touch : m.sides.single.of(block)) {
    const Vector& at = m.contacts.families[size_t(touch.family)].point[touch.point->index].at;
    const Vector force = touch.side_a ? touch.point->force : -touch.point->force;
    body.force += force;
    body.torque += cross(at - body.x, force);
  }
  each_member_force(m, block, [&](const members::Node& node) {
    body.force += node.force;
    body.torque += cross(node.x - body.x, node.force);
  });
  m.step_sums.contact_force[size_t(block)] = body.force;
  body.force += body.weight_mass * m.actions.gravity;
  if (!m.actions.loaded[size_t(block)]) return;
  const Wrench loads = loads_on_body(m, block);
  body.force += loads.force, body.torque += loads.torque;
}

// Returns whether a position is not finite, or a body deviates from its motion at the last check.
bool advance_bodies(Model& m, std::span<const int32_t> blocks, PhaseClock* clock) {
  int32_t index[kBodies];
  BlockSums* sums[kBodies];
  Wrench loads[kBodies];
  double power[kBodies];  // power of these loads before the step, W
  const auto power_of = [&](size_t i) {
    const Body& body = m.bodies[size_t(index[i])];
    return dot(loads[i].force, body.v) + dot(loads[i].torque, body.omega);
  };
  const auto is_loaded = [&](size_t i) { return m.books_energy && m.actions.loaded[size_t(blocks[i])]; };
  for (size_t i = 0; i < blocks.size(); ++i) {
    forces_on_body(m, blocks[i]);
    index[i] = m.blocks[size_t(blocks[i])].body;
    sums[i] = &m.step_sums.of_block[size_t(blocks[i])];
    if (is_loaded(i)) loads[i] = loads_on_body(m, blocks[i]), power[i] = power_of(i);
  }
  if (std::all_of(index, index + blocks.size(), [&](int32_t i) { return is_at_rest(m.bodies[size_t(i)]); })) {
    for (size_t i = 0; i < blocks.size(); ++i) *sums[i] = {};
    lap(clock, Phase::motion);
    return false;
  }
  // The motion of a rigid block is all rigid motion: damping of rigid motion is eq. 1.
  const Vector g = m.actions.gravity;
  const BodyStep step{m.stepping.dt, m.damping.gamma, m.damping.alpha, braking_ground(m), g, m.measured};
  advance_rigid(m.bodies.data(), m.checks.assumed.empty() ? nullptr : m.checks.assumed.data(), index,
                int(blocks.size()), step, sums);
  lap(clock, Phase::motion);
  for (size_t i = 0; i < blocks.size(); ++i) {
    if (!is_loaded(i)) continue;
    sums[i]->external.before += 0.5 * m.stepping.dt * power[i];
    sums[i]->external.after += 0.5 * m.stepping.dt * power_of(i);
  }
  return std::any_of(sums, sums + blocks.size(),
                     [](const BlockSums* s) { return !std::isfinite(s->positions) || s->deviates; });
}

// Up to kBodies deformable blocks in a SIMD group. Scratch of a thread.
struct LaneGroup {
  std::vector<double> rows;  // forces on gridpoints, block after block
  LaneBlock block[kBodies];
  BlockSums sums[kBodies];
  double power[kBodies];  // power of loads before the step, W
  size_t count = 0;
  std::span<const LaneBlock> blocks() const { return {block, count}; }
};

// Viscosity of zones: beta of stiffness-proportional damping, s.
double zone_damping(const Model& m) {
  const double of_impacts = m.damping.impacts ? m.impacts.share * m.impacts.zone_beta : 0.0;
  // zone_ratio times the critical time step is 2 xi / omega_max.
  return m.damping.beta + m.damping.zone_ratio * m.stepping.critical_dt + of_impacts;
}

// Visits the forces by which a deformable block carries a moment about its centre. They are those of its inertia under
// the angular acceleration that the moment would give it.
template <class Visit>
void each_share_of_moment(const Model& m, int block, const Vector& moment, const Visit& visit) {
  const ModelBlock& b = m.blocks[size_t(block)];
  const size_t first = size_t(b.first_node), count = size_t(b.node_count);
  const std::span x(m.nodes.x.data() + first, count);
  const std::span mass(m.nodes.mass.data() + first, count);
  const RigidInertia inertia(x, mass, std::vector<uint8_t>(count, 0));
  const Vector turning = inertia.acceleration({{}, moment}).angular;
  for (size_t i = 0; i < count; ++i) visit(int32_t(first + i), mass[i] * cross(turning, x[i] - inertia.centre()));
}

template <class Visit>
void each_load_on_gridpoints(const Model& m, int block, double since, const Visit& visit) {
  if (!m.actions.applied.empty()) {
    const Vector& moment = m.actions.applied[size_t(block)].torque;
    if (dot(moment, moment) > 0.0) each_share_of_moment(m, block, moment, visit);
  }
  for (const Load& l : m.actions.loads) {
    if (l.block != block) continue;
    const Vector f = l.scale * l.force;
    for (const auto& [node, weight] : l.share) visit(node, weight * f);
  }
  for (const Pressure& p : m.actions.pressures) {
    if (p.block != block) continue;
    const double value = p.scale * p.value;
    for (const auto& t : p.triangles) {
      const auto edge = [&](size_t k) {
        return m.nodes.x[t[k]] - m.nodes.x[t[0]] - since * (m.nodes.v[t[k]] - m.nodes.v[t[0]]);
      };
      const Vector normal = cross(edge(1), edge(2));
      for (int32_t node : t) visit(node, -value / 6 * normal);
    }
  }
}

}  // namespace

void each_load_on_gridpoints(const Model& m, int block, const VisitLoad& visit) {
  each_load_on_gridpoints(m, block, 0.0, visit);
}

Vector load_on(const Model& m, int block) {
  if (m.blocks[size_t(block)].body >= 0) return loads_on_body(m, block).force;
  Vector sum = m.actions.applied.empty() ? Vector{} : m.actions.applied[size_t(block)].force;
  each_load_on_gridpoints(m, block, [&](int32_t, const Vector& force) { sum += force; });
  return sum;
}

namespace {

double power_on_gridpoints(const Model& m, int block, double since) {
  double power = m.actions.applied.empty() ? 0.0 : dot(m.actions.applied[size_t(block)].force, velocity_of(m, block));
  each_load_on_gridpoints(m, block, since, [&](int32_t node, const Vector& f) { power += dot(f, m.nodes.v[node]); });
  return power;
}

// Sides of the block's points on triangles, and where it is not advanced in frames those on gridpoints.
FacetTouches facet_touches(const Model& m, int block) {
  FacetTouches touches{m.sides.owner.of(block), m.sides.carrier.of(block), {}, {}};
  if (!m.pieces.in_frame[size_t(block)])
    touches.gridpoint = m.sides.gridpoint.of(block), touches.owner_gridpoint = m.sides.owner_gridpoint.of(block);
  return touches;
}

// Whether forces act on gridpoints of the piece beside those of Pieces::lines.
bool has_other_forces(const Model& m, const Piece& piece) {
  if (!piece.in_frame() || piece.other_sides || m.held_by.members) return true;
  return std::ranges::any_of(m.pieces.blocks_of(piece), [&](int32_t block) { return m.actions.loaded[size_t(block)]; });
}

// Computes forces on the gridpoints of a block. Returns the sum of those of contact points and members, N.
Vector forces_on_gridpoints(const Model& m, int block, double* force) {
  const ModelBlock& b = m.blocks[size_t(block)];
  const auto add = [&](int32_t node, const Vector& f) {
    double* const row = force + kRow * size_t(node - b.first_node);
    row[0] += f.x, row[1] += f.y, row[2] += f.z;
  };
  std::fill(force, force + kRow * size_t(b.node_count), 0.0);
  Vector contacts = add_facet_rows(facet_touches(m, block), m.chunks.rows.data(), force);
  for (const Touch& touch : m.sides.single.of(block)) {
    const Family& f = m.contacts.families[size_t(touch.family)];
    const OtherPoint& other = *touch.point;
    const Point& p = f.point[other.index];
    if (touch.side_a) {
      const Facet& facet = m.contacts.facets[p.facet_a];
      // Both forces act at p.at: shear times the gap is a couple, which the triangle carries as normal forces.
      const double gap = f.normal_jump[other.index] + p.reference;
      for (size_t i = 0; i < 3; ++i) {
        const double couple =
            -gap * p.area * (other.gradient[i][0] * other.shear[0] + other.gradient[i][1] * other.shear[1]);
        add(facet.node[i], facet.weight[i] * other.force + couple * p.n);
      }
      contacts += other.force;
    } else {
      const Facet& facet = m.contacts.facets[p.facet_b];
      for (int i = 0; i < 3; ++i) add(facet.node[i], -facet.weight[i] * other.force);
      contacts -= other.force;
    }
  }
  each_member_force(m, block, [&](const members::Node& node) {
    for (const auto& [i, weight] : node.share) add(i, weight * node.force);
    contacts += node.force;
  });
  if (m.actions.loaded[size_t(block)]) each_load_on_gridpoints(m, block, 0.0, add);
  return contacts;
}

void zone_forces_of(Model& m, const ModelBlock& b, BlockSums& sums, double* force, double* viscous) {
  const ZoneStep step{zone_damping(m), m.stepping.dt, m.books_energy};
  thread_local std::vector<double> rows;  // displacement, velocity
  const size_t column = kRow * size_t(b.node_count);
  rows.resize(std::max(rows.size(), 2 * column));
  double *const u = rows.data(), *const v = u + column;
  for (size_t i = 0; i < size_t(b.node_count); ++i) {
    const size_t node = size_t(b.first_node) + i;
    const Vector moved = m.nodes.x[node] - m.nodes.reference[node];
    u[kRow * i] = moved.x, u[kRow * i + 1] = moved.y, u[kRow * i + 2] = moved.z;
    if (step.beta > 0)
      v[kRow * i] = m.nodes.v[node].x, v[kRow * i + 1] = m.nodes.v[node].y, v[kRow * i + 2] = m.nodes.v[node].z;
  }
  if (viscous) std::fill(viscous, viscous + column, 0.0);
  sums.strain += zone_forces(m.zones.lanes_of(b), step, {u, v, force, viscous});
}

// Computes forces on the blocks of a group in a piece, one a lane: those of contacts and loads. Blocks that are not in
// frames get those of zones too.
void find_forces(Model& m, const Piece& piece, size_t g, LaneGroup& group, LaneColumns& columns, PhaseClock* clock) {
  const std::span<const int32_t> blocks = m.pieces.blocks_of(piece, g);
  group.count = blocks.size();
  columns.viscous = m.books_energy && zone_damping(m) > 0;
  const bool has_rows = has_other_forces(m, piece);
  const bool follows = piece.in_frame() && !(piece.fixed && m.is_small);
  const Vector weight = m.actions.gravity;
  size_t size = 0;
  for (const int32_t block : blocks) size += kRow * size_t(m.blocks[size_t(block)].node_count);
  group.rows.resize(std::max(group.rows.size(), 2 * size));
  double *force = group.rows.data(), *viscous = group.rows.data() + size;
  Vector contact_force[kBodies] = {};
  for (size_t l = 0; l < group.count; ++l) {
    const ModelBlock& b = m.blocks[size_t(blocks[l])];
    BlockSums& sums = group.sums[l];  // the others are set, or never used
    sums.kinetic = sums.strain = sums.deformation = 0.0;
    sums.damping = sums.external = {};
    if (m.books_energy && m.actions.loaded[size_t(blocks[l])]) group.power[l] = power_on_gridpoints(m, blocks[l], 0.0);
    if (has_rows) contact_force[l] = forces_on_gridpoints(m, blocks[l], force);
    if (!piece.in_frame()) {
      lap(clock, Phase::motion);
      zone_forces_of(m, b, sums, force, columns.viscous ? viscous : nullptr);
      lap(clock, Phase::internal_forces);
    }
    const size_t first = size_t(b.first_node);
    Vector per_mass = weight;
    if (m.actions.loaded[size_t(blocks[l])] && !m.actions.applied.empty())
      per_mass += m.actions.applied[size_t(blocks[l])].force / b.mass;
    group.block[l] = {&m.nodes.x[first],
                      &m.nodes.v[first],
                      has_rows ? force : nullptr,
                      columns.viscous ? viscous : nullptr,
                      per_mass / m.solver.mass_scaling,
                      b.node_count,
                      m.zones.lanes_of(b),
                      follows ? &m.frames.frame[size_t(blocks[l])] : nullptr};
    force += kRow * size_t(b.node_count), viscous += kRow * size_t(b.node_count);
  }
  lap(clock, Phase::motion);
  const FixedColumns<const double> fixed(m.pieces.columns.data() + piece.columns[g], most_gridpoints(m, blocks), piece);
  columns.at_start = piece.fixed ? &piece.at_start[g] : nullptr;
  KeptMotion kept;
  if (piece.kind == Piece::Kind::congruent) kept = {m.pieces.motion.data() + piece.motion[g], !m.pieces.motion_is_old};
  load_blocks(group.blocks(), fixed, kept, &columns);
  if (piece.in_frame()) {
    const LaneSums contacts =
        add_gridpoint_lines(piece.lines[g], piece.moments[g], m.chunks.rows.data(), group.count, &columns);
    for (size_t l = 0; l < group.count; ++l) contact_force[l] += contacts.lane(l);
  }
  for (size_t l = 0; l < group.count; ++l) m.step_sums.contact_force[size_t(blocks[l])] = contact_force[l];
  lap(clock, Phase::motion);
}

// Shape of the blocks of a group; null: they are not congruent.
const CongruentBlocks* shared_shape(const Model& m, const Piece& piece, size_t group) {
  return piece.congruent[group] >= 0 ? &m.zones.congruent[size_t(piece.congruent[group])] : nullptr;
}

// Adds internal forces of the groups of a piece in frames.
void add_internal_forces(Model& m, const Piece& piece, LaneGroup* groups, LaneColumns* columns) {
  const size_t count = piece.group_count();
  const ZoneStep step{zone_damping(m), m.stepping.dt, m.books_energy};
  FrameSums sums[2];
  FramedGroup framed[2];
  for (size_t g = 0; g < count; ++g) framed[g] = {groups[g].blocks(), &columns[g], &sums[g]};
  const bool together = count == 2 && piece.kind == Piece::Kind::congruent && piece.congruent[0] == piece.congruent[1];
  for (size_t g = 0; g < count; g += together ? 2 : 1) {
    if (piece.fixed)
      fixed_frame_forces({framed + g, together ? size_t(2) : 1}, *shared_shape(m, piece, g), step);
    else if (piece.kind == Piece::Kind::congruent)
      congruent_forces({framed + g, together ? size_t(2) : 1}, *shared_shape(m, piece, g), step);
    else
      distinct_forces(framed[g], step);
  }
  for (size_t g = 0; g < count; ++g) {
    for (size_t l = 0; l < groups[g].count; ++l) {
      groups[g].sums[l].deformation = sums[g].deformation[l];
      if (m.books_energy) groups[g].sums[l].strain = sums[g].strain[l];
    }
  }
}

// Splits the motion of the blocks of a group, or of the units of which they are the first halves.
void split(const Model& m, LaneGroup& group, std::span<const LaneColumns> columns, RigidGains* gains) {
  const size_t count = columns.size();
  const InertiaFactors factors{m.solver.deformation_inertia, m.solver.unit_inertia};
  const double eq1 = m.damping.eq1 == Eq1::rigid_motion ? m.damping.gamma : 0.0;
  RigidLanes lanes[2];
  split_motion(columns, int(group.count), {factors, eq1, braking_ground(m), m.stepping.dt}, gains,
               m.measured ? lanes : nullptr);
  if (!m.measured) return;
  const double dt = m.stepping.dt, alpha = m.damping.alpha, a = 0.5 * alpha * dt;
  using Motions = Rigid[2];
  for (size_t u = 0; u < group.count; ++u) {
    const int lane = int(u);
    UnitInertia inertia;
    inertia.count = int(count);
    Rigid before[2], mean[2], after[2];  // velocities half a step before the forces, at their time, and after it
    BlockSums& of_unit = group.sums[u];
    for (size_t k = 0; k < count; ++k) {
      const RigidLanes& of_half = lanes[k];
      inertia.block[k] = inertia_in(of_half.inertia, lane);
      before[k] = motion_in(of_half.velocity, lane);
      mean[k] = 1 / (1 + a) * (before[k] + 0.5 * motion_in(of_half.change, lane));
      after[k] = 2.0 * mean[k] - before[k];
      of_unit.damping.before += 0.5 * dt * dot(motion_in(of_half.damping, lane), before[k]);
      of_unit.damping.after += 0.5 * dt * dot(motion_in(of_half.damping, lane), after[k]);
    }
    if (count == 2) inertia.whole = RigidInertia(inertia.block[0], inertia.block[1]);
    // Half of the product of two motions over the inertia, from the energies of their mean and of half their
    // difference.
    const auto product = [&](const Motions& v, const Motions& w) {
      const Motions sum{0.5 * (v[0] + w[0]), 0.5 * (v[1] + w[1])};
      const Motions apart{0.5 * (v[0] - w[0]), 0.5 * (v[1] - w[1])};
      return rigid_energy(inertia, factors, sum) - rigid_energy(inertia, factors, apart);
    };
    of_unit.kinetic += product(before, after);
    of_unit.damping.before += alpha * dt * product(mean, before);
    of_unit.damping.after += alpha * dt * product(mean, after);
  }
}

// Returns whether a position is not finite, or a block has deformed too much for its frame. Sums of blocks are kept in
// Model in measured steps alone, and where something is to be checked or sent to other ranks.
bool advance_deformable(Model& m, const Piece& piece, PhaseClock* clock) {
  thread_local LaneGroup groups[2];
  thread_local LaneColumns columns[2];
  const size_t count = piece.group_count();
  for (size_t g = 0; g < count; ++g) find_forces(m, piece, g, groups[g], columns[g], clock);
  if (piece.in_frame()) add_internal_forces(m, piece, groups, columns);
  lap(clock, Phase::internal_forces);
  RigidGains gains[2];
  const size_t in_unit = piece.apart ? 1 : count;
  for (size_t g = 0; splits_motion(m) && g < count; g += in_unit)
    split(m, groups[g], {columns + g, in_unit}, gains + g);
  const GridpointStep step{m.stepping.dt,
                           m.damping.eq1 == Eq1::gridpoints ? m.damping.gamma : 0.0,
                           m.damping.alpha,
                           braking_ground(m),
                           splits_motion(m) ? m.solver.deformation_inertia : 1.0,
                           1.0 / m.solver.mass_scaling,
                           m.actions.gravity,
                           m.books_energy,
                           m.measured,
                           m.copies_velocities || piece.kind != Piece::Kind::congruent};
  for (size_t g = 0; g < count; ++g) {
    LaneGroup& group = groups[g];
    advance_gridpoints(group.blocks(), columns[g], splits_motion(m) ? &gains[g] : nullptr, step,
                       shared_shape(m, piece, g), group.sums);
    for (size_t l = 0; m.books_energy && l < group.count; ++l) {
      const int block = m.pieces.blocks_of(piece, g)[l];
      if (!m.actions.loaded[size_t(block)]) continue;
      group.sums[l].external.before += 0.5 * m.stepping.dt * group.power[l];
      group.sums[l].external.after += 0.5 * m.stepping.dt * power_on_gridpoints(m, block, m.stepping.dt);
    }
  }
  bool needs_check = false;
  for (size_t g = 0; g < count; ++g) {
    const std::span<const int32_t> blocks = m.pieces.blocks_of(piece, g);
    for (size_t l = 0; l < blocks.size(); ++l) {
      const BlockSums& sums = groups[g].sums[l];
      needs_check |= !std::isfinite(sums.positions) || (piece.in_frame() && deforms_too_much(m, blocks[l], sums));
    }
  }
  for (size_t g = 0; (needs_check || m.measured || m.part.is_shared) && g < count; ++g) {
    const std::span<const int32_t> blocks = m.pieces.blocks_of(piece, g);
    for (size_t l = 0; l < blocks.size(); ++l) m.step_sums.of_block[size_t(blocks[l])] = groups[g].sums[l];
  }
  lap(clock, Phase::motion);
  return needs_check;
}

}  // namespace

void Model::advance_piece(int index, PhaseClock* clock) {
  const Piece& piece = pieces.all[size_t(index)];
  pieces.needs_check[size_t(index)] = piece.kind == Piece::Kind::rigid
                                          ? advance_bodies(*this, pieces.blocks_of(piece), clock)
                                          : advance_deformable(*this, piece, clock);
}

bool has_deformed_too_much(const Model& m, int i) { return deforms_too_much(m, i, m.step_sums.of_block[size_t(i)]); }

}  // namespace quoin::blocks
