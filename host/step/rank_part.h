// What each rank holds of a model on the lattice, where it is held in parts, and the highest frequency of all of it.
//
// Arrays have the numbers of the whole model; memory they have where this rank works (base/sparse_memory.h). That is
// for own items, the chunks that touch them, and what those chunks touch of others.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "base/sparse_memory.h"
#include "model/field.h"
#include "model/shared_model.h"
#include "step/state.h"

namespace quoin {

// Where each rank holds a part of the lattice.
struct HeldParts {
  std::vector<bool> items, chunks;
};
// Gridpoints, as numbers of arrays that have them, and contact points that this rank does not hold.
struct RowsElsewhere {
  std::vector<VectorRow> gridpoints, points;
};

HeldParts held_with(const Simulation::Impl& s, const RankShare& shares);
RowsElsewhere rows_elsewhere(const Simulation::Impl& s, const HeldParts& held);
// Of an array of a field with so many numbers, in order: visit(first, end). family: of its points; -1: of all.
void each_row_elsewhere(const Simulation::Impl& s, const RowsElsewhere& rows, Owner owner, int family,
                        std::size_t numbers, const std::function<void(std::size_t, std::size_t)>& visit);
void hold_all(Simulation::Impl& s);
void hold_part(Simulation::Impl& s);        // by share: gives back the memory of the rest
void hold_first_part(Simulation::Impl& s);  // and all agree on how stiff the stiffest joints are
std::unique_ptr<SharedModel> share_of_model(Simulation::Impl& s);

}  // namespace quoin
