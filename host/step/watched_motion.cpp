#include "step/watched_motion.h"

#include <algorithm>
#include <iterator>

#include "scene/generate_blocks.h"
#include "step/large_motion_run.h"
#include "step/state.h"

namespace quoin {

namespace {

// Mean of a quantity of bodies, and of the same of gridpoints of deformable blocks, on the lattice.
Vec3 mean_on_lattice(const Simulation::Impl& s, const std::vector<int>& blocks,
                     BodyLanes::Quantity BodyLanes::*of_bodies, const LaneVector<double>& of_gridpoints) {
  const auto of_block = [&](int block) {
    if (const int body = s.model.place[at(block)].body; body >= 0) return s.lattice.of_body(body, of_bodies);
    const double whole = s.controls.loaded(block)->mass;
    Vec3 sum{};
    s.model.for_each_gridpoint(block, [&](std::size_t offset, double mass) {
      for (std::size_t c = 0; c < 3; ++c) sum[c] += mass / whole * of_gridpoints[offset + c * kLanes];
    });
    return sum;
  };
  Vec3 mean{};
  for (const int block : blocks) mean += of_block(block) / static_cast<double>(blocks.size());
  return mean;
}

}  // namespace

std::vector<int> blocks_named(const Simulation::Impl& s, const std::string& name, const std::string& where) {
  return s.large_motion ? blocks::find_blocks(s.large_motion->assembly, name, where) : blocks_on_lattice(s, name);
}

std::vector<int> blocks_on_lattice(const Simulation::Impl& s, const std::string& name) {
  std::vector<int> blocks;
  for (const int body : s.model.bodies_named(name)) blocks.push_back(s.model.bodies[at(body)].block);
  std::ranges::copy(s.model.deformable_blocks_named(name), std::back_inserter(blocks));
  return blocks;
}

const std::vector<int>& shown_blocks(const Simulation::Impl& s) {
  return s.controls.floors.empty() ? s.monitor.blocks : s.controls.floors.back();
}

Vec3 displacement_now(const Simulation::Impl& s, const std::vector<int>& blocks) {
  if (s.large_motion) return block_translation(s, blocks);
  return mean_on_lattice(s, blocks, &BodyLanes::displacement, s.lattice.displacement);
}

Vec3 displacement_at_forces(const Simulation::Impl& s, const std::vector<int>& blocks) {
  if (s.large_motion) return block_translation_at_forces(s, blocks);
  return displacement_now(s, blocks) -
         s.data.time_step * mean_on_lattice(s, blocks, &BodyLanes::velocity, s.lattice.velocity);
}

}  // namespace quoin
