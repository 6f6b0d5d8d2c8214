// The part of a lattice model that each rank holds, and vectors of the whole model for its highest frequency.
//
// Arrays have the indices of the whole model, but memory only for the rows that this rank uses (base/sparse_memory.h).
// These are of own items, of chunks that touch them, and of other items that those chunks touch.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "base/sparse_memory.h"
#include "model/field.h"
#include "model/shared_model.h"
#include "step/state.h"

namespace quoin {

// Items and chunks of the lattice that a rank holds.
struct HeldParts {
  std::vector<bool> items, chunks;
};
// Rows that this rank does not hold: of gridpoints, as indices into arrays by gridpoint, and of contact points.
struct RowsElsewhere {
  std::vector<VectorRow> gridpoints, points;
};

HeldParts held_with(const Simulation::Impl& s, const RankShare& shares);
RowsElsewhere rows_elsewhere(const Simulation::Impl& s, const HeldParts& held);
// Visits such rows in an array of a field, in ascending order: visit(first, end). numbers: size of the array. family:
// joint family of its points; -1: all.
void each_row_elsewhere(const Simulation::Impl& s, const RowsElsewhere& rows, Owner owner, int family,
                        std::size_t numbers, const std::function<void(std::size_t, std::size_t)>& visit);
void hold_all(Simulation::Impl& s);
void hold_part(Simulation::Impl& s);        // by WorkDivision::share; releases the memory of the rest
void hold_first_part(Simulation::Impl& s);  // then all ranks agree on the largest stiffness of joints
std::unique_ptr<SharedModel> share_of_model(Simulation::Impl& s);

}  // namespace quoin
