#include "step/damage_growth.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "base/rank_rows.h"
#include "step/borders.h"
#include "step/collect.h"
#include "step/gather.h"
#include "step/results.h"
#include "step/small_motion.h"
#include "step/stages.h"
#include "step/state.h"
#include "step/work_division.h"

namespace quoin {

namespace {

constexpr long kPassSteps = 50;  // least interval between two passes; one costs as much as two steps

double area_of(const Simulation::Impl& s, int chunk, std::int32_t in_chunk) {
  if (!s.large_motion) return s.model.area[at(s.model.chunks[at(chunk)].first_point + in_chunk)];
  const blocks::Chunk& c = s.large_motion->chunks.all[at(chunk)];
  return s.large_motion->contacts.families[at(c.family)].point[c.first + at(in_chunk)].area;
}

// Sum of A (1 - D) over the contact points, D the largest damage of a point. Places where blocks have come apart have
// none left. Each term is a whole number of 1e-12 m2, so that the sum has the same bits in any order, on any ranks.
double sound_area(Simulation::Impl& s) {
  constexpr double kUnits = 1e12;
  if (!s.parts.divided)
    gather(s, Part::all);
  else if (!s.large_motion)
    receive_whole_borders(s);
  double sum = 0.0;
  for (const ResultRun& run : runs_of_points(s)) {
    if (!brings(s, run)) continue;
    const PointRange points{run.first, run.end};
    const DamageColumns damage = damage_of_points(s, points);
    each_chunk_in(s, points, [&](int chunk, const PointRange& of_chunk) {
      for (std::int32_t p = of_chunk.first; p < of_chunk.end; ++p) {
        double most = damage[0][at(p - run.first)];
        for (const auto& column : damage) most = std::max(most, column[at(p - run.first)]);
        if (most < 1.0) sum += std::round(kUnits * area_of(s, chunk, p - of_chunk.first) * (1.0 - most));
      }
    });
  }
  if (!s.ranks) return sum;
  double of_all = 0.0;
  for (const double of_rank : of_all_ranks(*s.ranks, sum)) of_all += of_rank;
  return of_all;
}

}  // namespace

bool damage_has_grown(Simulation::Impl& s, bool stage_ends, std::vector<Warning>* warnings) {
  DamageGrowth& damage = s.damage;
  if (damage.sound_at_start == 0.0 || (s.progress.step < damage.next_pass && !stage_ends)) return false;
  damage.next_pass = s.progress.step + kPassSteps;
  const double sound = sound_area(s);
  const bool is_first = damage.sound_at_start < 0.0;
  if (is_first) damage.sound_at_start = sound;
  if (damage.sound_at_start == 0.0) {
    warn_once(
        s, "frames_at_damage",
        "output.frames_at_damage has no effect: no joint is sound, as bonded joints are whose law softens; remove it",
        warnings);
    return true;
  }
  damage.now = 1.0 - sound / damage.sound_at_start;
  if (!is_first && !(damage.now - damage.at_frame >= s.scene.output.frames_at_damage)) return false;
  if (damage.frames == kMostFramesAtDamage) {
    warn_once(
        s, fmt::format("frames_at_damage_{}", s.progress.stage + 1).c_str(),
        fmt::format("stage '{}' has {} frames where damage grows, the most of a stage, and later ones are left out "
                    "(joint_damage {:.3g} so far); give output.frames_at_damage more than {:g}",
                    current_stage(s).name, kMostFramesAtDamage, damage.now, s.scene.output.frames_at_damage),
        warnings);
    return false;
  }
  ++damage.frames, damage.at_frame = damage.now;
  return true;
}

}  // namespace quoin
