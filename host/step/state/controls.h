// Controls of bodies and blocks in a stage: velocities and forces that change over its ramp. A stage sets them when it
// begins, a controller between steps. Ramps, gravity and the jack are saved; the rest follows from them and from the
// stage.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "model/model.h"
#include "scene/cyclic_motion.h"

namespace quoin {

// Control of a body through a stage: from the velocity and force before the stage to those of the stage.
struct BodyRamp {
  Vec3 velocity_from{}, velocity_to{};  // m/s
  Vec3 force_from{}, force_to{};        // N
  Vec3 in_cycles{};                     // 1: this component follows the cycles of the stage; else 0
  std::uint64_t of_ground = 0;          // as in Drive (state/actions.h)
  std::int64_t motion = 0;              // as in Drive
};

// A named deformable block on the lattice: controls can load it.
struct LoadedBlock {
  int block = -1;
  double mass = 0.0;  // mass without scaling, kg
};

// Force on a loaded block through a stage: before the stage, at the end of the ramp, in this step.
struct LoadRamp {
  Vec3 from{}, to{}, now{};  // N
};

// Head of the jack that pulls the whiffletree, along x.
struct JackHead {
  double from = 0.0;           // position when the stage began, m
  double velocity_from = 0.0;  // velocity before the stage, m/s
  double force = 0.0;          // on all floors together, in the last step, N
};

struct Controls {
  std::vector<BodyRamp> ramps;        // by body
  std::vector<LoadRamp> load_ramps;   // by loaded block
  Vec3 gravity_from{}, gravity_to{};  // m/s2

  std::vector<int> ramped_bodies;            // bodies whose control changes over the ramp
  std::vector<LoadedBlock> loaded_blocks;    // deformable blocks that have a name
  LaneVector<double> load;                   // acceleration of groups with loaded blocks: [component][lane], m/s2
  std::vector<const double*> load_of_group;  // by block group, into load; null: none
  // Blocks of the floors that the whiffletree of the stage pulls, else of the roof alone; the last is the roof.
  std::vector<std::vector<int>> floors;
  JackHead jack;                       // where the stage has a whiffletree
  std::optional<CyclicMotion> cycles;  // cycles of the stage
  bool settled = true;                 // the ramp of the stage is over, and no body moves in cycles
  bool rest_known = true;              // BodyLanes::at_rest is up to date

  void find_loaded_blocks(const Model& model);
  std::size_t loaded(int block) const;                      // index into loaded_blocks and load_ramps
  void apply_load(const Model& model, std::size_t loaded);  // writes the current value of load_ramps into `load`
  int ground_body() const;                                  // a body that moves as the ground does; -1: none
};

}  // namespace quoin
