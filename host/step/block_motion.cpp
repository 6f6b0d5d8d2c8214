#include "step/block_motion.h"

#include "model/world_results.h"
#include "scene/generate_blocks.h"

namespace quoin {

using geometry::Vector;

namespace {

// A quantity of a rigid brick, or the mean by mass of that of gridpoints.
Vector of_brick(const Simulation::Impl& s, int block, BodyLanes::Quantity BodyLanes::*of_body,
                const LaneVector<double>& of_gridpoints) {
  if (const int body = s.model.place[at(block)].body; body >= 0)
    return geometry::vector(s.lattice.of_body(body, of_body));
  Vector sum;
  double whole = 0.0;
  s.model.for_each_gridpoint(block, [&](std::size_t offset, double mass) {
    whole += mass;
    for (int c = 0; c < 3; ++c) sum[c] += mass * of_gridpoints[offset + at(c) * kLanes];
  });
  return sum / whole;
}

}  // namespace

std::vector<int> blocks_named(const Simulation::Impl& s, const std::string& name, const std::string& where) {
  return s.large_motion ? blocks::find_blocks(s.large_motion->assembly, name, where) : s.model.blocks_named(name);
}

const members::Members* members_of(const Simulation::Impl& s) {
  return s.large_motion ? s.large_motion->held_by.members.get() : nullptr;
}

const std::vector<int>& shown_blocks(const Simulation::Impl& s) {
  return s.controls.floors.empty() ? s.monitor.blocks : s.controls.floors.back();
}

Vector displacement_of(const Simulation::Impl& s, int block) {
  if (s.large_motion) return moved_by_now(*s.large_motion, block);
  return of_brick(s, block, &BodyLanes::displacement, s.lattice.displacement);
}

Vector velocity_of(const Simulation::Impl& s, int block) {
  if (s.large_motion) return velocity_of(*s.large_motion, block);
  return of_brick(s, block, &BodyLanes::velocity, s.lattice.velocity);
}

Vector spin_of(const Simulation::Impl& s, int block) {
  if (s.large_motion) return spin_of(*s.large_motion, block);
  const int body = s.model.place[at(block)].body;
  return body < 0 ? Vector{} : geometry::vector(s.lattice.of_body(body, &BodyLanes::spin));
}

Vec3 displacement_now(const Simulation::Impl& s, const std::vector<int>& blocks) {
  Vector mean;
  for (const int block : blocks) mean += displacement_of(s, block) / static_cast<double>(blocks.size());
  return geometry::array(mean);
}

Vec3 displacement_at_forces(const Simulation::Impl& s, const std::vector<int>& blocks) {
  Vector mean = geometry::vector(displacement_now(s, blocks));
  for (const int block : blocks) mean -= s.data.time_step * velocity_of(s, block) / static_cast<double>(blocks.size());
  return geometry::array(mean);
}

}  // namespace quoin
