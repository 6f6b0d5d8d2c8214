#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "base/error.h"
#include "base/larger.h"
#include "base/rank_rows.h"
#include "members/members.h"
#include "model/world_results.h"
#include "scene/collapse_load.h"
#include "scene/weight_axis.h"
#include "step/actions/action.h"
#include "step/actions/actions.h"
#include "step/actions/ground.h"
#include "step/block_motion.h"
#include "step/gather.h"
#include "step/rank_agreement.h"
#include "step/reactions.h"
#include "step/small_motion.h"
#include "step/stages.h"
#include "step/state.h"
#include "step/work_division.h"

namespace quoin {

using geometry::Vector;

namespace {

constexpr double kBed = 0.7;      // least |cosine| between the normal of a bed joint and the vertical
constexpr double kUplift = 1e-4;  // m, opening of a bed joint that counts as uplift
// Largest growth of the largest displacement in a window at rest, over the displacement of collapse. A load too large
// by 0.1 % of the weight moves a block by more, even with nine tenths of its acceleration lost to damping.
constexpr double kAtRest = 1e-3;
constexpr double kMostSeen = 0.01;  // m; largest displacement of collapse in the criterion for rest

// Length of a window, s: four times that of a free fall by the displacement in the criterion for rest.
double window_of(const Collapse& c, const Vec3& gravity) {
  return 4.0 * std::sqrt(2.0 * std::min(c.displacement, kMostSeen) / norm(geometry::vector(gravity)));
}

// Next load of a stage that waits for rest under each load.
// - While the load grows, since < 0. lowest is the time at which this began, s, highest the number of loads that are
//   reached.
// - While it is constant, since is the beginning of the window, s. Largest displacements, m: lowest of the last window,
//   highest of this one.
double waiting_load(FirstLoad* seen, const Stage& stage, double time, double multiplier, double moved) {
  const Collapse& c = *stage.collapse;
  const double window = window_of(c, stage.gravity);
  if (seen->since < 0.0) {
    const int reached = static_cast<int>(seen->highest);
    const double from = reached > 0 ? load_at(*c.start, reached - 1) : 0.0, to = load_at(*c.start, reached);
    const double s = (time - seen->lowest) / (reached > 0 ? 0.5 * window : std::max(stage.ramp_time, 2.0 * window));
    if (s < 1.0) return from + (to - from) * s * s * (3.0 - 2.0 * s);
    seen->since = time, seen->lowest = seen->highest = moved;
    return to;
  }
  seen->highest = std::max(seen->highest, moved);
  if (time - seen->since < window) return multiplier;
  if (seen->highest - seen->lowest <= kAtRest * std::min(c.displacement, kMostSeen)) {
    seen->carried = true, seen->since = -1.0, seen->lowest = time, seen->highest = last_stop(*c.start, multiplier) + 1;
    return multiplier;
  }
  seen->since = time, seen->lowest = seen->highest, seen->highest = moved;
  return multiplier;
}

// Displacement of the ground, which may move on after a record: of a block that moves with it, or of what lies below
// springs, m.
Vector ground_displacement(const Simulation::Impl& s) {
  if (const int ground = ground_block(s); ground >= 0) return moved_by_now(*s.large_motion, ground);
  return beds_of(s).empty() ? Vector{} : members_of(s)->ground();
}

// Displacement of a block against the ground since the stage began, m.
Vector displacement_in_stage(const Simulation::Impl& s, const Vector& ground, int block) {
  return position_of(*s.large_motion, block) - ground - s.actions.collapse_from[static_cast<std::size_t>(block)];
}

// Largest displacement of a block against the ground since the stage began, m.
double moved_in_stage(const Simulation::Impl& s) {
  const std::vector<int> rank = s.ranks ? rank_by_block(s) : std::vector<int>();
  const Vector ground = ground_displacement(s);
  const std::vector<std::uint8_t> held = held_now(s);
  double largest = 0.0;
  for (std::size_t i = 0; i < s.actions.collapse_from.size(); ++i) {
    const bool is_ground = s.large_motion->assembly.blocks[i].fixed && held[i] == kAllPrescribed;
    if (is_ground || (s.ranks && rank[i] != s.ranks->rank())) continue;
    largest = larger(largest, norm(displacement_in_stage(s, ground, static_cast<int>(i))));
  }
  return s.ranks ? largest_of_ranks(s, largest) : largest;
}

// Whether a contact of this rank has points, and lies in a bed.
bool is_bed(const Simulation::Impl& s, std::size_t contact) {
  const blocks::Contact& c = s.large_motion->contacts.list[contact];
  return c.count > 0 && s.large_motion->part.owns(c.pair) &&
         std::abs(s.large_motion->contacts.place[contact].separation.normal[upright_axis(s.scene)]) >= kBed;
}

// Visits bed joints of the start with their largest openings, m.
template <class Visit>
void each_opening(const Simulation::Impl& s, const Visit& visit) {
  const auto& contacts = s.large_motion->contacts;
  for (std::size_t k = 0; k < contacts.list.size(); ++k) {
    const blocks::Contact& c = contacts.list[k];
    if (!c.initial || !is_bed(s, k)) continue;
    const auto& jump = contacts.families[at(c.family)].normal_jump;
    visit(k, *std::max_element(jump.begin() + c.first, jump.begin() + c.first + c.count));
  }
}

void watch_uplift(Simulation::Impl& s) {
  if (s.outcome.base_slip_at_uplift) return;
  double opened = 0.0;
  each_opening(s, [&](std::size_t contact, double opening) {
    if (!std::ranges::binary_search(s.actions.open_beds, s.large_motion->contacts.list[contact].pair))
      opened = std::max(opened, opening);
  });
  if (s.parts.divided) opened = largest_of_ranks(s, opened);
  if (opened < kUplift) return;
  const Vector ground = ground_displacement(s);
  const int upright = upright_axis(s.scene);
  double slip = 0.0;  // since the stage began, m
  for (int b = 0; b < s.large_motion->block_count(); ++b) {
    if (!s.reactions.on_base[static_cast<std::size_t>(b)] || !s.large_motion->part.owns(b)) continue;
    const Vector moved = displacement_in_stage(s, ground, b);
    slip = std::max(slip, std::hypot(moved[(upright + 1) % 3], moved[(upright + 2) % 3]));
  }
  s.outcome.base_slip_at_uplift = s.parts.divided ? largest_of_ranks(s, slip) : slip;
}

void bind_collapse(Simulation::Impl& s, const Stage& settings, const Stage*) {
  s.actions.multiplier = 0.0;
  s.actions.first_load = {};
  s.actions.collapse_from.clear();
  if (!settings.collapse) return;
  if (!settings.collapse->start || !settings.collapse->limit)
    throw Error(Exit::bad_input,
                fmt::format("{}: collapse.start = \"limit\" is not found yet; give start as a number, times the weight",
                            settings.source.text));
}

// Beds that are open already, in the order of the pairs. All ranks have the list of contacts.
std::vector<geometry::Pair> open_beds(const Simulation::Impl& s) {
  const auto& contacts = s.large_motion->contacts.list;
  std::vector<char> is_open(contacts.size(), 0);
  each_opening(s, [&](std::size_t contact, double opening) { is_open[contact] = opening >= kUplift; });
  if (s.parts.divided)
    all_gather(s.ranks, std::span(is_open),
               [&](std::size_t contact) { return s.large_motion->part.rank_of(contacts[contact].pair); });
  std::vector<geometry::Pair> open;
  for (std::size_t k = 0; k < contacts.size(); ++k)
    if (is_open[k]) open.push_back(contacts[k].pair);
  return open;
}

// Sets collapse_from and open_beds. The ground is known when the stage has begun: a stage before may have moved it.
void note_start_of_collapse(Simulation::Impl& s) {
  s.actions.open_beds = open_beds(s);
  const Vector ground = ground_displacement(s);
  std::vector<Vector>& from = s.actions.collapse_from;
  for (int block = 0; block < s.large_motion->block_count(); ++block)
    from.push_back(position_of(*s.large_motion, block) - ground);
  if (s.ranks)
    all_gather(s.ranks, std::span(from), [rank = rank_by_block(s)](std::size_t block) { return rank[block]; });
}

// Adds the body force to the weight.
void apply_collapse(Simulation::Impl& s, const Stage& settings, double ramp) {
  if (!settings.collapse) return;
  if (s.actions.collapse_from.empty()) note_start_of_collapse(s);
  if (!waits(*settings.collapse))
    s.actions.multiplier = *settings.collapse->start * ramp +
                           *settings.collapse->rate * std::max(0.0, s.large_motion->stepping.time -
                                                                        s.progress.stage_start - settings.ramp_time);
  const Vector pull = s.actions.multiplier * norm(geometry::vector(settings.gravity)) *
                      normalized(geometry::vector(settings.collapse->direction));
  s.large_motion->set_gravity(geometry::vector(s.data.gravity) + pull);
  s.large_motion->actions.of_collapse += pull;
}

}  // namespace

void find_blocks_on_base(Simulation::Impl& s) {
  struct Bed {
    double area = 0.0;  // m2
    Vector moment;      // sum of area times position, m3
  };
  const auto& blocks = s.large_motion->assembly.blocks;
  const auto& contacts = s.large_motion->contacts.list;
  s.reactions.on_base.assign(blocks.size(), 0);
  std::vector<Bed> beds(contacts.size());  // by contact, of those with fixed blocks
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const blocks::Contact& c = contacts[i];
    if (!is_bed(s, i) ||
        s.large_motion->contacts.place[i].separation.distance > s.large_motion->detection.joint_tolerance)
      continue;
    const blocks::Family& family = s.large_motion->contacts.families[at(c.family)];
    const bool a_is_fixed = blocks[at(c.pair.a)].fixed, b_is_fixed = blocks[at(c.pair.b)].fixed;
    for (std::size_t p = c.first; a_is_fixed != b_is_fixed && p < c.first + c.count; ++p) {
      beds[i].area += family.point[p].area;
      beds[i].moment += family.point[p].area * place_of(*s.large_motion, family.point[p]);
    }
    if (a_is_fixed) s.reactions.on_base[at(c.pair.b)] = 1;
    if (b_is_fixed) s.reactions.on_base[at(c.pair.a)] = 1;
  }
  if (s.parts.divided) {
    const std::vector<int> rank = rank_by_block(s);
    all_gather(s.ranks, std::span(s.reactions.on_base), [&](std::size_t block) { return rank[block]; });
    all_gather(s.ranks, std::span(beds), [&](std::size_t i) { return rank[at(contacts[i].pair.a)]; });
  }
  for (const members::Bed& bed : beds_of(s)) {
    for (const members::SpringPoint& p : bed.points) {
      if (std::abs(p.out[upright_axis(s.scene)]) >= kBed)
        beds.push_back({p.area, p.area * members_of(s)->nodes()[at(p.node)].start});
    }
  }
  Bed all;
  for (const Bed& bed : beds) all.area += bed.area, all.moment += bed.moment;
  s.reactions.base_centre = all.area > 0.0 ? all.moment / all.area : Vector{};
}

bool collapse_ended(Simulation::Impl& s, std::vector<Warning>* warnings) {
  const Stage& settings = current_stage(s);
  if (!settings.collapse) return false;
  gather(s, Part::row);
  watch_uplift(s);
  const Collapse& c = *settings.collapse;
  const double moved = moved_in_stage(s);
  if (!(moved > c.displacement)) {
    if (waits(c))
      s.actions.multiplier = waiting_load(&s.actions.first_load, settings, stage_time(s), s.actions.multiplier, moved);
    else if (stage_time(s) >= settings.ramp_time)
      s.actions.first_load.look(stage_time(s), moved, 0.1 * c.displacement, FirstLoad::time_of(c, settings.gravity));
    if (!(s.actions.multiplier > *c.limit)) return false;
    warn_once(s, "collapse_multiplier",
              fmt::format("stage '{}' ends at collapse.limit = {:.4g}, and blocks have moved by {:.2g} m, less than "
                          "collapse.displacement = {:g}: the collapse multiplier is larger; give a larger limit",
                          settings.name, *c.limit, moved, c.displacement),
              warnings);
    return true;
  }
  if (*c.start <= 0.0 || s.actions.first_load.carried) {
    s.outcome.collapse_multiplier = s.actions.multiplier;
    return true;
  }
  warn_once(
      s, "collapse_multiplier",
      fmt::format("stage '{}': blocks have moved by {:g} m at the multiplier {:.4g} before they came to rest under "
                  "collapse.start = {:g}: the ramp has brought them there, and the collapse multiplier is not "
                  "known. It may lie below start or little above it; give a smaller start, or a longer ramp_time "
                  "({:g} s)",
                  settings.name, c.displacement, s.actions.multiplier, *c.start, settings.ramp_time),
      warnings);
  return true;
}

double FirstLoad::time_of(const Collapse& c, const Vec3& gravity) {
  return std::max(0.01 * *c.start / *c.rate, 4.0 * std::sqrt(2.0 * c.displacement / norm(geometry::vector(gravity))));
}

void FirstLoad::look(double time, double moved, double allowed, double needed) {
  lowest = std::min(lowest, moved), highest = std::max(highest, moved);
  if (since < 0.0 || highest - lowest > allowed) since = time, lowest = highest = moved;
  carried = carried || time - since >= needed;
}

extern const Action kCollapse{
    .bind = bind_collapse,
    .apply = apply_collapse,
    .saved = kSaved<&Actions::multiplier, &Actions::first_load, &Actions::collapse_from, &Actions::open_beds>};

}  // namespace quoin
