// Vibration about states other than the undamaged one: under weight, or at the end of a run.
#pragma once

#include "analysis/undamaged.h"
#include "step/tangent.h"

namespace quoin {

// Vibration about the current state. tangent: from tangent_of.
Vibrating vibrating_now(const Simulation& simulation, Tangent tangent);

// state: "weight", or the folder of a run of this scene with output.end_state = true. "weight" takes the loads and
// supports of the stage of that name (empty: the first with a load; rest_scene.h). Throws as a run of kind rest, or as
// take_start.
Vibrating vibrating_about(const Scene& scene, const std::string& state, const std::string& stage);

}  // namespace quoin
