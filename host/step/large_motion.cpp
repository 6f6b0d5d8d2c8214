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
  if (pool_ && shared_division_ != divisions_) share_work();
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
  Chunk& chunk = chunks_[size_t(index)];
  Family& f = families_[size_t(chunk.family)];
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
  for (const Chunk& chunk : chunks_) {
    if (chunk.failed) report_failure(chunk);
  }
  sum_up();
  time_ += dt_;
  ++step_count_;
  watch();
  leave_frames();
  part_units();
  return moved_enough();
}

void Model::find_contacts() {
  fetch_();
  detect_contacts();
}

std::optional<WrongAnswer> Model::wrong_law(std::span<const int> chunks) const {
  for (const int c : chunks) {
    const Chunk& chunk = chunks_[size_t(c)];
    const Family& f = families_[size_t(chunk.family)];
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
  for (const Chunk& chunk : chunks_) {
    if (&chunk.batch == &batch)
      return fmt::format("contact points {} to {} of joint family '{}'", chunk.first, chunk.first + chunk.count - 1,
                         assembly_.families[size_t(chunk.family)].name);
  }
  return fmt::format("a batch of {} points", batch.count);
}

void Model::watch() const {
  for (int i = 0; i < block_count(); ++i) {
    if (std::isfinite(block_sums_[size_t(i)].positions)) continue;
    std::vector<int> all(chunks_.size());
    std::iota(all.begin(), all.end(), 0);
    if (const auto wrong = wrong_law(all); wrong && !wrong->finite)
      throw Error(Exit::numerical,
                  fmt::format("step {}, time {:.6g} s: {}; tell its author", step_count_, time_, wrong->text));
    throw Error(Exit::numerical,
                fmt::format("block {}, {} at the start: its position is no finite number at step {}, time {:.6g} s; "
                            "check the velocities and forces of the stage, or reduce time_step_fraction",
                            label(assembly_, i), place(start_[size_t(i)].x), step_count_, time_));
  }
}

void Model::run(double duration) {
  const double end = time_ + duration;
  while (time_ < end - 0.5 * dt_) step();
}

void Model::share_work() {
  std::vector<double> weight;
  for (int c = 0; c < chunk_count(); ++c) weight.push_back(chunk_work(c));
  chunk_end_ = shares(weight, pool_->thread_count());
  weight.clear();
  for (int p = 0; p < piece_count(); ++p) weight.push_back(piece_work(p));
  piece_end_ = shares(weight, pool_->thread_count());
  shared_division_ = divisions_;
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
  gridpoint_jumps(chunk.gridpoint_pairs, axes.pairs, small_ ? nullptr : frames_.data(), node_x_.data(),
                  gridpoint_columns(f, chunk));
  facet_jumps(chunk.facets, axes.triangles, node_x_.data(), facet_columns(f), small_);
  for (const uint32_t i : chunk.others) {
    Point& p = f.point[i];
    if (p.facet_a >= 0 && !small_) refresh_facet_frame(p, facets_[p.facet_a]);
    const Location now = locate(p, facets_);
    p.at = now.at;
    f.normal_jump[i] = now.jump;
    for (int k = 0; k < 2; ++k) f.slip[k][i] = now.slid[k] - f.slid[k][i], f.slid[k][i] = now.slid[k];
    if (p.facet_a >= 0 && !small_) {
      // The foot on the triangle follows the point, so that the pair of forces stays collinear.
      Facet& facet = facets_[p.facet_a];
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
  const Family& f = families_[size_t(chunk.family)];
  const std::string law = f.material->api().id, family = assembly_.families[size_t(chunk.family)].name;
  if (const std::string fault = f.material->fault(); !fault.empty())
    throw Error(Exit::numerical, fmt::format("step {}, joint family '{}': {}", step_count_, family, fault));
  if (chunk.status != QUOIN_OK) {
    throw Error(Exit::numerical, fmt::format("law '{}' of joint family '{}' refused a batch with status {} at step {}",
                                             law, family, chunk.status, step_count_));
  }
  if (chunk.batch.count == 0)
    throw Error(Exit::numerical, fmt::format("law '{}' failed at step {}, on another rank", law, step_count_));
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
          law, chunk.batch.failed_count, chunk.count, step_count_, time_, family, label(assembly_, p.a),
          label(assembly_, p.b), place(place_of(p)), f.normal_jump[i], f.slip[0][i], f.slip[1][i], f.traction[0][i],
          f.traction[1][i], f.traction[2][i], solver_.time_step_fraction));
}

void Model::contact_forces(Family& f, Chunk& chunk, const Axes& axes) {
  chunk.damping = 0.0;
  if (viscous_contacts()) viscous_tractions(f, chunk);
  rigid_forces(chunk.pairs, bodies_.data(), rigid_columns(f));
  gridpoint_forces(chunk.gridpoint_pairs, axes.pairs, !small_, gridpoint_columns(f, chunk), facet_rows_.data());
  facet_forces(chunk.facets, axes.triangles, facet_columns(f), facet_rows_.data());
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
  for (size_t e = 0; has_maxwell() && e < maxwell_.size(); ++e) {
    const double way = maxwell_[e].rate * dt_;
    m.keep[e] = std::exp(-way), m.gain[e] = -maxwell_[e].share * std::expm1(-way) / way;
  }
  if (impacts_damped())
    chunk.damping = damp_impacts(c, m, chunk.count, impact_beta_[2 * size_t(chunk.family)] / dt_,
                                 impact_beta_[2 * size_t(chunk.family) + 1] / dt_);
  else
    chunk.damping = damp_points(c, chunk.count, solver_.stiffness_damping / dt_);
}

// ---- Blocks --------------------------------------------------------------------------------------------------------

void Model::advance_piece(int index, PhaseClock* clock) {
  const Piece& piece = pieces_[size_t(index)];
  if (piece.kind == Piece::Kind::rigid)
    advance_bodies(blocks_of(piece), clock);
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
  const GridpointStep step{dt_,
                           solver_.damping == DampingKind::local ? gamma() : 0.0,
                           viscous_alpha(solver_),
                           braking_ground(),
                           splits_motion() ? solver_.deformation_inertia : 1.0,
                           1.0 / solver_.mass_scaling,
                           gravity_factor_.at(time_) * gravity_,
                           energy_,
                           measured_};
  const CongruentBlocks* const shared = piece.congruent >= 0 ? &congruent_[size_t(piece.congruent)] : nullptr;
  for (size_t g = 0; g < count; ++g) {
    const LaneGroup& group = groups[g];
    advance_gridpoints(group.blocks(), columns[g], splits_motion() ? &gains[g] : nullptr, step, shared, group.sums);
    for (size_t l = 0; energy_ && l < group.count; ++l) {
      const int block = blocks_of(piece, g)[l];
      if (loaded_[size_t(block)])
        group.sums[l]->external += 0.5 * dt_ * (group.power[l] + power_on_gridpoints(block, dt_));
    }
  }
  lap(clock, Phase::motion);
}

// Of a group of a piece, in lanes: forces of contacts, loads and zones.
void Model::find_forces(const Piece& piece, size_t g, LaneGroup& group, LaneColumns& columns, PhaseClock* clock) {
  const std::span<const int32_t> blocks = blocks_of(piece, g);
  group.count = blocks.size();
  columns.viscous = energy_ && zone_damping() > 0;
  const bool distinct = piece.kind == Piece::Kind::distinct;
  size_t size = 0;
  for (const int32_t block : blocks) size += kRow * size_t(blocks_[size_t(block)].node_count);
  group.rows.resize(std::max(group.rows.size(), 2 * size));
  double *force = group.rows.data(), *viscous = group.rows.data() + size;
  for (size_t l = 0; l < group.count; ++l) {
    const ModelBlock& b = blocks_[size_t(blocks[l])];
    BlockSums& sums = *(group.sums[l] = &block_sums_[size_t(blocks[l])]);
    sums = {};
    if (energy_ && loaded_[size_t(blocks[l])]) group.power[l] = power_on_gridpoints(blocks[l], 0.0);
    const Vector acceleration = forces_on_gridpoints(blocks[l], force);
    if (!piece.in_frame()) {
      lap(clock, Phase::motion);
      zone_forces_of(b, sums, force, columns.viscous ? viscous : nullptr);
      lap(clock, Phase::internal_forces);
    }
    const size_t first = size_t(b.first_node);
    Vector moment;
    for (const MomentTouch pair : moment_touches_.of(blocks[l])) moment += pair->moment;
    group.block[l] = {&node_x_[first],
                      &node_v_[first],
                      force,
                      columns.viscous ? viscous : nullptr,
                      acceleration,
                      moment,
                      b.node_count,
                      zones_in_lanes(b),
                      piece.in_frame() ? &frames_[size_t(blocks[l])] : nullptr};
    force += kRow * size_t(b.node_count), viscous += kRow * size_t(b.node_count);
  }
  lap(clock, Phase::motion);
  const FixedColumns<const double> fixed(piece_columns_.data() + piece.columns[g], most_gridpoints(piece), distinct,
                                         piece.some_held);
  load_blocks(group.blocks(), fixed, &columns);
  if (piece.in_frame()) {
    const ZoneStep step{zone_damping(), dt_, energy_};
    FrameSums of_frame;
    if (distinct)
      distinct_forces(group.blocks(), step, &columns, &of_frame);
    else
      congruent_forces(group.blocks(), congruent_[size_t(piece.congruent)], step, &columns, &of_frame);
    for (size_t l = 0; l < group.count; ++l) {
      group.sums[l]->deformation = of_frame.deformation[l];
      if (energy_) group.sums[l]->strain = of_frame.strain[l];
    }
  }
  lap(clock, Phase::internal_forces);
}

// Viscosity of zones: beta of stiffness-proportional damping, s.
double Model::zone_damping() const {
  if (solver_.damping == DampingKind::block) return solver_.deformation_damping * critical_dt_;  // 2 xi / omega_max
  if (impacts_damped()) return impact_zone_beta_;
  return solver_.damping == DampingKind::viscous ? solver_.stiffness_damping : 0.0;
}

void Model::zone_forces_of(const ModelBlock& b, BlockSums& sums, double* force, double* viscous) {
  const ZoneStep step{zone_damping(), dt_, energy_};
  thread_local std::vector<double> rows;  // displacement, velocity
  const size_t column = kRow * size_t(b.node_count);
  rows.resize(std::max(rows.size(), 2 * column));
  double *const u = rows.data(), *const v = u + column;
  for (size_t i = 0; i < size_t(b.node_count); ++i) {
    const size_t node = size_t(b.first_node) + i;
    const Vector moved = node_x_[node] - node_reference_[node];
    u[kRow * i] = moved.x, u[kRow * i + 1] = moved.y, u[kRow * i + 2] = moved.z;
    if (step.beta > 0)
      v[kRow * i] = node_v_[node].x, v[kRow * i + 1] = node_v_[node].y, v[kRow * i + 2] = node_v_[node].z;
  }
  if (viscous) std::fill(viscous, viscous + column, 0.0);
  sums.strain += zone_forces(zones_in_lanes(b), step, {u, v, force, viscous});
}

template <class Visit>
void Model::each_load_on_gridpoints(int block, double since, const Visit& visit) const {
  for (const Load& l : loads_) {
    if (l.block != block) continue;
    const Vector f = l.scale * l.factor.at(time_) * l.force;
    for (const auto& [node, weight] : l.share) visit(node, weight * f);
  }
  for (const Pressure& p : pressures_) {
    if (p.block != block) continue;
    const double value = p.scale * p.value * p.factor.at(time_);
    for (const auto& t : p.triangles) {
      const auto edge = [&](size_t k) {
        return node_x_[t[k]] - node_x_[t[0]] - since * (node_v_[t[k]] - node_v_[t[0]]);
      };
      const Vector m = cross(edge(1), edge(2));
      for (int32_t node : t) visit(node, -value / 6 * m);
    }
  }
}

template <class Visit>
void Model::each_member_force(int block, const Visit& visit) const {
  if (!members_) return;
  for (const int node : members_->nodes_of(block)) visit(members_->nodes()[size_t(node)]);
}

Vector Model::forces_on_gridpoints(int block, double* force) {
  const ModelBlock& b = blocks_[size_t(block)];
  const auto add = [&](int32_t node, const Vector& f) {
    double* const row = force + kRow * size_t(node - b.first_node);
    row[0] += f.x, row[1] += f.y, row[2] += f.z;
  };
  Vector per_mass = gravity_factor_.at(time_) * gravity_;
  if (loaded_[size_t(block)] && !applied_.empty()) per_mass += applied_[size_t(block)] / mass_of(block);
  const Vector acceleration = per_mass / solver_.mass_scaling;
  std::fill(force, force + kRow * size_t(b.node_count), 0.0);
  Vector contacts = add_facet_rows({owner_touches_.of(block), carrier_touches_.of(block), gridpoint_touches_.of(block),
                                    owner_gridpoint_touches_.of(block)},
                                   facet_rows_.data(), force);
  for (uint32_t k = block > 0 ? touch_end_[size_t(block) - 1] : 0; k < touch_end_[size_t(block)]; ++k) {
    const Touch& touch = touches_[k];
    const Family& f = families_[size_t(touch.family)];
    const Point& p = f.point[touch.point];
    if (touch.side_a) {
      const Facet& facet = facets_[p.facet_a];
      // The pair acts at p.at: shear times the gap is a couple that the triangle takes as normal forces.
      const double gap = f.normal_jump[touch.point] + p.reference;
      for (int i = 0; i < 3; ++i) {
        const double couple = -gap * p.area * (facet.gradient[i][0] * p.shear[0] + facet.gradient[i][1] * p.shear[1]);
        add(facet.node[i], facet.weight[i] * p.force + couple * p.n);
      }
      contacts += p.force;
    } else {
      const Facet& facet = facets_[p.facet_b];
      for (int i = 0; i < 3; ++i) add(facet.node[i], -facet.weight[i] * p.force);
      contacts -= p.force;
    }
  }
  each_member_force(block, [&](const members::Node& node) {
    for (const auto& [i, weight] : node.share) add(i, weight * node.force);
    contacts += node.force;
  });
  block_contact_force_[size_t(block)] = contacts;
  if (!loaded_[size_t(block)]) return acceleration;
  each_load_on_gridpoints(block, 0.0, add);
  return acceleration;
}

void Model::forces_on_body(int block) {
  Body& body = bodies_[size_t(blocks_[size_t(block)].body)];
  body.force = {}, body.torque = {};
  for (uint32_t k = block > 0 ? pair_touch_end_[size_t(block) - 1] : 0; k < pair_touch_end_[size_t(block)]; ++k) {
    const PairTouch& touch = pair_touches_[k];
    const RigidPair& pair = *touch.pair;
    if (touch.side_a)
      body.force += pair.force, body.torque += pair.moment_a;
    else
      body.force -= pair.force, body.torque += pair.moment_b;
  }
  for (uint32_t k = block > 0 ? touch_end_[size_t(block) - 1] : 0; k < touch_end_[size_t(block)]; ++k) {
    const Touch& touch = touches_[k];
    const Point& p = families_[size_t(touch.family)].point[touch.point];
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
  block_contact_force_[size_t(block)] = body.force;
  body.force += body.weight_mass * (gravity_factor_.at(time_) * gravity_);
  if (!loaded_[size_t(block)]) return;
  const Wrench loads = loads_on_body(block);
  body.force += loads.force, body.torque += loads.torque;
}

Model::Wrench Model::loads_on_body(int block) const {
  const Matrix& r = bodies_[size_t(blocks_[size_t(block)].body)].r;
  Wrench sum;
  if (!applied_.empty()) sum.force += applied_[size_t(block)];
  const auto add = [&](const Vector& force, const Vector& arm) {
    sum.force += force;
    sum.torque += cross(r * arm, force);
  };
  for (const Load& l : loads_) {
    if (l.block == block) add(l.scale * l.factor.at(time_) * l.force, l.arm);
  }
  for (const Pressure& p : pressures_) {
    if (p.block == block) add(p.scale * p.value * p.factor.at(time_) * (r * p.push), p.arm);
  }
  return sum;
}

double Model::power_on_gridpoints(int block, double since) const {
  double power = applied_.empty() ? 0.0 : dot(applied_[size_t(block)], velocity(block));
  each_load_on_gridpoints(block, since, [&](int32_t node, const Vector& f) { power += dot(f, node_v_[node]); });
  return power;
}

void Model::split(const Piece& piece, std::span<const LaneColumns> columns, RigidGains* gains) {
  const size_t count = columns.size();
  const std::span<const int32_t> blocks = blocks_of(piece, 0);
  const InertiaFactors factors{solver_.deformation_inertia, solver_.unit_inertia};
  const double eq1 = solver_.damping == DampingKind::block ? gamma() : 0.0;
  RigidLanes lanes[2];
  split_motion(columns, int(blocks.size()), {factors, eq1, braking_ground(), dt_}, gains, measured_ ? lanes : nullptr);
  if (!measured_) return;
  const double alpha = viscous_alpha(solver_);
  for (size_t u = 0; u < blocks.size(); ++u) {
    const int lane = int(u);
    UnitInertia inertia;
    inertia.count = int(count);
    Rigid mean[2];  // velocity at the time of the forces
    BlockSums& of_unit = block_sums_[size_t(blocks[u])];
    for (size_t k = 0; k < count; ++k) {
      const RigidLanes& of_half = lanes[k];
      inertia.block[k] = inertia_in(of_half, gains[k], lane);
      mean[k] =
          1 / (1 + 0.5 * alpha * dt_) * (motion_in(of_half.velocity, lane) + 0.5 * motion_in(of_half.change, lane));
      of_unit.damping += dt_ * dot(motion_in(of_half.damping, lane), mean[k]);
    }
    if (count == 2) inertia.whole = RigidInertia(inertia.block[0], inertia.block[1]);
    const double rigid = rigid_energy(inertia, factors, mean);
    of_unit.kinetic += rigid;
    of_unit.damping += 2 * alpha * dt_ * rigid;
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
  const auto is_loaded = [&](size_t i) { return energy_ && loaded_[size_t(blocks[i])]; };
  for (size_t i = 0; i < blocks.size(); ++i) {
    forces_on_body(blocks[i]);
    index[i] = blocks_[size_t(blocks[i])].body;
    sums[i] = &block_sums_[size_t(blocks[i])];
    if (is_loaded(i)) loads[i] = loads_on_body(blocks[i]), power[i] = power_of(i);
  }
  if (std::all_of(index, index + blocks.size(), [&](int32_t i) { return is_at_rest(bodies_[size_t(i)]); })) {
    for (size_t i = 0; i < blocks.size(); ++i) *sums[i] = {};
    return lap(clock, Phase::motion);
  }
  // A rigid block is its own rigid motion: damping by block is eq. 1.
  const bool eq1 = solver_.damping == DampingKind::local || solver_.damping == DampingKind::block;
  const Vector g = gravity_factor_.at(time_) * gravity_;
  const BodyStep step{dt_, eq1 ? gamma() : 0.0, viscous_alpha(solver_), braking_ground(), g, measured_};
  advance_rigid(bodies_.data(), seen_.empty() ? nullptr : seen_.data(), index, int(blocks.size()), step, sums);
  lap(clock, Phase::motion);
  for (size_t i = 0; i < blocks.size(); ++i) {
    if (is_loaded(i)) sums[i]->external += 0.5 * dt_ * (power[i] + power_of(i));
  }
}

bool Model::has_deformed_too_much(int i) const {
  return !(block_sums_[size_t(i)].deformation <= kLargestDeformation * blocks_[size_t(i)].least_extent);
}

void Model::leave_frames() {
  bool some = false;
  for (const Piece& piece : pieces_) {
    if (!piece.in_frame()) continue;
    for (const int32_t i : blocks_of(piece)) {
      if (has_deformed_too_much(i)) by_zone_[size_t(i)] = 1, some = true;
    }
  }
  if (!some) return;
  take_back_facets();
  divide_work();
}

void Model::sum_up_members() {
  const members::Work work = members_->work();
  dissipated_in_step_ += work.dissipated - energies_.members_dissipated;
  energies_.members_stored = work.stored, energies_.members_dissipated = work.dissipated;
  energies_.external += work.outside - members_work_;
  members_work_ = work.outside;
}

void Model::sum_up() {
  unbalanced_ = measured_kinetic_ = 0.0;
  net_ = {};
  for (int i = 0; i < block_count(); ++i) {
    const BlockSums& sums = block_sums_[size_t(i)];
    unbalanced_ = larger(unbalanced_, sums.unbalanced);
    net_ += sums.net;
    measured_kinetic_ += sums.kinetic;
    any_deviates_ |= sums.deviates && owns(i);
  }
  if (!energy_) return;
  energies_.contact_stored = energies_.kinetic = energies_.strain = dissipated_in_step_ = 0.0;
  for (const Chunk& chunk : chunks_) {
    energies_.contact_stored += chunk.stored;
    for (int k = 0; k < QUOIN_DISSIPATED_COUNT; ++k) {
      energies_.dissipated[k] += chunk.dissipated[k];
      dissipated_in_step_ += chunk.dissipated[k];
    }
    energies_.damping += chunk.damping;
  }
  // Forces act from half a step before their time to half a step after it; energies are those at their time.
  energies_.damping += later_.damping;
  energies_.external += later_.external;
  energies_.detection += later_.detection;
  later_ = {};
  if (members_) sum_up_members();
  for (const BlockSums& sums : block_sums_) {
    energies_.kinetic += sums.kinetic;
    energies_.strain += sums.strain;
    later_.damping += 0.5 * sums.damping;
    later_.external += 0.5 * sums.external;
  }
  energies_.damping += later_.damping;
  energies_.external += later_.external;
}

}  // namespace quoin::blocks
