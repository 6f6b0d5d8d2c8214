// What ranks exchange in every step: the motion of their borders, and of what stages watch.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "step/state.h"

namespace quoin {

void bind_halo(Simulation::Impl& s);  // what neighbours request in every step, and all ranks of what stages watch
// Of gridpoints and bodies on borders: of those who move them to those who evaluate their contact points. Lattice.
using SideNumbers = std::function<void(int block, std::int32_t gridpoint, std::vector<double*>&)>;
Halo halo_on_borders(Simulation::Impl& s, const SideNumbers& numbers_of_side);
void receive_whole_borders(Simulation::Impl& s);  // displacement and velocity, which steps exchange in part
void send_motion(Simulation::Impl& s);
void receive_motion(Simulation::Impl& s, bool measure_step);  // after the blocks have moved

}  // namespace quoin
