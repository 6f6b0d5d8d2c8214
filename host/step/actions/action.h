// Actions of a stage on blocks: one file each in this folder, with its name in actions.cpp. Their keys are read in
// scene/actions.
#pragma once

#include <functional>
#include <string>

#include "base/archive.h"
#include "step/state.h"

namespace quoin {

// Functions that save and restore the state of an action in checkpoints; null: it has no state.
struct SavedState {
  void (*save)(ArchiveWriter& to, const Actions& state) = nullptr;
  void (*restore)(ArchiveReader& from, Actions& state) = nullptr;
};

template <class Archive, class Member>
void transfer_member(Archive& archive, Member& member) {
  if constexpr (requires { member.data(); })
    archive.array(member);
  else
    archive.value(member);
}

// SavedState of these members of Actions.
template <auto... kMembers>
inline constexpr SavedState kSaved{
    [](ArchiveWriter& to, const Actions& state) { (transfer_member(to, state.*kMembers), ...); },
    [](ArchiveReader& from, Actions& state) { (transfer_member(from, state.*kMembers), ...); }};

using VisitName = std::function<void(const std::string& block)>;

// An action on blocks. A function that the action does not need is null.
struct Action {
  // Visits the names of blocks in a stage. They are checked before the run, and all ranks receive their motion when the
  // stage begins.
  void (*names)(const Stage& stage, const VisitName& visit) = nullptr;
  // Binds the action when a stage begins. previous: the stage before; null: there is none.
  void (*bind)(Simulation::Impl& s, const Stage& stage, const Stage* previous) = nullptr;
  // Applies the action before a step. ramp: share of the stage's ramp that is done, 0 to 1.
  void (*apply)(Simulation::Impl& s, const Stage& stage, double ramp) = nullptr;
  SavedState saved{};
  bool on_lattice = false;  // whether bricks on the lattice have it; others end the lattice (scene/actions/actions.h)
};

}  // namespace quoin
