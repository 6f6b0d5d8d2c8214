// Results of blocks in large motion: shapes, motion, stresses, contact points.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "step/points_at_rest.h"
#include "step/results.h"
#include "step/state.h"

namespace quoin {

void evaluate_large_motion_at_rest(const Simulation::Impl& s, std::uint64_t capability, const PointRange& range,
                                   const PointOutputs& outputs);
BlockMesh mesh_in_large_motion(const Simulation::Impl& s, int block);
BlockSize size_in_large_motion(const Simulation::Impl& s, int block);
// Displacements of the block's gridpoints since the start, m.
std::vector<Vec3> gridpoint_displacements(const Simulation::Impl& s, int block);
std::vector<Vec3> gridpoint_velocities(const Simulation::Impl& s, int block);
// Cauchy stress, Pa: xx yy zz xy yz zx.
std::vector<std::array<double, 6>> zone_stresses(const Simulation::Impl& s, int block);
void each_point_in_large_motion(const Simulation::Impl& s, const std::function<void(std::int32_t, int)>& visit);
std::vector<ContactPoint> points_in_large_motion(const Simulation::Impl& s, const PointRange& range,
                                                 const std::function<bool(int block)>& wanted);

}  // namespace quoin
