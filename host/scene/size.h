// How large a scene is, from its numbers alone: before anything of that size is made.
#pragma once

#include "scene/scene.h"

namespace quoin {

inline constexpr double kProgramBytes = 19e6;  // memory before there is any model; with MPI some more

// Blocks of mesh files are not counted: only reading them gives the number. Walls and buildings are counted as they
// begin; in large motion, which they may come to, they take about four times as much. Blocks of any shape are counted
// in large motion, though some of them can begin as a lattice.
struct SceneSize {
  double blocks = 0.0, zones = 0.0;
  double points = 0.0;        // contact points, at most
  double bytes = 0.0;         // largest memory of a run, within about 20 % for walls and buildings
  double bytes_shared = 0.0;  // part of these that several ranks divide among them; the rest each has
  double bytes_of_rank(int ranks) const;
};

SceneSize size_of(const Scene& scene);

}  // namespace quoin
