// Set-up: from scene and bricks to the arrays of a step.
#pragma once

#include <memory>
#include <vector>

#include "step/state.h"

namespace quoin {

// Builds the model at rest, with its time step and the damage of its scene. shapes: blocks in large motion; null: none.
void set_up(Simulation::Impl& s, Assembly assembly, std::vector<std::shared_ptr<const Material>> materials,
            const blocks::Assembly* shapes);
void bind_step(Simulation::Impl& s);  // binds the data of a step to the current model
// Builds the lattice of these bricks at rest, with its time step. Without bricks it has joint families alone.
void take_bricks(Simulation::Impl& s, Assembly assembly, const std::vector<std::shared_ptr<const Material>>& materials);
// Sets inertia, time step and damping of the lattice by the settings of the stage.
void follow_solver(Simulation::Impl& s);
void bind_columns(Simulation::Impl& s);  // pointers of step data and law calls

}  // namespace quoin
