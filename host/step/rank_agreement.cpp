#include "step/rank_agreement.h"

#include <cstdio>
#include <cstdlib>
#include <optional>
#include <span>

#include "base/error.h"
#include "base/ranks.h"
#include "step/findings.h"
#include "step/gather.h"
#include "step/points_at_rest.h"
#include "step/state.h"

namespace quoin {

void begin_with_ranks(Simulation::Impl& s) {
  sparse_memory_wanted = true;
  if (const char* costly = std::getenv("QUOIN_DEAR_BLOCKS")) {
    s.rank_load.costly_blocks.emplace();
    if (std::sscanf(costly, "%dx%lf", &s.rank_load.costly_blocks->count, &s.rank_load.costly_blocks->times) != 2)
      throw Error(Exit::usage, "QUOIN_DEAR_BLOCKS, for tests: BLOCKSxTIMES, such as 20x4");
  }
}

void agree_on_model(const Simulation::Impl& s) {
  double here[] = {
      static_cast<double>(s.large_motion ? s.large_motion->block_count() : long(s.model.assembly.bricks.size())),
      static_cast<double>(contact_point_count(s)),
      s.data.time_step,
      0,
      0,
      0};
  for (std::size_t i = 0; i < 3; ++i) here[3 + i] = -here[i];
  s.ranks->largest(here);
  for (std::size_t i = 0; i < 3; ++i) {
    if (here[i] != -here[3 + i])
      throw Error(Exit::bad_input,
                  "the ranks have different models: the same program, scene and laws must be found by all of them");
  }
}

void note_waiting(Simulation::Impl& s, Clock::time_point since) {
  const double seconds = seconds_since(since);
  s.rank_load.traffic.waiting_seconds += seconds;
  s.timing.phases[Phase::ranks] += seconds;
}

bool ranks_together(const Simulation::Impl& s) { return s.agreed.together; }

bool agree(Simulation::Impl& s, bool trouble, bool* deviates, bool* leaves_frame) {
  const auto before = Clock::now();
  double wanted[] = {trouble ? 1.0 : 0.0, s.agreed.stop_wanted ? 1.0 : 0.0, deviates && *deviates ? 1.0 : 0.0,
                     leaves_frame && *leaves_frame ? 1.0 : 0.0};
  s.ranks->largest(wanted);
  note_waiting(s, before);
  s.agreed.stop = s.agreed.stop || wanted[1] > 0.0;
  if (deviates) *deviates = wanted[2] > 0.0;
  if (leaves_frame) *leaves_frame = wanted[3] > 0.0;
  if (wanted[0] > 0.0) gather(s, Part::all, Who::first);
  return wanted[0] > 0.0;
}

bool any_rank(Simulation::Impl& s, bool here) {
  if (!s.ranks) return here;
  return largest_of_ranks(s, here ? 1.0 : 0.0) > 0.0;
}

double largest_of_ranks(const Simulation::Impl& s, double here) {
  double largest[] = {here};
  s.ranks->largest(largest);
  return largest[0];
}

}  // namespace quoin
