// Exchange between ranks in every step: motion at their borders, and of the blocks that a stage monitors.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "step/state.h"

namespace quoin {

// Binds the halo: motion that neighbours read in every step, and that of monitored blocks, which all ranks read.
void bind_halo(Simulation::Impl& s);
// Halo of numbers at borders, from ranks that move gridpoints and bodies to ranks that evaluate their contact points.
// numbers_of_side appends the addresses of a side's numbers. Lattice.
using SideNumbers = std::function<void(int block, std::int32_t gridpoint, std::vector<double*>&)>;
Halo halo_on_borders(Simulation::Impl& s, const SideNumbers& numbers_of_side);
// Exchanges displacements and velocities at borders in full: steps exchange the components that joints read.
void receive_whole_borders(Simulation::Impl& s);
void send_motion(Simulation::Impl& s);
// Receives the halo after the blocks have moved. Also agrees on failures, and gathers the sums of a measured step.
void receive_motion(Simulation::Impl& s, bool measure_step);

}  // namespace quoin
