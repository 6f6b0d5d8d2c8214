// Members: their pretension grows over the ramp of the first stage.
#include "members/members.h"

#include <fmt/format.h>

#include "base/error.h"
#include "step/actions/action.h"

namespace quoin {

void Simulation::Impl::build_members() {
  if (!scene.members) return;
  if (ranks)
    throw Error(Exit::bad_input,
                fmt::format("{}: members ([[tie]]) pull at blocks of several processes, which exchange no forces of "
                            "members; run the scene in one process, with as many threads as there are cores",
                            scene.file));
  large_motion->hold_by_members(std::make_shared<members::Members>(*scene.members, large_motion->assembly()));
}

void Simulation::Impl::jack_members(const Stage&, double s) {
  if (large_motion->members()) large_motion->members()->jack(stage == 0 ? s : 1.0);
}

}  // namespace quoin
