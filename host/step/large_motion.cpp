// The explicit step of large motion: one function that names the phases, then the phases.
#include "step/large_motion.h"

#include <fmt/format.h>

#include "base/error.h"
#include "step/rigid_kernels.h"
#include "step/zone_kernels.h"

namespace quoin::blocks {

using namespace geometry;

void Model::step() {
  if (pool_ && shared_division_ != divisions_) share_work();
  begin_step();
  auto contacts = [&](int, int chunk) { advance_contacts(chunk); };
  auto blocks = [&](int, int block) { advance_block(block); };
  if (pool_) {
    pool_->for_each(chunk_end_, contacts);
    pool_->for_each(block_end_, blocks);
  } else {
    for (int c = 0; c < chunk_count(); ++c) contacts(0, c);
    for (int b = 0; b < block_count(); ++b) blocks(0, b);
  }
  end_step();
}

void Model::advance_contacts(int index, PhaseClock* clock) {
  Chunk& chunk = chunks_[size_t(index)];
  Family& f = families_[size_t(chunk.family)];
  contact_kinematics(f, chunk);  // jumps, in frames that ride on the blocks
  lap(clock, Phase::jumps);
  contact_law(f, chunk);  // tractions from jumps: the plug-in
  lap(clock, Phase::law);
  contact_forces(f, chunk);  // one force a point, which its two blocks fetch
  lap(clock, Phase::contact_forces);
}

void Model::end_step() {
  for (const Chunk& chunk : chunks_) {
    if (chunk.failed) report_failure(chunk);
  }
  sum_up();
  time_ += dt_;
  ++step_count_;
  watch();
  part_units();
  if (moved_enough()) detect_contacts();
}

std::optional<WrongAnswer> Model::wrong_law() const {
  for (size_t k = 0; k < families_.size(); ++k) {
    const Family& f = families_[k];
    Answers answers;
    answers.count = f.size();
    for (int c = 0; c < 3; ++c) answers.traction[c] = f.traction[c].data();
    for (const auto& column : f.state) answers.state.push_back(column.empty() ? nullptr : column.data());
    auto wrong = wrong_answer(f.material->api(), answers);
    if (!wrong) continue;
    const Point& p = f.point[wrong->point];
    wrong->text += fmt::format(": joint family '{}', blocks {} and {}, contact point at {}", assembly_.families[k].name,
                               label(assembly_, p.a), label(assembly_, p.b), place(place_of(p)));
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
    if (const auto wrong = wrong_law(); wrong && !wrong->finite)
      throw Error(Exit::numerical,
                  fmt::format("step {}, time {:.6g} s: {}; tell its author", step_count_, time_, wrong->text));
    throw Error(Exit::numerical,
                fmt::format("block {}, {} at the start: its position is no finite number at step {}, time {:.6g} s; "
                            "check the velocities and forces of the stage, or reduce time_step_fraction",
                            label(assembly_, i), place(start_x_[size_t(i)]), step_count_, time_));
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
  for (int b = 0; b < block_count(); ++b) weight.push_back(block_work(b));
  block_end_ = shares(weight, pool_->thread_count());
  shared_division_ = divisions_;
}

void Model::apply_ground_motion() {
  for (const GroundMotion& m : motions_) {
    const Vector v = m.acceleration.integral(time_ + 0.5 * dt_) * m.direction;
    for (int block : m.blocks) prescribe(block, v);
  }
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

}  // namespace

void Model::contact_kinematics(Family& f, Chunk& chunk) {
  rigid_jumps(chunk.pairs, bodies_.data(), rigid_columns(f));
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
  const size_t end = chunk.first + chunk.count;
  if (viscous_contacts()) {
    for (int k = 0; k < 3; ++k)
      std::copy(f.traction[k].begin() + chunk.first, f.traction[k].begin() + long(end),
                f.old_traction[k].begin() + chunk.first);
  }
  chunk.status = f.material->evaluate(&chunk.batch);
  chunk.failed = chunk.status != QUOIN_OK || chunk.batch.failed_count > 0;
  if (!energy_) return;
  chunk.stored = 0.0;
  for (double& d : chunk.dissipated) d = 0.0;
  for (size_t i = chunk.first; i < end; ++i) {
    chunk.stored += f.stored[i] * f.area[i];
    for (int k = 0; k < QUOIN_DISSIPATED_COUNT; ++k) chunk.dissipated[k] += f.dissipated[k][i] * f.area[i];
  }
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

void Model::contact_forces(Family& f, Chunk& chunk) {
  chunk.damping = 0.0;
  if (viscous_contacts()) viscous_tractions(f, chunk);
  rigid_forces(chunk.pairs, bodies_.data(), rigid_columns(f));
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

// Stiffness-proportional damping: the rate of the traction itself, so that slip and open joints are not damped. It may
// slow a closed contact but never pull on it.
void Model::viscous_tractions(Family& f, Chunk& chunk) {
  const double rate = solver_.stiffness_damping / dt_;
  for (size_t i = chunk.first; i < chunk.first + chunk.count; ++i) {
    const double sigma = f.traction[0][i];
    double viscous[3] = {0.0, 0.0, 0.0}, opening = 0.0;
    if (!std::isnan(f.old_jump[i])) {  // else born since: no rate is known
      viscous[0] = rate * (sigma - f.old_traction[0][i]);
      if (sigma <= 0) viscous[0] = std::min(viscous[0], -sigma);
      for (int k = 1; k < 3; ++k) viscous[k] = rate * (f.traction[k][i] - f.old_traction[k][i]);
      for (int k = 0; k < 3; ++k) {
        if (f.traction[k][i] == 0) viscous[k] = 0.0;
      }
      opening = f.normal_jump[i] - f.old_jump[i];
    }
    // Central differences: half of the motion is under the traction of the step before.
    const double way[3] = {opening, f.slip[0][i], f.slip[1][i]};
    for (int k = 0; k < 3; ++k) {
      chunk.damping += 0.5 * f.area[i] * (f.viscous[k][i] + viscous[k]) * way[k];
      f.viscous[k][i] = viscous[k];
    }
    f.old_jump[i] = f.normal_jump[i];
  }
}

// ---- Blocks --------------------------------------------------------------------------------------------------------

void Model::advance_block(int block, PhaseClock* clock) {
  const ModelBlock& b = blocks_[size_t(block)];
  if (b.body >= 0) {
    advance_bodies(block, clock);
    return;
  }
  const Unit unit = unit_of(block);
  if (unit.block[0] != block) return;  // goes with the first half
  for (int i : unit.blocks()) {
    block_sums_[size_t(i)] = {};
    internal_forces(blocks_[size_t(i)], block_sums_[size_t(i)]);
    lap(clock, Phase::internal_forces);
    forces_on_gridpoints(i);
  }
  if (splits_motion())
    integrate_unit(unit);
  else
    for (int i : unit.blocks()) integrate_gridpoints(blocks_[size_t(i)], nullptr, block_sums_[size_t(i)]);
  for (int i : unit.blocks()) {
    if (energy_ && loaded_[size_t(i)]) block_sums_[size_t(i)].external += work_of_loads(i);
  }
  lap(clock, Phase::motion);
}

// Viscosity of zones: beta of stiffness-proportional damping, s.
double Model::zone_damping() const {
  if (solver_.damping == DampingKind::block) return solver_.deformation_damping * critical_dt_;  // 2 xi / omega_max
  return solver_.damping == DampingKind::viscous ? solver_.stiffness_damping : 0.0;
}

void Model::internal_forces(const ModelBlock& b, BlockSums& sums) {
  constexpr size_t kRow = 4;
  const ZoneStep step{zone_damping(), dt_, energy_};
  const bool apart = energy_ && step.beta > 0;  // viscous forces are wanted by themselves
  thread_local std::vector<double> rows;        // displacement, velocity, force, viscous force
  const size_t column = kRow * size_t(b.node_count);
  rows.assign(4 * column, 0.0);
  double *const u = rows.data(), *const v = u + column, *const force = v + column, *const viscous = force + column;
  for (size_t i = 0; i < size_t(b.node_count); ++i) {
    const size_t node = size_t(b.first_node) + i;
    const Vector moved = node_x_[node] - node_reference_[node];
    u[kRow * i] = moved.x, u[kRow * i + 1] = moved.y, u[kRow * i + 2] = moved.z;
    if (step.beta > 0)
      v[kRow * i] = node_v_[node].x, v[kRow * i + 1] = node_v_[node].y, v[kRow * i + 2] = node_v_[node].z;
  }
  const std::span<const ZoneLanes> zones(zone_lanes_.data() + b.first_lanes, size_t(b.lanes_count()));
  sums.strain += zone_forces(zones, step, {u, v, force, viscous});
  for (size_t i = 0; i < size_t(b.node_count); ++i) {
    const size_t node = size_t(b.first_node) + i;
    const double *const f = force + kRow * i, *const fv = viscous + kRow * i;
    node_f_[node] = {f[0], f[1], f[2]};
    if (apart) node_viscous_f_[node] = {fv[0], fv[1], fv[2]};
  }
}

void Model::forces_on_gridpoints(int block) {
  const ModelBlock& b = blocks_[size_t(block)];
  Vector contacts;
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
        node_f_[facet.node[i]] += facet.weight[i] * p.force + couple * p.n;
      }
      contacts += p.force;
    } else {
      const Facet& facet = facets_[p.facet_b];
      for (int i = 0; i < 3; ++i) node_f_[facet.node[i]] -= facet.weight[i] * p.force;
      contacts -= p.force;
    }
  }
  block_contact_force_[size_t(block)] = contacts;
  const Vector g = gravity_factor_.at(time_) * gravity_;
  for (int i = b.first_node; i < b.first_node + b.node_count; ++i) node_f_[i] += node_weight_mass_[i] * g;
  if (!loaded_[size_t(block)]) return;
  if (!applied_.empty()) {
    const Vector per_mass = applied_[size_t(block)] / mass_of(block);
    for (int i = b.first_node; i < b.first_node + b.node_count; ++i) node_f_[i] += node_weight_mass_[i] * per_mass;
  }
  for (const Load& l : loads_) {
    if (l.block != block) continue;
    const Vector f = l.scale * l.factor.at(time_) * l.force;
    for (const auto& [node, weight] : l.share) node_f_[node] += weight * f;
  }
  for (const Pressure& p : pressures_) {
    if (p.block != block) continue;
    const double value = p.scale * p.value * p.factor.at(time_);
    for (const auto& t : p.triangles) {
      const Vector m = cross(node_x_[t[1]] - node_x_[t[0]], node_x_[t[2]] - node_x_[t[0]]);
      for (int32_t node : t) node_f_[node] -= value / 6 * m;
    }
  }
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
  block_contact_force_[size_t(block)] = body.force;
  body.force += body.weight_mass * (gravity_factor_.at(time_) * gravity_);
  if (!loaded_[size_t(block)]) return;
  if (!applied_.empty()) body.force += applied_[size_t(block)];
  for (const Load& l : loads_) {
    if (l.block != block) continue;
    const Vector f = l.scale * l.factor.at(time_) * l.force;
    body.force += f;
    body.torque += cross(body.r * l.arm, f);
  }
  for (const Pressure& p : pressures_) {
    if (p.block != block) continue;
    const Vector f = p.scale * p.value * p.factor.at(time_) * (body.r * p.push);
    body.force += f;
    body.torque += cross(body.r * p.arm, f);
  }
}

double Model::work_of_loads(int block) const {
  const ModelBlock& b = blocks_[size_t(block)];
  double work = applied_.empty() ? 0.0 : dot(applied_[size_t(block)], velocity(block)) * dt_;
  for (const Load& l : loads_) {
    if (l.block != block) continue;
    const Vector f = l.scale * l.factor.at(time_) * l.force;
    if (b.body >= 0) {
      const Body& body = bodies_[size_t(b.body)];
      work += dot(f, body.v + cross(body.omega, body.r * l.arm)) * dt_;
    } else {
      for (const auto& [node, weight] : l.share) work += weight * dot(f, node_v_[node]) * dt_;
    }
  }
  for (const Pressure& p : pressures_) {
    if (p.block != block) continue;
    const double value = p.scale * p.value * p.factor.at(time_);
    if (b.body >= 0) {
      const Body& body = bodies_[size_t(b.body)];
      work += value * dot(body.r * p.push, body.v + cross(body.omega, body.r * p.arm)) * dt_;
    } else {
      for (const auto& t : p.triangles) {
        const Vector m = cross(node_x_[t[1]] - node_x_[t[0]], node_x_[t[2]] - node_x_[t[0]]);
        for (int32_t node : t) work -= value / 6 * dot(m, node_v_[node]) * dt_;
      }
    }
  }
  return work;
}

namespace {

// The larger of the two; NaN wins, so that it is seen.
double larger(double so_far, double x) { return x <= so_far ? so_far : x; }

// New velocity of one degree of freedom of mass m under force f, with the damping asked for; work of damping into
// `taken`.
struct Damper {
  double gamma;  // local
  double alpha;  // viscous, mass proportional, 1/s
  double dt;
  double velocity(double v, double f, double m, double& taken) const {
    if (gamma > 0) {
      const double damping = v == 0 ? 0 : -std::copysign(gamma * std::abs(f), v);
      const double next = v + dt / m * (f + damping);
      taken -= damping * 0.5 * (v + next) * dt;
      return next;
    }
    if (alpha > 0) {
      const double next = ((1 - 0.5 * alpha * dt) * v + dt / m * f) / (1 + 0.5 * alpha * dt);
      const double mean = 0.5 * (v + next);
      taken += alpha * m * mean * mean * dt;
      return next;
    }
    return v + dt / m * f;
  }
};

double viscous_alpha(const SolverSettings& solver) {
  return solver.damping == DampingKind::viscous ? solver.mass_damping : 0.0;
}

}  // namespace

// Inertia scaled apart, damping by block (inertia.h).
void Model::integrate_unit(const Unit& unit) {
  const UnitInertia inertia = inertia_of(unit);
  const InertiaFactors factors{solver_.deformation_inertia, solver_.unit_inertia};
  Rigid momentum[2], force[2];
  for (int k = 0; k < unit.count; ++k) {
    const Gridpoints g = gridpoints_of(unit.block[k]);
    momentum[k] = sum_about(inertia.block[k].centre(), g.x, g.v, g.mass);
    force[k] = sum_about(inertia.block[k].centre(), g.x, g.f);
  }
  const double eq1 = solver_.damping == DampingKind::block ? gamma() : 0.0;
  const RigidStep step = rigid_step(inertia, factors, eq1, dt_, momentum, force);
  for (int k = 0; k < unit.count; ++k)
    integrate_gridpoints(blocks_[size_t(unit.block[k])], &step.gain[k], block_sums_[size_t(unit.block[k])]);
  if (!energy_) return;
  const double alpha = viscous_alpha(solver_);
  BlockSums& sums = block_sums_[size_t(unit.block[0])];
  Rigid mean[2];  // velocity at the time of the forces
  for (int k = 0; k < unit.count; ++k) {
    mean[k] = 1 / (1 + 0.5 * alpha * dt_) * (step.velocity[k] + 0.5 * step.change[k]);
    sums.damping += dt_ * dot(step.damping[k], mean[k]);
  }
  const double rigid = rigid_energy(inertia, factors, mean);
  sums.kinetic += rigid;
  sums.damping += 2 * alpha * dt_ * rigid;
}

// gain: of motion that is split; null: true inertia.
void Model::integrate_gridpoints(const ModelBlock& b, const RigidGain* gain, BlockSums& sums) {
  const Damper damper{solver_.damping == DampingKind::local ? gamma() : 0.0, viscous_alpha(solver_), dt_};
  const double factor = gain ? solver_.deformation_inertia : 1.0;
  const bool viscous = energy_ && zone_damping() > 0;
  double taken = 0.0, unbalanced = 0.0;  // of the latter the square
  const Vector g = gravity_factor_.at(time_) * gravity_;
  for (int i = b.first_node; i < b.first_node + b.node_count; ++i) {
    Vector& v = node_v_[i];
    const Vector before = v, force = node_f_[i];
    const Vector driving =
        gain ? 1 / factor * force + node_mass_[i] / dt_ * gain->at(node_x_[i]) : force;  // of the true mass
    double free = 0.0, energy = 0.0;
    for (int k = 0; k < 3; ++k) {
      if (node_held_[i] >> k & 1) {
        v[k] = node_held_v_[i][k];
        if (energy_) sums.external += (node_weight_mass_[i] * g[k] - force[k]) * 0.5 * (v[k] + before[k]) * dt_;
      } else {
        v[k] = damper.velocity(v[k], driving[k], node_mass_[i], taken);
        free += force[k] * force[k];
        sums.net[k] += force[k];
        energy += factor * (before[k] + v[k]) * (before[k] + v[k]);
        if (energy_) sums.external += node_weight_mass_[i] * g[k] * 0.5 * (v[k] + before[k]) * dt_;
      }
    }
    unbalanced = larger(unbalanced, free);
    sums.kinetic += 0.125 * node_mass_[i] * energy;
    if (viscous) sums.damping -= 0.5 * dt_ * dot(node_viscous_f_[i], before + v);
    node_x_[i] += dt_ * v;
    sums.positions += node_x_[i].x + node_x_[i].y + node_x_[i].z;
  }
  sums.damping += factor * taken;
  sums.unbalanced = std::sqrt(unbalanced);
}

// The rigid blocks that begin with this one: those of a vector.
void Model::advance_bodies(int first, PhaseClock* clock) {
  int32_t index[kBodies];
  BlockSums* sums[kBodies];
  int count = 0;
  for (int block = first; count < bodies_with(first); ++block, ++count) {
    forces_on_body(block);
    index[count] = blocks_[size_t(block)].body;
    sums[count] = &block_sums_[size_t(block)];
  }
  if (count == 0) return;  // moves on with one before it
  // A rigid block is its own rigid motion: damping by block is eq. 1.
  const bool eq1 = solver_.damping == DampingKind::local || solver_.damping == DampingKind::block;
  const Vector g = gravity_factor_.at(time_) * gravity_;
  const BodyStep step{dt_, eq1 ? gamma() : 0.0, viscous_alpha(solver_), g, energy_};
  advance_rigid(bodies_.data(), index, count, step, sums);
  lap(clock, Phase::motion);
  if (!energy_) return;
  for (int block = first; block < first + count; ++block) {
    if (loaded_[size_t(block)]) block_sums_[size_t(block)].external += work_of_loads(block);
  }
}

void Model::sum_up() {
  unbalanced_ = 0.0;
  net_ = {};
  for (const BlockSums& sums : block_sums_) {
    unbalanced_ = larger(unbalanced_, sums.unbalanced);
    net_ += sums.net;
  }
  if (!energy_) return;
  energies_.contact_stored = energies_.kinetic = energies_.strain = 0.0;
  for (const Chunk& chunk : chunks_) {
    energies_.contact_stored += chunk.stored;
    for (int k = 0; k < QUOIN_DISSIPATED_COUNT; ++k) energies_.dissipated[k] += chunk.dissipated[k];
    energies_.damping += chunk.damping;
  }
  // Forces act from half a step before their time to half a step after it; energies are those at their time.
  energies_.damping += later_.damping;
  energies_.external += later_.external;
  energies_.detection += later_.detection;
  later_ = {};
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
