// From scene and bricks to the arrays that the step goes over.
#pragma once

#include <memory>
#include <vector>

#include "step/state.h"

namespace quoin {

// The model at rest, with its time step and the damage of its scene. shapes: of blocks in large motion; null: none.
void set_up(Simulation::Impl& s, Assembly assembly, std::vector<std::shared_ptr<const Material>> materials,
            const blocks::Assembly* shapes);
void bind_step(Simulation::Impl& s);  // what a step reads, for the model of now
// The lattice of these bricks at rest, with its time step; none for an assembly of joint families alone.
void take_bricks(Simulation::Impl& s, Assembly assembly, const std::vector<std::shared_ptr<const Material>>& materials);
void follow_solver(Simulation::Impl& s);  // inertia, time step and damping of the lattice, by the settings of the stage
void bind_columns(Simulation::Impl& s);   // pointers of step data and law calls

}  // namespace quoin
