#include "step/actions/whiffletree.h"

#include <fmt/core.h>

#include <algorithm>

#include "base/error.h"
#include "base/smooth_step.h"
#include "model/world_results.h"
#include "step/actions/action.h"
#include "step/actions/drive.h"
#include "step/large_motion_run.h"
#include "step/lattice_motion.h"
#include "step/stages.h"
#include "step/state.h"

namespace quoin {

namespace {

// Mean of a quantity of bodies, and the same of gridpoints of deformable blocks, over a floor on the lattice.
Vec3 mean_of_floor(const Simulation::Impl& s, const Floor& floor, BodyLanes::Quantity BodyLanes::*of_bodies,
                   const LaneVector<double>& of_gridpoints) {
  Vec3 sum = s.lattice.mean_of(floor.bodies, of_bodies);
  for (double& component : sum) component *= static_cast<double>(floor.bodies.size());
  for (const int i : floor.loaded) {
    const Vec3 mean = mean_of_loaded(s, i, of_gridpoints);
    for (std::size_t c = 0; c < 3; ++c) sum[c] += mean[c];
  }
  for (double& component : sum) component /= floor.count();
  return sum;
}

}  // namespace

void bind_floors(Simulation::Impl& s) {
  s.controls.floors.clear();
  if (s.progress.stage < 0) return;
  const Stage& settings = current_stage(s);
  std::vector<std::vector<std::string>> floors;
  if (settings.whiffletree)
    floors = settings.whiffletree->floors;
  else if (!settings.roof.empty())
    floors = {settings.roof};
  for (const auto& floor : floors) {
    Floor& indices = s.controls.floors.emplace_back();
    for (const std::string& name : floor) {
      if (s.large_motion) {
        const std::vector<int> named = blocks_named(s, name, settings.source.text);
        indices.large_motion.insert(indices.large_motion.end(), named.begin(), named.end());
        continue;
      }
      const std::vector<int> named = s.model.bodies_named(name);
      indices.bodies.insert(indices.bodies.end(), named.begin(), named.end());
      bool found = !named.empty();
      for (std::size_t i = 0; i < s.controls.loaded_blocks.size(); ++i) {
        if (s.model.assembly.bricks[static_cast<std::size_t>(s.controls.loaded_blocks[i].block)].body != name) continue;
        indices.loaded.push_back(static_cast<int>(i));
        found = true;
      }
      if (!found)
        throw Error(Exit::bad_input, fmt::format("{}: stage '{}' has the floor '{}', but the assembly has no block of "
                                                 "that name",
                                                 settings.source.text, settings.name, name));
    }
  }
}

Vec3 floor_displacement_now(const Simulation::Impl& s, const Floor& floor) {
  if (s.large_motion) return block_translation(s, floor.large_motion);
  return mean_of_floor(s, floor, &BodyLanes::displacement, s.lattice.displacement);
}

Vec3 floor_displacement(const Simulation::Impl& s, const Floor& floor) {
  if (s.large_motion) return block_translation_at_forces(s, floor.large_motion);
  Vec3 moved = floor_displacement_now(s, floor);
  const Vec3 rate = mean_of_floor(s, floor, &BodyLanes::velocity, s.lattice.velocity);
  for (std::size_t c = 0; c < 3; ++c) moved[c] -= s.data.time_step * rate[c];
  return moved;
}

void pull_whiffletree(Simulation::Impl& s) {
  const Stage& settings = current_stage(s);
  const Whiffletree& tree = *settings.whiffletree;
  const double moved = s.controls.cycles ? s.controls.cycles->position(stage_time(s))
                                         : tree.velocity * smooth_way(stage_time(s), settings.ramp_time);
  // Current displacements, as for joints: a spring with those of a step before would add energy in every step.
  double mean = 0.0;
  for (const Floor& floor : s.controls.floors)
    mean += floor_displacement_now(s, floor)[0] / static_cast<double>(s.controls.floors.size());
  const double pull = tree.stiffness * (s.monitor.start[0] + moved - mean);
  for (const Floor& floor : s.controls.floors) {
    for (const int block : floor.large_motion) pull_block(s, block, pull / floor.count());
    for (const int body : floor.bodies) {
      const auto [lanes, lane] = s.lattice.place[static_cast<std::size_t>(body)];
      s.lattice.bodies[static_cast<std::size_t>(lanes)].applied_force[0][lane] = pull / floor.count();
    }
    for (const int i : floor.loaded) {
      s.controls.load_ramps[static_cast<std::size_t>(i)].now[0] = pull / floor.count();
      s.controls.apply_load(s.model, static_cast<std::size_t>(i));
    }
  }
}

// Forces are applied by pull_whiffletree, for both kinds of motion.
extern const Action kWhiffletree{.names = [](const Stage& stage, const VisitName& visit) {
  std::for_each(stage.roof.begin(), stage.roof.end(), visit);
  if (!stage.whiffletree) return;
  for (const auto& floor : stage.whiffletree->floors) std::for_each(floor.begin(), floor.end(), visit);
}};

}  // namespace quoin
