// The explicit step of large motion: one function that names the phases, then the phases.
#include "step/large_motion.h"

#include <fmt/format.h>

#include <numeric>

#include "base/error.h"
#include "members/members.h"
#include "model/zone_kernels.h"
#include "step/deformable_kernels.h"
#include "step/facet_kernels.h"
#include "step/gridpoint_kernels.h"
#include "step/point_kernels.h"
#include "step/rigid_kernels.h"
#include "step/rigid_motion_kernels.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

constexpr size_t kRow = 4;  // doubles of a gridpoint where vectors are read from

// The larger of the two; NaN wins, so that it is seen.
double larger(double so_far, double x) { return x <= so_far ? so_far : x; }

double viscous_alpha(const SolverSettings& solver) {
  return solver.damping == DampingKind::viscous ? solver.mass_damping : 0.0;
}

Vector in_lane(const ByLane (&column)[3], int lane) {
  return {column[0].of[lane], column[1].of[lane], column[2].of[lane]};
}
Rigid motion_in(const ByLane (&column)[2][3], int lane) { return {in_lane(column[0], lane), in_lane(column[1], lane)}; }

// Held where it is.
bool is_at_rest(const Body& b) {
  const auto still = [](const Vector& v) { return v.x == 0.0 && v.y == 0.0 && v.z == 0.0; };
  return b.held == 0x3f && still(b.v) && still(b.omega) && still(b.held_v) && still(b.held_omega);
}

RigidInertia inertia_in(const RigidLanes& lanes, const RigidGains& gains, int lane) {
  uint8_t held = 0;
  for (int k = 0; k < 3; ++k) held = uint8_t(held | int(lanes.held[k].of[lane] != 0.0) << k);
  const Matrix second{{in_lane(lanes.second[0], lane), in_lane(lanes.second[1], lane), in_lane(lanes.second[2], lane)}};
  return {in_lane(gains.centre, lane), lanes.mass.of[lane], second, held};
}

}  // namespace

void Model::step() {
  if (pool_ && shared_division_ != chunks_.divisions) share_work();
  begin_step(true);
  auto contacts = [&](int, int chunk) { advance_contacts(chunk); };
  auto blocks = [&](int, int piece) { advance_piece(piece); };
  if (pool_) {
    pool_->for_each(chunk_end_, contacts);
    pool_->for_each(piece_end_, blocks);
  } else {
    for (int c = 0; c < chunk_count(); ++c) contacts(0, c);
    for (int p = 0; p < piece_count(); ++p) blocks(0, p);
  }
  if (end_step()) find_contacts();
}

void Model::advance_contacts(int index, PhaseClock* clock) {
  Chunk& chunk = chunks_.all[size_t(index)];
  Family& f = contacts_.families[size_t(chunk.family)];
  thread_local std::vector<FacetFrames> formed;
  thread_local std::vector<PairAxes> turned;
  formed.resize(std::max(formed.size(), chunk.facets.size()));
  turned.resize(std::max(turned.size(), chunk.gridpoint_pairs.size()));
  const Axes axes = small_ ? Axes{chunk.frames.data(), chunk.pair_axes.data()} : Axes{formed.data(), turned.data()};
  contact_kinematics(f, chunk, axes);  // jumps, in frames that move with the blocks
  lap(clock, Phase::jumps);
  contact_law(f, chunk);  // tractions from jumps: the plug-in
  lap(clock, Phase::law);
  contact_forces(f, chunk, axes);  // one force a point, which its two blocks fetch
  lap(clock, Phase::contact_forces);
}

bool Model::end_step() {
  for (const Chunk& chunk : chunks_.all) {
    if (chunk.failed) report_failure(chunk);
  }
  sum_up();
  stepping_.time += stepping_.dt;
  ++stepping_.count;
  watch();
  leave_frames();
  part_units();
  return moved_enough();
}

void Model::find_contacts() {
  part_.fetch();
  detect_contacts();
}

std::optional<WrongAnswer> Model::wrong_law(std::span<const int> chunks) const {
  for (const int c : chunks) {
    const Chunk& chunk = chunks_.all[size_t(c)];
    const Family& f = contacts_.families[size_t(chunk.family)];
    Answers answers;
    answers.count = chunk.count;
    for (int k = 0; k < 3; ++k) answers.traction[k] = f.traction[k].data() + chunk.first;
    for (const auto& column : f.state) answers.state.push_back(column.empty() ? nullptr : column.data() + chunk.first);
    auto wrong = wrong_answer(f.material->api(), answers);
    if (!wrong) continue;
    const Point& p = f.point[chunk.first + wrong->point];
    wrong->text += fmt::format(": joint family '{}', blocks {} and {}, contact point at {}",
                               assembly_.families[size_t(chunk.family)].name, label(assembly_, p.a),
                               label(assembly_, p.b), place(place_of(p)));
    return wrong;
  }
  return std::nullopt;
}

std::string Model::batch_text(const quoin_batch& batch) const {
  for (const Chunk& chunk : chunks_.all) {
    if (&chunk.batch == &batch)
      return fmt::format("contact points {} to {} of joint family '{}'", chunk.first, chunk.first + chunk.count - 1,
                         assembly_.families[size_t(chunk.family)].name);
  }
  return fmt::format("a batch of {} points", batch.count);
}

void Model::watch() const {
  for (int i = 0; i < block_count(); ++i) {
    if (std::isfinite(step_sums_.of_block[size_t(i)].positions)) continue;
    std::vector<int> all(chunks_.all.size());
    std::iota(all.begin(), all.end(), 0);
    if (const auto wrong = wrong_law(all); wrong && !wrong->finite)
      throw Error(Exit::numerical, fmt::format("step {}, time {:.6g} s: {}; tell its author", stepping_.count,
                                               stepping_.time, wrong->text));
    throw Error(Exit::numerical,
                fmt::format("block {}, {} at the start: its position is no finite number at step {}, time {:.6g} s; "
                            "check the velocities and forces of the stage, or reduce time_step_fraction",
                            label(assembly_, i), place(poses_.start[size_t(i)].x), stepping_.count, stepping_.time));
  }
}

void Model::run(double duration) {
  const double end = stepping_.time + duration;
  while (stepping_.time < end - 0.5 * stepping_.dt) step();
}

void Model::share_work() {
  std::vector<double> weight;
  for (int c = 0; c < chunk_count(); ++c) weight.push_back(chunk_work(c));
  chunk_end_ = shares(weight, pool_->thread_count());
  weight.clear();
  for (int p = 0; p < piece_count(); ++p) weight.push_back(piece_work(p));
  piece_end_ = shares(weight, pool_->thread_count());
  shared_division_ = chunks_.divisions;
}

// ---- Contacts ------------------------------------------------------------------------------------------------------

namespace {

RigidColumns rigid_columns(Family& f) {
  RigidColumns c{};
  for (int k = 0; k < 3; ++k) c.arm[k] = f.arm[k].data(), c.traction[k] = f.traction[k].data();
  for (int k = 0; k < 3 && !f.viscous[0].empty(); ++k) c.viscous[k] = f.viscous[k].data();
  for (int k = 0; k < 2; ++k) c.slid[k] = f.slid[k].data(), c.slip[k] = f.slip[k].data();
  c.offset = f.offset.data(), c.area = f.area.data(), c.normal_jump = f.normal_jump.data();
  return c;
}

FacetColumns facet_columns(Family& f) {
  FacetColumns c{};
  for (int k = 0; k < 3; ++k) c.traction[k] = f.traction[k].data();
  for (int k = 0; k < 3 && !f.viscous[0].empty(); ++k) c.viscous[k] = f.viscous[k].data();
  for (int k = 0; k < 2; ++k) c.slid[k] = f.slid[k].data(), c.slip[k] = f.slip[k].data();
  c.normal_jump = f.normal_jump.data();
  return c;
}

GridpointColumns gridpoint_columns(Family& f, const Chunk& chunk) {
  GridpointColumns c{};
  for (int k = 0; k < 3; ++k) c.traction[k] = f.traction[k].data();
  for (int k = 0; k < 3 && !f.viscous[0].empty(); ++k) c.viscous[k] = f.viscous[k].data();
  for (int k = 0; k < 2; ++k) c.slid[k] = f.slid[k].data(), c.slip[k] = f.slip[k].data();
  c.reference = f.offset.data(), c.area = f.area.data(), c.normal_jump = f.normal_jump.data();
  c.node_a = chunk.node_a.data(), c.node_b = chunk.node_b.data(), c.first = chunk.first;
  return c;
}

}  // namespace

void Model::contact_kinematics(Family& f, Chunk& chunk, const Axes& axes) {
  rigid_jumps(chunk.pairs, bodies_.data(), rigid_columns(f));
  gridpoint_jumps(chunk.gridpoint_pairs, axes.pairs, small_ ? nullptr : frames_.frame.data(), nodes_.x.data(),
                  gridpoint_columns(f, chunk));
  facet_jumps(chunk.facets, axes.triangles, nodes_.x.data(), facet_columns(f), small_);
  for (const uint32_t i : chunk.others) {
    Point& p = f.point[i];
    if (p.facet_a >= 0 && !small_) refresh_facet_frame(p, contacts_.facets[p.facet_a]);
    const Location now = locate(p, contacts_.facets);
    p.at = now.at;
    f.normal_jump[i] = now.jump;
    for (int k = 0; k < 2; ++k) f.slip[k][i] = now.slid[k] - f.slid[k][i], f.slid[k][i] = now.slid[k];
    if (p.facet_a >= 0 && !small_) {
      // The foot on the triangle follows the point, so that the pair of forces stays collinear.
      Facet& facet = contacts_.facets[p.facet_a];
      for (int k = 0; k < 3; ++k)
        facet.weight[k] += facet.gradient[k][0] * f.slid[0][i] + facet.gradient[k][1] * f.slid[1][i];
      f.slid[0][i] = f.slid[1][i] = 0.0;
    }
  }
}

void Model::contact_law(Family& f, Chunk& chunk) {
  if (viscous_contacts()) {
    for (int k = 0; k < 3; ++k)
      std::copy_n(f.traction[k].begin() + chunk.first, chunk.count, f.old_traction[k].begin() + chunk.first);
  }
  chunk.status = f.material->evaluate(&chunk.batch);
  chunk.failed = chunk.status != QUOIN_OK || chunk.batch.failed_count > 0;
  if (!energy_) return;
  EnergyColumns c{f.area.data() + chunk.first, f.stored.data() + chunk.first, {}};
  for (int k = 0; k < QUOIN_DISSIPATED_COUNT; ++k) c.dissipated[k] = f.dissipated[k].data() + chunk.first;
  const PointEnergies sums = energies_of_points(c, chunk.count);
  chunk.stored = sums.stored;
  std::copy(std::begin(sums.dissipated), std::end(sums.dissipated), chunk.dissipated);
}

void Model::report_failure(const Chunk& chunk) const {
  const Family& f = contacts_.families[size_t(chunk.family)];
  const std::string law = f.material->api().id, family = assembly_.families[size_t(chunk.family)].name;
  if (const std::string fault = f.material->fault(); !fault.empty())
    throw Error(Exit::numerical, fmt::format("step {}, joint family '{}': {}", stepping_.count, family, fault));
  if (chunk.status != QUOIN_OK) {
    throw Error(Exit::numerical, fmt::format("law '{}' of joint family '{}' refused a batch with status {} at step {}",
                                             law, family, chunk.status, stepping_.count));
  }
  if (chunk.batch.count == 0)
    throw Error(Exit::numerical, fmt::format("law '{}' failed at step {}, on another rank", law, stepping_.count));
  // Failed points keep their old state, so asking again, this time with the status by point, names the same ones.
  std::vector<uint32_t> status(chunk.count, QUOIN_POINT_OK);
  quoin_batch batch = chunk.batch;
  batch.status = {status.data(), 1};
  f.material->evaluate(&batch);
  const auto first = std::find(status.begin(), status.end(), uint32_t(QUOIN_POINT_FAILED));
  const size_t i = chunk.first + std::min(size_t(first - status.begin()), size_t(chunk.count - 1));
  const Point& p = f.point[i];
  throw Error(
      Exit::numerical,
      fmt::format(
          "law '{}' failed at {} of {} points at step {}, time {:.6g} s: joint family '{}', blocks {} and {}, "
          "contact point at {}, opening {:.6g} m, slip in the step ({:.6g}, {:.6g}) m, traction ({:.6g}, {:.6g}, "
          "{:.6g}) Pa. A smaller solver.time_step_fraction than {:g} may help",
          law, chunk.batch.failed_count, chunk.count, stepping_.count, stepping_.time, family, label(assembly_, p.a),
          label(assembly_, p.b), place(place_of(p)), f.normal_jump[i], f.slip[0][i], f.slip[1][i], f.traction[0][i],
          f.traction[1][i], f.traction[2][i], solver_.time_step_fraction));
}

void Model::contact_forces(Family& f, Chunk& chunk, const Axes& axes) {
  chunk.damping = 0.0;
  if (viscous_contacts()) viscous_tractions(f, chunk);
  rigid_forces(chunk.pairs, bodies_.data(), rigid_columns(f));
  gridpoint_forces(chunk.gridpoint_pairs, axes.pairs, !small_, gridpoint_columns(f, chunk), chunks_.rows.data());
  facet_forces(chunk.facets, axes.triangles, facet_columns(f), chunks_.rows.data());
  for (const uint32_t i : chunk.others) {
    Point& p = f.point[i];
    double traction[3];
    for (int k = 0; k < 3; ++k) traction[k] = f.traction[k][i] + (f.viscous[k].empty() ? 0.0 : f.viscous[k][i]);
    p.shear[0] = traction[1], p.shear[1] = traction[2];
    p.force = {};
    if (traction[0] == 0 && traction[1] == 0 && traction[2] == 0) continue;
    p.force = p.area * in_space(p, traction[0] * p.n + traction[1] * p.s + traction[2] * p.t);
  }
}

// Stiffness-proportional damping.
void Model::viscous_tractions(Family& f, Chunk& chunk) {
  DampingColumns c{};
  const size_t first = chunk.first;
  for (int k = 0; k < 3; ++k) {
    c.traction[k] = f.traction[k].data() + first, c.old_traction[k] = f.old_traction[k].data() + first;
    c.viscous[k] = f.viscous[k].data() + first;
  }
  for (int k = 0; k < 2; ++k) c.slip[k] = f.slip[k].data() + first;
  c.normal_jump = f.normal_jump.data() + first, c.old_jump = f.old_jump.data() + first;
  c.area = f.area.data() + first;
  MaxwellColumns m{};
  m.normal_stiffness = f.kn, m.shear_stiffness = f.ks;
  for (size_t k = 0; has_maxwell() && k < std::size(f.maxwell); ++k) m.traction[k] = f.maxwell[k].data() + first;
  for (size_t e = 0; has_maxwell() && e < impacts_.maxwell.size(); ++e) {
    const double way = impacts_.maxwell[e].rate * stepping_.dt;
    m.keep[e] = std::exp(-way), m.gain[e] = -impacts_.maxwell[e].share * std::expm1(-way) / way;
  }
  if (impacts_damped())
    chunk.damping = damp_impacts(c, m, chunk.count, impacts_.beta[2 * size_t(chunk.family)] / stepping_.dt,
                                 impacts_.beta[2 * size_t(chunk.family) + 1] / stepping_.dt);
  else
    chunk.damping = damp_points(c, chunk.count, solver_.stiffness_damping / stepping_.dt);
}

// ---- Blocks --------------------------------------------------------------------------------------------------------

void Model::advance_piece(int index, PhaseClock* clock) {
  const Piece& piece = pieces_.all[size_t(index)];
  if (piece.kind == Piece::Kind::rigid)
    advance_bodies(pieces_.blocks_of(piece), clock);
  else
    advance_deformable(piece, clock);
}

// Up to kBodies deformable blocks side by side. Scratch of a thread.
struct Model::LaneGroup {
  std::vector<double> rows;  // forces on gridpoints, block after block
  LaneBlock block[kBodies];
  BlockSums* sums[kBodies];
  double power[kBodies];  // of loads, before the step
  size_t count = 0;
  std::span<const LaneBlock> blocks() const { return {block, count}; }
};

void Model::advance_deformable(const Piece& piece, PhaseClock* clock) {
  thread_local LaneGroup groups[2];
  thread_local LaneColumns columns[2];
  const size_t count = piece.group_count();
  for (size_t g = 0; g < count; ++g) find_forces(piece, g, groups[g], columns[g], clock);
  RigidGains gains[2];
  if (splits_motion()) split(piece, {columns, count}, gains);
  const GridpointStep step{stepping_.dt,
                           solver_.damping == DampingKind::local ? gamma() : 0.0,
                           viscous_alpha(solver_),
                           braking_ground(),
                           splits_motion() ? solver_.deformation_inertia : 1.0,
                           1.0 / solver_.mass_scaling,
                           actions_.gravity_factor.at(stepping_.time) * actions_.gravity,
                           energy_,
                           measured_};
  const CongruentBlocks* const shared = piece.congruent >= 0 ? &zones_.congruent[size_t(piece.congruent)] : nullptr;
  for (size_t g = 0; g < count; ++g) {
    const LaneGroup& group = groups[g];
    advance_gridpoints(group.blocks(), columns[g], splits_motion() ? &gains[g] : nullptr, step, shared, group.sums);
    for (size_t l = 0; energy_ && l < group.count; ++l) {
      const int block = pieces_.blocks_of(piece, g)[l];
      if (actions_.loaded[size_t(block)])
        group.sums[l]->external += 0.5 * stepping_.dt * (group.power[l] + power_on_gridpoints(block, stepping_.dt));
    }
  }
  lap(clock, Phase::motion);
}

// Of a group of a piece, in lanes: forces of contacts, loads and zones.
void Model::find_forces(const Piece& piece, size_t g, LaneGroup& group, LaneColumns& columns, PhaseClock* clock) {
  const std::span<const int32_t> blocks = pieces_.blocks_of(piece, g);
  group.count = blocks.size();
  columns.viscous = energy_ && zone_damping() > 0;
  const bool distinct = piece.kind == Piece::Kind::distinct;
  size_t size = 0;
  for (const int32_t block : blocks) size += kRow * size_t(blocks_[size_t(block)].node_count);
  group.rows.resize(std::max(group.rows.size(), 2 * size));
  double *force = group.rows.data(), *viscous = group.rows.data() + size;
  for (size_t l = 0; l < group.count; ++l) {
    const ModelBlock& b = blocks_[size_t(blocks[l])];
    BlockSums& sums = *(group.sums[l] = &step_sums_.of_block[size_t(blocks[l])]);
    sums = {};
    if (energy_ && actions_.loaded[size_t(blocks[l])]) group.power[l] = power_on_gridpoints(blocks[l], 0.0);
    const Vector acceleration = forces_on_gridpoints(blocks[l], force);
    if (!piece.in_frame()) {
      lap(clock, Phase::motion);
      zone_forces_of(b, sums, force, columns.viscous ? viscous : nullptr);
      lap(clock, Phase::internal_forces);
    }
    const size_t first = size_t(b.first_node);
    Vector moment;
    for (const MomentTouch pair : sides_.moment.of(blocks[l])) moment += pair->moment;
    group.block[l] = {&nodes_.x[first],
                      &nodes_.v[first],
                      force,
                      columns.viscous ? viscous : nullptr,
                      acceleration,
                      moment,
                      b.node_count,
                      zones_in_lanes(b),
                      piece.in_frame() ? &frames_.frame[size_t(blocks[l])] : nullptr};
    force += kRow * size_t(b.node_count), viscous += kRow * size_t(b.node_count);
  }
  lap(clock, Phase::motion);
  const FixedColumns<const double> fixed(pieces_.columns.data() + piece.columns[g], most_gridpoints(piece), distinct,
                                         piece.some_held);
  load_blocks(group.blocks(), fixed, &columns);
  if (piece.in_frame()) {
    const ZoneStep step{zone_damping(), stepping_.dt, energy_};
    FrameSums of_frame;
    if (distinct)
      distinct_forces(group.blocks(), step, &columns, &of_frame);
    else
      congruent_forces(group.blocks(), zones_.congruent[size_t(piece.congruent)], step, &columns, &of_frame);
    for (size_t l = 0; l < group.count; ++l) {
      group.sums[l]->deformation = of_frame.deformation[l];
      if (energy_) group.sums[l]->strain = of_frame.strain[l];
    }
  }
  lap(clock, Phase::internal_forces);
}

// Viscosity of zones: beta of stiffness-proportional damping, s.
double Model::zone_damping() const {
  if (solver_.damping == DampingKind::block)
    return solver_.deformation_damping * stepping_.critical_dt;  // 2 xi / omega_max
  if (impacts_damped()) return impacts_.zone_beta;
  return solver_.damping == DampingKind::viscous ? solver_.stiffness_damping : 0.0;
}

void Model::zone_forces_of(const ModelBlock& b, BlockSums& sums, double* force, double* viscous) {
  const ZoneStep step{zone_damping(), stepping_.dt, energy_};
  thread_local std::vector<double> rows;  // displacement, velocity
  const size_t column = kRow * size_t(b.node_count);
  rows.resize(std::max(rows.size(), 2 * column));
  double *const u = rows.data(), *const v = u + column;
  for (size_t i = 0; i < size_t(b.node_count); ++i) {
    const size_t node = size_t(b.first_node) + i;
    const Vector moved = nodes_.x[node] - nodes_.reference[node];
    u[kRow * i] = moved.x, u[kRow * i + 1] = moved.y, u[kRow * i + 2] = moved.z;
    if (step.beta > 0)
      v[kRow * i] = nodes_.v[node].x, v[kRow * i + 1] = nodes_.v[node].y, v[kRow * i + 2] = nodes_.v[node].z;
  }
  if (viscous) std::fill(viscous, viscous + column, 0.0);
  sums.strain += zone_forces(zones_in_lanes(b), step, {u, v, force, viscous});
}

template <class Visit>
void Model::each_load_on_gridpoints(int block, double since, const Visit& visit) const {
  for (const Load& l : actions_.loads) {
    if (l.block != block) continue;
    const Vector f = l.scale * l.factor.at(stepping_.time) * l.force;
    for (const auto& [node, weight] : l.share) visit(node, weight * f);
  }
  for (const Pressure& p : actions_.pressures) {
    if (p.block != block) continue;
    const double value = p.scale * p.value * p.factor.at(stepping_.time);
    for (const auto& t : p.triangles) {
      const auto edge = [&](size_t k) {
        return nodes_.x[t[k]] - nodes_.x[t[0]] - since * (nodes_.v[t[k]] - nodes_.v[t[0]]);
      };
      const Vector m = cross(edge(1), edge(2));
      for (int32_t node : t) visit(node, -value / 6 * m);
    }
  }
}

template <class Visit>
void Model::each_member_force(int block, const Visit& visit) const {
  if (!held_by_.members) return;
  for (const int node : held_by_.members->nodes_of(block)) visit(held_by_.members->nodes()[size_t(node)]);
}

Vector Model::forces_on_gridpoints(int block, double* force) {
  const ModelBlock& b = blocks_[size_t(block)];
  const auto add = [&](int32_t node, const Vector& f) {
    double* const row = force + kRow * size_t(node - b.first_node);
    row[0] += f.x, row[1] += f.y, row[2] += f.z;
  };
  Vector per_mass = actions_.gravity_factor.at(stepping_.time) * actions_.gravity;
  if (actions_.loaded[size_t(block)] && !actions_.applied.empty())
    per_mass += actions_.applied[size_t(block)] / mass_of(block);
  const Vector acceleration = per_mass / solver_.mass_scaling;
  std::fill(force, force + kRow * size_t(b.node_count), 0.0);
  Vector contacts = add_facet_rows(
      {sides_.owner.of(block), sides_.carrier.of(block), sides_.gridpoint.of(block), sides_.owner_gridpoint.of(block)},
      chunks_.rows.data(), force);
  for (const Touch& touch : sides_.single.of(block)) {
    const Family& f = contacts_.families[size_t(touch.family)];
    const Point& p = f.point[touch.point];
    if (touch.side_a) {
      const Facet& facet = contacts_.facets[p.facet_a];
      // The pair acts at p.at: shear times the gap is a couple that the triangle takes as normal forces.
      const double gap = f.normal_jump[touch.point] + p.reference;
      for (int i = 0; i < 3; ++i) {
        const double couple = -gap * p.area * (facet.gradient[i][0] * p.shear[0] + facet.gradient[i][1] * p.shear[1]);
        add(facet.node[i], facet.weight[i] * p.force + couple * p.n);
      }
      contacts += p.force;
    } else {
      const Facet& facet = contacts_.facets[p.facet_b];
      for (int i = 0; i < 3; ++i) add(facet.node[i], -facet.weight[i] * p.force);
      contacts -= p.force;
    }
  }
  each_member_force(block, [&](const members::Node& node) {
    for (const auto& [i, weight] : node.share) add(i, weight * node.force);
    contacts += node.force;
  });
  step_sums_.contact_force[size_t(block)] = contacts;
  if (!actions_.loaded[size_t(block)]) return acceleration;
  each_load_on_gridpoints(block, 0.0, add);
  return acceleration;
}

void Model::forces_on_body(int block) {
  Body& body = bodies_[size_t(blocks_[size_t(block)].body)];
  body.force = {}, body.torque = {};
  for (const PairTouch& touch : sides_.pair.of(block)) {
    const RigidPair& pair = *touch.pair;
    if (touch.side_a)
      body.force += pair.force, body.torque += pair.moment_a;
    else
      body.force -= pair.force, body.torque += pair.moment_b;
  }
  for (const Touch& touch : sides_.single.of(block)) {
    const Point& p = contacts_.families[size_t(touch.family)].point[touch.point];
    if (touch.side_a) {
      body.force += p.force;
      body.torque += cross(p.at - body.x, p.force);
    } else {
      body.force -= p.force;
      body.torque -= cross(p.at - body.x, p.force);
    }
  }
  each_member_force(block, [&](const members::Node& node) {
    body.force += node.force;
    body.torque += cross(node.x - body.x, node.force);
  });
  step_sums_.contact_force[size_t(block)] = body.force;
  body.force += body.weight_mass * (actions_.gravity_factor.at(stepping_.time) * actions_.gravity);
  if (!actions_.loaded[size_t(block)]) return;
  const Wrench loads = loads_on_body(block);
  body.force += loads.force, body.torque += loads.torque;
}

Model::Wrench Model::loads_on_body(int block) const {
  const Matrix& r = bodies_[size_t(blocks_[size_t(block)].body)].r;
  Wrench sum;
  if (!actions_.applied.empty()) sum.force += actions_.applied[size_t(block)];
  const auto add = [&](const Vector& force, const Vector& arm) {
    sum.force += force;
    sum.torque += cross(r * arm, force);
  };
  for (const Load& l : actions_.loads) {
    if (l.block == block) add(l.scale * l.factor.at(stepping_.time) * l.force, l.arm);
  }
  for (const Pressure& p : actions_.pressures) {
    if (p.block == block) add(p.scale * p.value * p.factor.at(stepping_.time) * (r * p.push), p.arm);
  }
  return sum;
}

double Model::power_on_gridpoints(int block, double since) const {
  double power = actions_.applied.empty() ? 0.0 : dot(actions_.applied[size_t(block)], velocity(block));
  each_load_on_gridpoints(block, since, [&](int32_t node, const Vector& f) { power += dot(f, nodes_.v[node]); });
  return power;
}

void Model::split(const Piece& piece, std::span<const LaneColumns> columns, RigidGains* gains) {
  const size_t count = columns.size();
  const std::span<const int32_t> blocks = pieces_.blocks_of(piece, 0);
  const InertiaFactors factors{solver_.deformation_inertia, solver_.unit_inertia};
  const double eq1 = solver_.damping == DampingKind::block ? gamma() : 0.0;
  RigidLanes lanes[2];
  split_motion(columns, int(blocks.size()), {factors, eq1, braking_ground(), stepping_.dt}, gains,
               measured_ ? lanes : nullptr);
  if (!measured_) return;
  const double alpha = viscous_alpha(solver_);
  for (size_t u = 0; u < blocks.size(); ++u) {
    const int lane = int(u);
    UnitInertia inertia;
    inertia.count = int(count);
    Rigid mean[2];  // velocity at the time of the forces
    BlockSums& of_unit = step_sums_.of_block[size_t(blocks[u])];
    for (size_t k = 0; k < count; ++k) {
      const RigidLanes& of_half = lanes[k];
      inertia.block[k] = inertia_in(of_half, gains[k], lane);
      mean[k] = 1 / (1 + 0.5 * alpha * stepping_.dt) *
                (motion_in(of_half.velocity, lane) + 0.5 * motion_in(of_half.change, lane));
      of_unit.damping += stepping_.dt * dot(motion_in(of_half.damping, lane), mean[k]);
    }
    if (count == 2) inertia.whole = RigidInertia(inertia.block[0], inertia.block[1]);
    const double rigid = rigid_energy(inertia, factors, mean);
    of_unit.kinetic += rigid;
    of_unit.damping += 2 * alpha * stepping_.dt * rigid;
  }
}

void Model::advance_bodies(std::span<const int32_t> blocks, PhaseClock* clock) {
  int32_t index[kBodies];
  BlockSums* sums[kBodies];
  Wrench loads[kBodies];
  double power[kBodies];  // theirs, before the step
  const auto power_of = [&](size_t i) {
    const Body& body = bodies_[size_t(index[i])];
    return dot(loads[i].force, body.v) + dot(loads[i].torque, body.omega);
  };
  const auto is_loaded = [&](size_t i) { return energy_ && actions_.loaded[size_t(blocks[i])]; };
  for (size_t i = 0; i < blocks.size(); ++i) {
    forces_on_body(blocks[i]);
    index[i] = blocks_[size_t(blocks[i])].body;
    sums[i] = &step_sums_.of_block[size_t(blocks[i])];
    if (is_loaded(i)) loads[i] = loads_on_body(blocks[i]), power[i] = power_of(i);
  }
  if (std::all_of(index, index + blocks.size(), [&](int32_t i) { return is_at_rest(bodies_[size_t(i)]); })) {
    for (size_t i = 0; i < blocks.size(); ++i) *sums[i] = {};
    return lap(clock, Phase::motion);
  }
  // A rigid block is its own rigid motion: damping by block is eq. 1.
  const bool eq1 = solver_.damping == DampingKind::local || solver_.damping == DampingKind::block;
  const Vector g = actions_.gravity_factor.at(stepping_.time) * actions_.gravity;
  const BodyStep step{stepping_.dt, eq1 ? gamma() : 0.0, viscous_alpha(solver_), braking_ground(), g, measured_};
  advance_rigid(bodies_.data(), checks_.seen.empty() ? nullptr : checks_.seen.data(), index, int(blocks.size()), step,
                sums);
  lap(clock, Phase::motion);
  for (size_t i = 0; i < blocks.size(); ++i) {
    if (is_loaded(i)) sums[i]->external += 0.5 * stepping_.dt * (power[i] + power_of(i));
  }
}

bool Model::has_deformed_too_much(int i) const {
  return !(step_sums_.of_block[size_t(i)].deformation <= kLargestDeformation * blocks_[size_t(i)].least_extent);
}

void Model::leave_frames() {
  bool some = false;
  for (const Piece& piece : pieces_.all) {
    if (!piece.in_frame()) continue;
    for (const int32_t i : pieces_.blocks_of(piece)) {
      if (has_deformed_too_much(i)) frames_.by_zone[size_t(i)] = 1, some = true;
    }
  }
  if (!some) return;
  take_back_facets();
  divide_work();
}

void Model::sum_up_members() {
  const members::Work work = held_by_.members->work();
  step_sums_.dissipated += work.dissipated - step_sums_.energies.members_dissipated;
  step_sums_.energies.members_stored = work.stored, step_sums_.energies.members_dissipated = work.dissipated;
  step_sums_.energies.external += work.outside - held_by_.work;
  held_by_.work = work.outside;
}

void Model::sum_up() {
  step_sums_.unbalanced = measured_kinetic_ = 0.0;
  step_sums_.net = {};
  for (int i = 0; i < block_count(); ++i) {
    const BlockSums& sums = step_sums_.of_block[size_t(i)];
    step_sums_.unbalanced = larger(step_sums_.unbalanced, sums.unbalanced);
    step_sums_.net += sums.net;
    measured_kinetic_ += sums.kinetic;
    checks_.any_deviates |= sums.deviates && owns(i);
  }
  if (!energy_) return;
  step_sums_.energies.contact_stored = step_sums_.energies.kinetic = step_sums_.energies.strain =
      step_sums_.dissipated = 0.0;
  for (const Chunk& chunk : chunks_.all) {
    step_sums_.energies.contact_stored += chunk.stored;
    for (int k = 0; k < QUOIN_DISSIPATED_COUNT; ++k) {
      step_sums_.energies.dissipated[k] += chunk.dissipated[k];
      step_sums_.dissipated += chunk.dissipated[k];
    }
    step_sums_.energies.damping += chunk.damping;
  }
  // Forces act from half a step before their time to half a step after it; energies are those at their time.
  step_sums_.energies.damping += step_sums_.later.damping;
  step_sums_.energies.external += step_sums_.later.external;
  step_sums_.energies.detection += step_sums_.later.detection;
  step_sums_.later = {};
  if (held_by_.members) sum_up_members();
  for (const BlockSums& sums : step_sums_.of_block) {
    step_sums_.energies.kinetic += sums.kinetic;
    step_sums_.energies.strain += sums.strain;
    step_sums_.later.damping += 0.5 * sums.damping;
    step_sums_.later.external += 0.5 * sums.external;
  }
  step_sums_.energies.damping += step_sums_.later.damping;
  step_sums_.energies.external += step_sums_.later.external;
}

}  // namespace quoin::blocks
