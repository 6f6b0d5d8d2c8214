// Contact points of the lattice in a step: the calls of their laws, and what these return beside tractions and states.
// Bound to the arrays of the model when it is set up or a law is swapped. Written in each step; nothing of it is saved.
#pragma once

#include <array>
#include <atomic>
#include <vector>

#include "model/model.h"
#include "step/implicit_contacts.h"

namespace quoin {

// One chunk's call of its law, with all columns in place; only the jumps differ by thread.
struct LawCall {
  quoin_batch batch{};
  std::vector<quoin_in> state_old;
  std::vector<quoin_out> state_new;
  std::vector<quoin_property_column> properties;  // properties that scatter
  double force_sum = 0.0;                         // sum of |force| in measured steps
  bool failed = false;
  quoin_status status = QUOIN_OK;
  double deepest = 0.0;  // smallest opening, m, measured steps
  int deepest_point = -1;
  long crushed_out = 0;                // contact points, steps that report flags
  double stored = 0.0;                 // J, energy steps
  std::array<double, 4> dissipated{};  // J during the last step, energy steps
  double damping = 0.0;                // J during the last step, by the damping of impacts
  Vec3 on_monitor{};                   // force of the last row on the deformable blocks of the monitor, N; with ranks
};

struct LatticeContacts {
  std::vector<LawCall> calls;            // by chunk
  LaneVector<double> force[3];           // x, y, z on side a by contact point, and a dummy, N
  LaneVector<double> energy_columns[5];  // stored, dissipated by mode; by contact point, energy runs only
  std::atomic<bool> law_failed{false};
  bool keep_diagnostics = false;
  ImplicitContacts implicit;      // implicit contacts, in stages that have them
  std::vector<int> implicit_end;  // ends of their pieces, by thread

  void bind_energies(LawCall& call, const ContactChunk& chunk) {
    call.batch.energy_stored = {energy_columns[0].data() + chunk.first_point, 1};
    for (std::size_t k = 0; k < 4; ++k)
      call.batch.dissipated[k] = {energy_columns[k + 1].data() + chunk.first_point, 1};
  }
};

}  // namespace quoin
