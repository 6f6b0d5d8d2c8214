// The actions of a stage, loops over all of them, and parts of some. On the lattice some act (Action::on_lattice).
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

// Parts of single actions, in the files of their names.
void build_members(Simulation::Impl& s);  // members of the scene
// drive: sets the force of a block along x, N, in place of that of the stage.
void pull_block(Simulation::Impl& s, int block, double pull);
void bind_floors(Simulation::Impl& s);  // bodies and blocks of the stage's floors
// Places the head of the jack where a stage begins. The force goes on from the stage before.
void begin_pull(Simulation::Impl& s, const Stage* previous);
void pull_whiffletree(Simulation::Impl& s);
// Whether the head of a push has gone so far that its displacement will not be reached.
bool push_lost(Simulation::Impl& s, std::vector<Warning>* warnings);
// Finds the blocks that rest on fixed ones, and the centre of their joints.
void find_blocks_on_base(Simulation::Impl& s);
// Whether the collapse stage has ended, after a check of displacements and loads. All ranks call it.
bool collapse_ended(Simulation::Impl& s, std::vector<Warning>* warnings);

}  // namespace quoin
