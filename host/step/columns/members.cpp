// Forces, moments and states of members (host/members).
#include "members/members.h"

#include "step/block_motion.h"
#include "step/columns/columns.h"
#include "step/state.h"

namespace quoin {

namespace {

std::vector<std::string> names(const Scene& scene) {
  return scene.members ? members::column_names(*scene.members) : std::vector<std::string>{};
}

std::vector<double> values(const Simulation::Impl& run) {
  const members::Members* const members = members_of(run);
  return members ? members->columns() : std::vector<double>{};
}

}  // namespace

extern const ColumnGroup kMemberColumns{names, values};

}  // namespace quoin
