// What acts on blocks from outside in stages: one file each of this folder, and its name in actions.cpp. Their keys are
// read in scene/actions.
#pragma once

#include <functional>
#include <string>

#include "base/archive.h"
#include "step/state.h"

namespace quoin {

// State of an action in checkpoints.
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

// Of members of Actions.
template <auto... kMembers>
inline constexpr SavedState kSaved{
    [](ArchiveWriter& to, const Actions& state) { (transfer_member(to, state.*kMembers), ...); },
    [](ArchiveReader& from, Actions& state) { (transfer_member(from, state.*kMembers), ...); }};

using VisitName = std::function<void(const std::string& block)>;

// An action on blocks in large motion. Functions that it does not have are null.
struct Action {
  // Blocks that a stage names: looked up before anything runs, and known to all ranks when the stage begins.
  void (*names)(const Stage& stage, const VisitName& visit) = nullptr;
  // When a stage begins. previous: null: it is the first.
  void (*bind)(Simulation::Impl& s, const Stage& stage, const Stage* previous) = nullptr;
  // Before a step. ramp: how far that of the stage has come, 0 to 1.
  void (*apply)(Simulation::Impl& s, const Stage& stage, double ramp) = nullptr;
  SavedState saved{};
};

}  // namespace quoin
