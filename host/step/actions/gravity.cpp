// Weight. It follows the ramp of a stage.
#include "step/actions/action.h"
#include "step/state.h"

namespace quoin {

extern const Action kGravity{.apply = [](Simulation::Impl& s, const Stage&, double) {
  s.large_motion->set_gravity(geometry::vector(s.data.gravity));
}};

}  // namespace quoin
