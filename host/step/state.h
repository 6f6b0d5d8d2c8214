// All that a run has: the model, its state, and what follows from them, one struct a role (step/state). Private to this
// folder; functions on it are in the header of their concept.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "base/index.h"
#include "base/thread_pool.h"
#include "step/large_motion.h"
#include "step/simulation.h"
#include "step/state/actions.h"
#include "step/state/controls.h"
#include "step/state/energy_book.h"
#include "step/state/lattice_contacts.h"
#include "step/state/lattice_inertia.h"
#include "step/state/lattice_state.h"
#include "step/state/monitor.h"
#include "step/state/rank_agreement.h"
#include "step/state/rank_load.h"
#include "step/state/rank_parts.h"
#include "step/state/reactions.h"
#include "step/state/run_progress.h"
#include "step/state/small_motion.h"
#include "step/state/step_timing.h"
#include "step/state/work_division.h"

namespace quoin {

// Laws of a run that stages may swap.
struct LawsOfRun {
  std::vector<std::shared_ptr<const Material>> first;  // by joint family, before any law is swapped
  std::vector<LawSwap> swaps;                          // swaps of the current stage
};

struct Simulation::Impl {
  Impl(Scene scene, int threads, Ranks* ranks);  // without a model: set_up.h

  Scene scene;
  ThreadPool pool;
  Ranks* ranks = nullptr;  // null: one process alone
  TimeStepReport time_step;
  LawsOfRun laws;

  // Bricks on the lattice; the model has the joint families of large motion, too.
  Model model;
  LatticeState lattice;
  LatticeInertia inertia;
  LatticeContacts contacts;
  StepData data;
  std::optional<Assembly> left;  // by a promotion

  // Blocks of any shape in large motion; null: none.
  std::unique_ptr<blocks::Model> large_motion;

  // The loading, and what is seen of it.
  RunProgress progress;
  Controls controls;
  Actions actions;
  StageMonitor monitor;
  Reactions reactions;
  EnergyBook energy;
  SmallMotion small_motion;
  Watch watch;
  Outcome outcome;

  // Who does what, in which time.
  WorkDivision division;
  StepTiming timing;
  RankParts parts;
  RankLoad rank_load;
  RankAgreement agreed;
};

inline int block_count(const Simulation::Impl& s) {
  return static_cast<int>(s.large_motion ? s.large_motion->blocks.size() : s.model.assembly.bricks.size());
}

}  // namespace quoin
