// The explicit step of large motion: its phases, its sums, and its reports of failures.
#include "step/large_motion.h"

#include <fmt/format.h>

#include <cmath>
#include <numeric>

#include "base/error.h"
#include "base/larger.h"
#include "members/members.h"
#include "model/contact_frames.h"
#include "model/fixed_frames.h"
#include "model/world_results.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

void report_failure(const Model& m, const Chunk& chunk) {
  const Family& f = m.contacts.families[size_t(chunk.family)];
  const auto point = [&](size_t i) {
    const Point& p = f.point[chunk.first + i];
    return fmt::format("blocks {} and {}, contact point at {}", label(m.assembly, p.a), label(m.assembly, p.b),
                       place(place_of(m, p)));
  };
  report_failed_call(*f.material, chunk.call,
                     {m.stepping.count, m.stepping.time, m.solver.time_step_fraction,
                      m.assembly.families[size_t(chunk.family)].name, m.batch_text(chunk.call.batch), point});
}

void sum_up_members(Model& m) {
  const members::Work work = m.held_by.members->work();
  m.step_sums.dissipated += work.dissipated - m.step_sums.energies.members_dissipated;
  m.step_sums.energies.members_stored = work.stored, m.step_sums.energies.members_dissipated = work.dissipated;
  m.step_sums.energies.external += work.outside - m.held_by.work;
  m.held_by.work = work.outside;
}

void sum_up(Model& m) {
  m.step_sums.unbalanced = m.measured_kinetic = 0.0;
  m.step_sums.net = {};
  for (int i = 0; i < m.block_count(); ++i) {
    const BlockSums& sums = m.step_sums.of_block[size_t(i)];
    m.step_sums.unbalanced = larger(m.step_sums.unbalanced, sums.unbalanced);
    m.step_sums.net += sums.net;
    m.measured_kinetic += sums.kinetic;
  }
  if (!m.books_energy) return;
  m.step_sums.energies.contact_stored = m.step_sums.energies.kinetic = m.step_sums.energies.strain =
      m.step_sums.dissipated = 0.0;
  for (const Chunk& chunk : m.chunks.all) {
    m.step_sums.energies.contact_stored += chunk.call.stored;
    for (size_t k = 0; k < QUOIN_DISSIPATED_COUNT; ++k) {
      m.step_sums.energies.dissipated[k] += chunk.call.dissipated[k];
      m.step_sums.dissipated += chunk.call.dissipated[k];
    }
    m.step_sums.energies.damping += chunk.call.damping;
  }
  // A force does its work from half a step before its time to half a step after it. Energies are those at its time.
  m.step_sums.energies.damping += m.step_sums.later.damping;
  m.step_sums.energies.external += m.step_sums.later.external;
  m.step_sums.energies.detection += m.step_sums.later.detection;
  m.step_sums.later = {};
  if (m.held_by.members) sum_up_members(m);
  for (const BlockSums& sums : m.step_sums.of_block) {
    m.step_sums.energies.kinetic += sums.kinetic;
    m.step_sums.energies.strain += sums.strain;
    m.step_sums.energies.damping += sums.damping.before, m.step_sums.later.damping += sums.damping.after;
    m.step_sums.energies.external += sums.external.before, m.step_sums.later.external += sums.external.after;
  }
}

void watch(Model& m) {
  for (int i = 0; i < m.block_count(); ++i) {
    m.checks.any_deviates |= m.step_sums.of_block[size_t(i)].deviates && m.part.owns(i);
    if (std::isfinite(m.step_sums.of_block[size_t(i)].positions)) continue;
    std::vector<int> all(m.chunks.all.size());
    std::iota(all.begin(), all.end(), 0);
    if (const auto wrong = m.wrong_law(all); wrong && !wrong->finite)
      throw Error(Exit::numerical, fmt::format("step {}, time {:.6g} s: {}; tell its author", m.stepping.count,
                                               m.stepping.time, wrong->text));
    throw Error(
        Exit::numerical,
        fmt::format("block {}, {} at the start: its position is no finite number at step {}, time {:.6g} s; "
                    "check the velocities and forces of the stage, or reduce time_step_fraction",
                    label(m.assembly, i), place(m.poses.start[size_t(i)].x), m.stepping.count, m.stepping.time));
  }
}

void leave_frames(Model& m) {
  bool some = false;
  for (const Piece& piece : m.pieces.all) {
    if (!piece.in_frame()) continue;
    for (const int32_t i : m.pieces.blocks_of(piece)) {
      if (has_deformed_too_much(m, i)) m.frames.by_zone[size_t(i)] = 1, some = true;
    }
  }
  if (!some) return;
  take_back_facets(m);
  m.pieces.are_old = true;
  divide_work(m);
}

}  // namespace

void Model::begin_step(bool measure) {
  measured = measure || books_energy;
  copies_velocities = measured || part.is_shared || velocities_lent || checks_motion(*this);
  pieces.motion_is_old |= velocities_lent;
  follow_held(*this);
  if (frames.are_old) find_block_frames(*this);
  if (held_by.members) follow_members(*this);
}

bool Model::end_step() {
  pieces.motion_is_old = false, pieces.velocities_lag = !copies_velocities;
  for (const Chunk& chunk : chunks.all) {
    if (chunk.call.failed) report_failure(*this, chunk);
  }
  if (measured) sum_up(*this);
  stepping.time += stepping.dt;
  ++stepping.count;
  if (std::ranges::find(pieces.needs_check, 1) != pieces.needs_check.end()) {
    watch(*this);
    leave_frames(*this);
    std::ranges::fill(pieces.needs_check, 0);  // each step sets it again for own pieces
  }
  leave_fixed_frames(*this);
  part_units(*this);
  return moved_enough(*this);
}

void Model::find_contacts() {
  part.fetch();
  detect_contacts(*this);
}

ImpactDamping Model::impact_damping() const {
  ImpactDamping found;
  found.of_zones = impacts.share * impacts.zone_beta, found.in_use = impact_damping_in_use(*this);
  return found;
}

std::optional<WrongAnswer> Model::wrong_law(std::span<const int> own_chunks) const {
  for (const int c : own_chunks) {
    const Chunk& chunk = chunks.all[size_t(c)];
    const Family& f = contacts.families[size_t(chunk.family)];
    auto wrong = wrong_answer(f.material->api(), answers_of(chunk.call));
    if (!wrong) continue;
    const Point& p = f.point[chunk.first + wrong->point];
    wrong->text += fmt::format(": joint family '{}', blocks {} and {}, contact point at {}",
                               assembly.families[size_t(chunk.family)].name, label(assembly, p.a), label(assembly, p.b),
                               place(place_of(*this, p)));
    return wrong;
  }
  return std::nullopt;
}

std::string Model::batch_text(const quoin_batch& batch) const {
  for (const Chunk& chunk : chunks.all) {
    if (&chunk.call.batch == &batch)
      return fmt::format("contact points {} to {} of joint family '{}'", chunk.first, chunk.first + chunk.count - 1,
                         assembly.families[size_t(chunk.family)].name);
  }
  return fmt::format("a batch of {} points", batch.count);
}

}  // namespace quoin::blocks
