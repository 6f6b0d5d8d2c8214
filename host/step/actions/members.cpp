// Members: their pretension grows over the ramp of the first stage.
#include "members/members.h"

#include "base/rank_rows.h"
#include "step/actions/action.h"

namespace quoin {

using geometry::Vector;

void Simulation::Impl::build_members() {
  if (!scene.members) return;
  blocks::World::ExchangeNodes exchange;
  if (ranks) exchange = [this](std::vector<members::Node>& nodes) { exchange_nodes(nodes); };
  large_motion->hold_by_members(std::make_shared<members::Members>(*scene.members, large_motion->assembly),
                                std::move(exchange));
}

// Places and turns of nodes, of the ranks that advance their blocks.
void Simulation::Impl::exchange_nodes(std::vector<members::Node>& nodes) const {
  struct Place {
    Vector x;
    geometry::Matrix turn;
  };
  std::vector<Place> motion;
  for (const members::Node& node : nodes) motion.push_back({node.x, node.turn});
  all_gather(ranks, std::span(motion), [&](std::size_t n) {
    return share.rank_of_item[static_cast<std::size_t>(item_by_block[static_cast<std::size_t>(nodes[n].block)])];
  });
  for (std::size_t n = 0; n < nodes.size(); ++n) nodes[n].x = motion[n].x, nodes[n].turn = motion[n].turn;
}

void Simulation::Impl::jack_members(const Stage&, double s) {
  if (large_motion->members()) large_motion->members()->jack(stage == 0 ? s : 1.0);
}

}  // namespace quoin
