// Contact points of the lattice in a step: the calls of their laws, and results beside tractions and states.
// Pointers are bound at set-up and after a law swap. Steps write the results; nothing is saved.
#pragma once

#include <array>
#include <atomic>
#include <vector>

#include "law/bound_call.h"
#include "model/model.h"
#include "step/implicit_contacts.h"

namespace quoin {

// Sums over the points of a chunk in measured steps.
struct ChunkSums {
  double force_sum = 0.0;  // sum of |force|, N
  double deepest = 0.0;    // smallest opening, m
  int deepest_point = -1;
  long crushed_out = 0;  // number of points that are crushed out, in steps that report flags
  Vec3 on_monitor{};     // force on the monitor's deformable blocks in the last row, N; with ranks
};

struct LatticeContacts {
  // By chunk. The columns of jumps are those of the thread that evaluates the call.
  std::vector<BoundCall> calls;
  std::vector<ChunkSums> sums;
  LaneVector<double> force[3];           // force on side a by contact point, x, y, z, then a dummy that stays 0, N
  LaneVector<double> energy_columns[5];  // J/m2 by contact point: stored, dissipated by mode; in runs with energies
  std::atomic<bool> law_failed{false};
  bool keep_diagnostics = false;
  ImplicitContacts implicit;      // in stages with solver.implicit_contacts
  std::vector<int> implicit_end;  // pieces of `implicit`: end of each thread's share

  void bind_energies(BoundCall& call, const ContactChunk& chunk) {
    const auto column = [&](std::size_t k) { return energy_columns[k].data() + chunk.first_point; };
    call.bind_energies(column(0), {column(1), column(2), column(3), column(4)});
  }
};

}  // namespace quoin
