// Reactions of supports and of prescribed motions.
#pragma once

#include <cstdint>
#include <vector>

#include "step/state.h"

namespace quoin {

// Currently held components of each body on the lattice, or of each block in large motion. Bits 0..2: x, y, z; 3..5:
// rotation about these axes.
std::vector<std::uint8_t> held_now(const Simulation::Impl& s);
// Finds the bodies or blocks of each restraint. Restraints themselves are found once, as they are columns of the
// history.
void find_restraints(Simulation::Impl& s);
void find_restrained_blocks(Simulation::Impl& s);
// Force and moment of the joints on these blocks, viscous forces included.
std::vector<JointWrench> sum_large_motion_wrenches(const Simulation::Impl& s, const std::vector<int>& blocks);
// Force on the whole wall, N, from that on the half that is computed with half_thickness. Its moment, N m, is about a
// point of the plane of symmetry. Forces across that plane cancel, and moments about axes in it.
Vec3 force_on_whole(const Simulation::Impl& s, const Vec3& of_half);
Vec3 moment_on_whole(const Simulation::Impl& s, const Vec3& of_half);
void measure_reactions(const Simulation::Impl& s, HistoryRow& row);

}  // namespace quoin
