// Contact points of the lattice in a step: the calls of their laws, and results of these beside tractions and states.
// Pointers are bound at set-up and after a law swap. Steps write the results; nothing is saved.
#pragma once

#include <array>
#include <atomic>
#include <vector>

#include "model/model.h"
#include "step/implicit_contacts.h"

namespace quoin {

// The law call of one chunk, with all columns bound. The columns of jumps are those of the thread that evaluates it.
struct LawCall {
  quoin_batch batch{};
  std::vector<quoin_in> state_old;
  std::vector<quoin_out> state_new;
  std::vector<quoin_property_column> properties;  // properties that scatter
  double force_sum = 0.0;                         // sum of |force|, N, in measured steps
  bool failed = false;
  quoin_status status = QUOIN_OK;
  double deepest = 0.0;  // smallest opening, m, in measured steps
  int deepest_point = -1;
  long crushed_out = 0;                // number of points that are crushed out, in steps that report flags
  double stored = 0.0;                 // elastic energy, J, in steps with energies
  std::array<double, 4> dissipated{};  // J in the last step, in steps with energies
  double damping = 0.0;                // energy taken by impact damping in the last step, J
  Vec3 on_monitor{};                   // force on the monitor's deformable blocks in the last row, N; with ranks
};

struct LatticeContacts {
  std::vector<LawCall> calls;            // by chunk
  LaneVector<double> force[3];           // force on side a by contact point, x, y, z, then a dummy that stays 0, N
  LaneVector<double> energy_columns[5];  // J/m2 by contact point: stored, dissipated by mode; in runs with energies
  std::atomic<bool> law_failed{false};
  bool keep_diagnostics = false;
  ImplicitContacts implicit;      // in stages with solver.implicit_contacts
  std::vector<int> implicit_end;  // pieces of `implicit`: end of each thread's share

  void bind_energies(LawCall& call, const ContactChunk& chunk) {
    call.batch.energy_stored = {energy_columns[0].data() + chunk.first_point, 1};
    for (std::size_t k = 0; k < 4; ++k)
      call.batch.dissipated[k] = {energy_columns[k + 1].data() + chunk.first_point, 1};
  }
};

}  // namespace quoin
