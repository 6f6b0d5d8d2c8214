// Data of a run: the model, its state and quantities derived from them, one struct a role (step/state). Private to
// host/step; functions on these data are in the headers of their concepts.
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
#include "step/state/damage_growth.h"
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
  std::vector<std::shared_ptr<const Material>> first;  // by joint family, before any law swap
  std::vector<LawSwap> swaps;                          // swaps of the current stage
};

struct Simulation::Impl {
  Impl(Scene scene, int threads, Ranks* ranks);  // builds no model: see set_up.h

  Scene scene;
  mutable ThreadPool pool;  // results are made on it too
  Ranks* ranks = nullptr;   // null: one process alone
  TimeStepReport time_step;
  LawsOfRun laws;

  // Bricks on the lattice. In large motion the model holds joint families alone.
  Model model;
  LatticeState lattice;
  LatticeInertia inertia;
  LatticeContacts contacts;
  StepData data;
  std::optional<Assembly> left;  // bricks of the lattice while the run is in large motion

  // Model of blocks of any shape in large motion; null: the run is on the lattice.
  std::unique_ptr<blocks::Model> large_motion;

  // Loading, and quantities observed under it.
  RunProgress progress;
  Controls controls;
  Actions actions;
  StageMonitor monitor;
  Reactions reactions;
  EnergyBook energy;
  SmallMotion small_motion;
  Watch watch;
  DamageGrowth damage;
  Outcome outcome;

  // Division of work among threads and ranks, and its costs.
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
