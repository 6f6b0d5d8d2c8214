// Weight. It follows the ramp of a stage, and with it the body force that a collapse stage has left.
#include "step/actions/action.h"
#include "step/state.h"

namespace quoin {

extern const Action kGravity{.apply =
                                 [](Simulation::Impl& s, const Stage&, double ramp) {
                                   s.large_motion->set_gravity(geometry::vector(s.data.gravity));
                                   s.large_motion->actions.of_collapse = (1.0 - ramp) * s.actions.collapse_left;
                                 },
                             .saved = kSaved<&Actions::collapse_left>};

}  // namespace quoin
