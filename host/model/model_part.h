// The part of a shared model that one of several processes holds.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "base/error.h"
#include "base/rank_rows.h"
#include "base/ranks.h"
#include "geometry/broad_phase.h"
#include "geometry/vector.h"
#include "model/halo.h"

namespace quoin {

// Throws the fault of the lowest rank that has one, on all ranks. ranks: null: one process.
void throw_together(Ranks* ranks, const std::optional<Error>& fault);

}  // namespace quoin

namespace quoin::blocks {

using geometry::Vector;

// A single process owns everything, and has no ranks.
struct ModelPart {
  Ranks* ranks = nullptr;
  bool is_shared = false;           // whether other processes advance blocks too, of this part or of the whole model
  std::vector<int> rank_of_block;   // rank by block; empty: one process
  std::vector<bool> laid_out;       // by block
  std::vector<Vector> rough_place;  // approximate positions by block, on every rank, m
  Halo neighbours;                  // exchange of the motion of whole blocks that are close to those of other ranks
  std::vector<double> deviating;    // by block, as received from neighbours: 1 where it deviates, else 0
  // Called before contacts are detected or blocks change ranks. Fetches blocks that other processes have advanced.
  std::function<void()> fetch = [] {};

  bool owns(int block) const { return !ranks || rank_of_block[size_t(block)] == ranks->rank(); }
  bool owns(const geometry::Pair& pair) const { return owns(pair.a) || owns(pair.b); }
  int rank_of(const geometry::Pair& pair) const { return rank_of_block[size_t(pair.a)]; }

  // Gathers values by block from all ranks; nothing to do for a single process.
  template <class Memory>
  void gather_by_block(Memory& values) const {
    all_gather(ranks, std::span(values), [&](size_t block) { return rank_of_block[block]; });
  }
  bool any(bool here) const { return largest(here ? 1.0 : 0.0) > 0.0; }
  double largest(double here) const;
  void fail_together(const std::optional<Error>& here) const { throw_together(ranks, here); }
};

}  // namespace quoin::blocks
