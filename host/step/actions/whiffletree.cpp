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

void bind_whiffletree(Simulation::Impl& s) {
  s.controls.whiffletree.clear();
  if (s.progress.stage < 0 || !current_stage(s).whiffletree) return;
  const Stage& settings = current_stage(s);
  for (const auto& floor : settings.whiffletree->floors) {
    WhiffletreeFloor& indices = s.controls.whiffletree.emplace_back();
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
        throw Error(Exit::bad_input, fmt::format("{}: stage '{}' pushes the body '{}', but the assembly has no block "
                                                 "of that name",
                                                 settings.source.text, settings.name, name));
    }
  }
}

double floor_displacement_now(const Simulation::Impl& s, std::size_t floor) {
  const WhiffletreeFloor& f = s.controls.whiffletree[floor];
  if (s.large_motion) return block_translation(s, f.large_motion)[0];
  double sum = static_cast<double>(f.bodies.size()) * s.lattice.mean_of(f.bodies, &BodyLanes::displacement)[0];
  for (const int i : f.loaded)
    sum += mean_along_x(s, s.controls.loaded_blocks[static_cast<std::size_t>(i)], s.lattice.displacement);
  return sum / f.count();
}

double floor_displacement(const Simulation::Impl& s, std::size_t floor) {
  const WhiffletreeFloor& f = s.controls.whiffletree[floor];
  if (s.large_motion) {
    double rate = 0.0;
    for (const int block : f.large_motion) rate += velocity_of(*s.large_motion, block).x / f.count();
    return floor_displacement_now(s, floor) - s.data.time_step * rate;
  }
  double rate = static_cast<double>(f.bodies.size()) * s.lattice.mean_of(f.bodies, &BodyLanes::velocity)[0];
  for (const int i : f.loaded)
    rate += mean_along_x(s, s.controls.loaded_blocks[static_cast<std::size_t>(i)], s.lattice.velocity);
  return floor_displacement_now(s, floor) - s.data.time_step * rate / f.count();
}

void pull_whiffletree(Simulation::Impl& s) {
  const Stage& settings = current_stage(s);
  const Whiffletree& tree = *settings.whiffletree;
  const double moved = s.controls.cycles ? s.controls.cycles->position(stage_time(s))
                                         : tree.velocity * smooth_way(stage_time(s), settings.ramp_time);
  // Current displacements, as for joints: a spring with those of a step before would add energy in every step.
  double mean = 0.0;
  for (std::size_t f = 0; f < s.controls.whiffletree.size(); ++f)
    mean += floor_displacement_now(s, f) / static_cast<double>(s.controls.whiffletree.size());
  const double pull = tree.stiffness * (s.monitor.start[0] + moved - mean);
  for (const WhiffletreeFloor& floor : s.controls.whiffletree) {
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
  if (!stage.whiffletree) return;
  for (const auto& floor : stage.whiffletree->floors) std::for_each(floor.begin(), floor.end(), visit);
}};

}  // namespace quoin
