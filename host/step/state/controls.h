// Controls of a stage beside its actions: gravity over its ramp, the jack, and loads on bricks of the lattice. Gravity
// and the jack are saved; the rest follows from them, from the actions and from the stage.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "model/model.h"
#include "scene/cyclic_motion.h"

namespace quoin {

// A named deformable block on the lattice: controls can load it.
struct LoadedBlock {
  int block = -1;
  double mass = 0.0;  // mass without scaling, kg
};

// Head of the jack that pulls the whiffletree, along x.
struct JackHead {
  double from = 0.0;           // position when the stage began, m
  double velocity_from = 0.0;  // velocity before the stage, m/s
  double force = 0.0;          // on each floor, in the last step, N
  double travel = 0.0;         // in the stage, m
  double peak = 0.0;           // largest magnitude of the force in the stage, N
};

struct Controls {
  Vec3 gravity_from{}, gravity_to{};  // m/s2

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
  const LoadedBlock* loaded(int block) const;                         // null: it has no name
  void load_brick(const Model& model, int block, const Vec3& force);  // writes a force, N, into `load`
};

}  // namespace quoin
