// Choice of the kernels that move the blocks of a scene, and the reason for it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scene/assembly.h"
#include "scene/blocks.h"
#include "scene/scene.h"

namespace quoin {

struct Motion {
  Scene scene;                             // stages and settings for the kernels
  Assembly bricks;                         // bricks on the lattice; empty for blocks of any shape
  std::optional<blocks::Assembly> shapes;  // blocks of any shape
  std::string why_not_lattice;             // reason why the scene is not on the lattice, for blocks of any shape
};

// Sets the rule of contact points between rigid blocks, by joint family: the scene's rule if it gives one. Else
// corners; for laws that carry tension, quadrature points at the start. Throws Error(bad_input) for laws that are not
// found or refuse their properties.
void choose_rigid_points(const Scene& scene, std::vector<JointFamily>* families);

// Throws Error(bad_input) where the law of a joint family cannot change, as it bonds strips. where: place in the scene.
void refuse_swap_of_strips(const Scene& scene, const std::string& family, const std::string& where);

// Fault of a stage that replaces the law of a joint family; empty: none.
std::string fault_of_law_swap(const JointFamily& family, const Stage& stage);

// Motion of all blocks of the scene, of the kind that it requests or fits. Throws Error(bad_input), with the reason,
// where solver.kernels or a setting requests what the blocks cannot do.
Motion choose_motion(Scene scene);

// The same with these bricks in place of the scene's wall or building.
Motion choose_motion(Scene scene, Assembly bricks);

}  // namespace quoin
