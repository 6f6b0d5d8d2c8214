// Equal forces on floors, of blocks on the lattice and in large motion.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "scene/generate_blocks.h"
#include "step/actions/action.h"

namespace quoin {

using geometry::Vector;

void Simulation::Impl::bind_whiffletree() {
  whiffletree.clear();
  if (stage < 0 || !scene.stages[static_cast<std::size_t>(stage)].whiffletree) return;
  const Stage& settings = scene.stages[static_cast<std::size_t>(stage)];
  for (const auto& floor : settings.whiffletree->floors) {
    Floor& indices = whiffletree.emplace_back();
    for (const std::string& name : floor) {
      if (large_motion) {
        const std::vector<int> named = blocks_named(name, settings.source.text);
        indices.large_motion.insert(indices.large_motion.end(), named.begin(), named.end());
        continue;
      }
      const std::vector<int> named = model.bodies_named(name);
      indices.bodies.insert(indices.bodies.end(), named.begin(), named.end());
      bool found = !named.empty();
      for (std::size_t i = 0; i < loaded_blocks.size(); ++i) {
        if (model.assembly.bricks[static_cast<std::size_t>(loaded_blocks[i].block)].body != name) continue;
        indices.loaded.push_back(static_cast<int>(i));
        found = true;
      }
      if (!found)
        throw Error(Exit::bad_input, fmt::format("{}: stage '{}' pushes the body '{}', but the assembly has no block "
                                                 "of that name",
                                                 settings.source.text, settings.name, name));
    }
  }
}

double Simulation::Impl::floor_displacement_now(std::size_t floor) const {
  const Floor& f = whiffletree[floor];
  if (large_motion) return block_translation(f.large_motion)[0];
  double sum = static_cast<double>(f.bodies.size()) * mean_of(f.bodies, &BodyLanes::displacement)[0];
  for (const int i : f.loaded) sum += mean_along_x(loaded_blocks[static_cast<std::size_t>(i)], displacement);
  return sum / f.count();
}

double Simulation::Impl::floor_displacement(std::size_t floor) const {
  const Floor& f = whiffletree[floor];
  if (large_motion) {
    double rate = 0.0;
    for (const int block : f.large_motion) rate += large_motion->velocity(block).x / f.count();
    return floor_displacement_now(floor) - data.time_step * rate;
  }
  double rate = static_cast<double>(f.bodies.size()) * mean_of(f.bodies, &BodyLanes::velocity)[0];
  for (const int i : f.loaded) rate += mean_along_x(loaded_blocks[static_cast<std::size_t>(i)], velocity);
  return floor_displacement_now(floor) - data.time_step * rate / f.count();
}

void Simulation::Impl::pull_whiffletree() {
  const Stage& settings = scene.stages[static_cast<std::size_t>(stage)];
  const Whiffletree& tree = *settings.whiffletree;
  const double moved =
      cycles ? cycles->position(stage_time()) : tree.velocity * smooth_way(stage_time(), settings.ramp_time);
  // Displacements of now, as the joints have them: a spring that sees them one step late feeds energy in at any step.
  double mean = 0.0;
  for (std::size_t f = 0; f < whiffletree.size(); ++f)
    mean += floor_displacement_now(f) / static_cast<double>(whiffletree.size());
  const double pull = tree.stiffness * (monitor_start[0] + moved - mean);
  for (const Floor& floor : whiffletree) {
    for (const int block : floor.large_motion) pull_block(block, pull / floor.count());
    for (const int body : floor.bodies) {
      const auto [lanes, lane] = body_place[static_cast<std::size_t>(body)];
      body_lanes[static_cast<std::size_t>(lanes)].applied_force[0][lane] = pull / floor.count();
    }
    for (const int i : floor.loaded) {
      load_ramps[static_cast<std::size_t>(i)].now[0] = pull / floor.count();
      apply_load(static_cast<std::size_t>(i));
    }
  }
}

}  // namespace quoin
