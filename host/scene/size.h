// Size of a scene and its memory, estimated from its numbers before the model is made.
#pragma once

#include "scene/scene.h"

namespace quoin {

inline constexpr double kProgramBytes = 19e6;  // memory before there is any model; with MPI some more

// Blocks of mesh files are not counted, as only reading the files gives their number. Walls and buildings are counted
// in small displacements. In large motion they take about four times as much. Blocks of any shape are counted in large
// motion, even where they begin on the lattice.
struct SceneSize {
  double blocks = 0.0, zones = 0.0;
  double points = 0.0;        // contact points, at most
  double bytes = 0.0;         // largest memory of a run, within about 20 % for walls and buildings
  double bytes_shared = 0.0;  // part of bytes that ranks divide among them; each rank has the rest
  double bytes_of_rank(int ranks) const;
};

SceneSize size_of(const Scene& scene);

}  // namespace quoin
