// The actions of a stage, and loops over all of them. On the lattice some act (Action::on_lattice).
#pragma once

#include <vector>

#include "base/archive.h"
#include "step/state.h"

namespace quoin {

std::vector<int> blocks_named_in(const Simulation::Impl& s, const Stage& settings);  // by any action of the stage
void bind_actions(Simulation::Impl& s, const Stage& settings, const Stage* previous);
void apply_actions(Simulation::Impl& s, double ramp);
void save_actions(ArchiveWriter& to, const Simulation::Impl& s);
void restore_actions(ArchiveReader& from, Simulation::Impl& s);

}  // namespace quoin
