#include "step/watched_motion.h"

#include "step/large_motion_run.h"
#include "step/state.h"

namespace quoin {

namespace {

// Mean of a quantity of bodies, and of the same of gridpoints of deformable blocks, on the lattice.
Vec3 mean_on_lattice(const Simulation::Impl& s, const WatchedBlocks& blocks, BodyLanes::Quantity BodyLanes::*of_bodies,
                     const LaneVector<double>& of_gridpoints) {
  Vec3 mean{};
  for (const int body : blocks.bodies) mean += s.lattice.of_body(body, of_bodies) / blocks.count();
  for (const int i : blocks.loaded) {
    const LoadedBlock& block = s.controls.loaded_blocks[static_cast<std::size_t>(i)];
    Vec3 sum{};
    s.model.for_each_gridpoint(block.block, [&](std::size_t offset, double mass) {
      for (std::size_t c = 0; c < 3; ++c) sum[c] += mass / block.mass * of_gridpoints[offset + c * kLanes];
    });
    mean += sum / blocks.count();
  }
  return mean;
}

}  // namespace

bool add_named(const Simulation::Impl& s, const std::string& name, WatchedBlocks& to) {
  const double before = to.count();
  const std::vector<int> bodies = s.model.bodies_named(name);
  to.bodies.insert(to.bodies.end(), bodies.begin(), bodies.end());
  for (std::size_t i = 0; i < s.controls.loaded_blocks.size(); ++i) {
    if (s.model.assembly.bricks[static_cast<std::size_t>(s.controls.loaded_blocks[i].block)].body == name)
      to.loaded.push_back(static_cast<int>(i));
  }
  return to.count() > before;
}

const WatchedBlocks& shown_blocks(const Simulation::Impl& s) {
  return s.controls.floors.empty() ? s.monitor.blocks : s.controls.floors.back();
}

Vec3 displacement_now(const Simulation::Impl& s, const WatchedBlocks& blocks) {
  if (s.large_motion) return block_translation(s, blocks.large_motion);
  return mean_on_lattice(s, blocks, &BodyLanes::displacement, s.lattice.displacement);
}

Vec3 displacement_at_forces(const Simulation::Impl& s, const WatchedBlocks& blocks) {
  if (s.large_motion) return block_translation_at_forces(s, blocks.large_motion);
  return displacement_now(s, blocks) -
         s.data.time_step * mean_on_lattice(s, blocks, &BodyLanes::velocity, s.lattice.velocity);
}

}  // namespace quoin
