// How the blocks of a scene move: which kernels, and why.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scene/assembly.h"
#include "scene/blocks.h"
#include "scene/scene.h"

namespace quoin {

struct Motion {
  Scene scene;                             // stages and settings as the kernels have them
  Assembly bricks;                         // bricks on the lattice; none where blocks are of any shape
  std::optional<blocks::Assembly> shapes;  // blocks of any shape
  std::string why_not_lattice;             // reason why a scene with blocks of any shape is not on the lattice
};

// Where rigid blocks have contact points, by joint family: what the scene says, else corners, but for joints of the
// start that carry tension. Throws Error(bad_input) for laws that are not found or refuse their properties.
void choose_rigid_points(const Scene& scene, std::vector<JointFamily>* families);

// Motion of all blocks that the scene holds, of the kind that it requests or fits. Throws Error(bad_input), with the
// reason, where solver.kernels or a setting requests what the blocks cannot do.
Motion choose_motion(Scene scene);

// Bricks that were made otherwise, in place of the scene's wall or building.
Motion choose_motion(Scene scene, Assembly bricks);

}  // namespace quoin
