#include "members/members.h"

#include <span>

#include "base/rank_rows.h"
#include "step/actions/action.h"
#include "step/actions/actions.h"
#include "step/state.h"

namespace quoin {

using geometry::Vector;

namespace {

// Exchanges positions and rotations of nodes, from the ranks that advance their blocks.
void exchange_nodes(const Simulation::Impl& s, std::vector<members::Node>& nodes) {
  struct Place {
    Vector x;
    geometry::Matrix turn;
  };
  std::vector<Place> motion;
  for (const members::Node& node : nodes) motion.push_back({node.x, node.turn});
  all_gather(s.ranks, std::span(motion), [&](std::size_t n) {
    return s.division.share
        .rank_of_item[static_cast<std::size_t>(s.division.item_by_block[static_cast<std::size_t>(nodes[n].block)])];
  });
  for (std::size_t n = 0; n < nodes.size(); ++n) nodes[n].x = motion[n].x, nodes[n].turn = motion[n].turn;
}

}  // namespace

void build_members(Simulation::Impl& s) {
  if (!s.scene.members) return;
  blocks::World::ExchangeNodes exchange;
  if (s.ranks) exchange = [&s](std::vector<members::Node>& nodes) { exchange_nodes(s, nodes); };
  s.large_motion->hold_by_members(std::make_shared<members::Members>(*s.scene.members, s.large_motion->assembly),
                                  std::move(exchange));
}

// Jacks pull over the ramp of the first stage. Where that stage ends inside its ramp, they go on in the next.
extern const Action kMembers{.bind =
                                 [](Simulation::Impl& s, const Stage&, const Stage*) {
                                   if (const auto& held = s.large_motion->held_by.members)
                                     s.actions.jacked_from = held->jacked();
                                 },
                             .apply =
                                 [](Simulation::Impl& s, const Stage&, double ramp) {
                                   if (const auto& held = s.large_motion->held_by.members)
                                     held->jack(s.actions.jacked_from + ramp * (1.0 - s.actions.jacked_from));
                                 },
                             .saved = kSaved<&Actions::jacked_from>};

}  // namespace quoin
