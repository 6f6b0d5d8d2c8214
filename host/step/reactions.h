// Reactions of supports and of prescribed motions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "step/state.h"

namespace quoin {

// Currently held components of each block. Bits 0..2: x, y, z; 3..5: rotation about these axes.
std::vector<std::uint8_t> held_now(const Simulation::Impl& s);
// Finds the blocks of each restraint. Restraints themselves are found once, as they are columns of the
// history.
void find_restraints(Simulation::Impl& s);
void find_restrained_blocks(Simulation::Impl& s);
// Force and moment of the joints on these blocks, viscous forces included.
std::vector<JointWrench> sum_large_motion_wrenches(const Simulation::Impl& s, const std::vector<int>& blocks);
// Force on the whole wall, N, from that on the half that is computed with half_thickness. Its moment, N m, is about a
// point of the plane of symmetry. Forces across that plane cancel, and moments about axes in it.
Vec3 force_on_whole(const Simulation::Impl& s, const Vec3& of_half);
Vec3 moment_on_whole(const Simulation::Impl& s, const Vec3& of_half);
// Forces and moments of the joints on Reactions::restrained_blocks.
std::vector<JointWrench> wrenches_of_supports(const Simulation::Impl& s);
// held: as held_now().
void measure_reactions(const Simulation::Impl& s, std::span<const JointWrench> wrenches,
                       std::span<const std::uint8_t> held, HistoryRow& row);

}  // namespace quoin
