// Members in a model: where their nodes ride, and what they do to blocks. Where several processes share the model, each
// computes all members. Owners of blocks give the others the places of nodes.
#include <array>

#include "base/rank_rows.h"
#include "members/members.h"
#include "model/world.h"

namespace quoin::blocks {

namespace {

// How a node rides, in a form that ranks exchange: gridpoints below 0 are none.
struct Ride {
  Vector arm;
  std::array<int32_t, 4> gridpoint{-1, -1, -1, -1};
  std::array<double, 4> weight{};
};

}  // namespace

void World::hold_by_members(std::shared_ptr<members::Members> members, ExchangeNodes exchange) {
  held_by_.members = std::move(members), held_by_.exchange = std::move(exchange);
  std::vector<members::Node>& nodes = held_by_.members->nodes();
  std::vector<Ride> rides(nodes.size());
  for (size_t n = 0; n < nodes.size(); ++n) {
    const int block = nodes[n].block;
    if (!owns(block)) continue;
    const Pose& start = poses_.start[size_t(block)];
    if (blocks_[size_t(block)].body >= 0) {
      rides[n].arm = transposed_times(start.r, nodes[n].start - start.x);
      continue;
    }
    size_t k = 0;
    for (const auto& [gridpoint, weight] : shares_at(block, nodes[n].start))
      rides[n].gridpoint[k] = gridpoint, rides[n].weight[k++] = weight;
  }
  all_gather(part_.ranks, std::span(rides), [&](size_t n) { return part_.rank_of_block[size_t(nodes[n].block)]; });
  for (size_t n = 0; n < nodes.size(); ++n) {
    nodes[n].arm = rides[n].arm;
    for (size_t k = 0; k < rides[n].gridpoint.size(); ++k) {
      if (rides[n].gridpoint[k] >= 0) nodes[n].share.push_back({rides[n].gridpoint[k], rides[n].weight[k]});
    }
  }
  find_time_step(true);
  // Dashpots act with velocities of half a step ago: stable where K + 2 C/dt has dt^2 times its eigenvalue below 4. A
  // smaller dt is stable too, so that one that fits is enough.
  constexpr double kTry = 0.95;
  for (double reckoned = stepping_.dt; held_by_.members->has_dashpots();) {
    held_by_.members->reckon_with(reckoned);
    find_time_step(true);
    if (stepping_.dt >= reckoned) break;
    reckoned *= kTry;
  }
}

void World::follow_members() {
  for (members::Node& node : held_by_.members->nodes()) {
    if (!owns(node.block)) continue;
    const ModelBlock& b = blocks_[size_t(node.block)];
    if (b.body >= 0) {
      const Body& body = bodies_[size_t(b.body)];
      node.x = body.x + body.r * node.arm;
    } else {
      node.x = {};
      for (const auto& [i, weight] : node.share) node.x += weight * nodes_.x[size_t(i)];
    }
    if (node.turns) node.turn = orientation(node.block);
  }
  if (held_by_.exchange) held_by_.exchange(held_by_.members->nodes());
  const bool eq1 = solver_.damping == DampingKind::local || solver_.damping == DampingKind::block;
  held_by_.members->pull({stepping_.dt, stepping_.dt * actions_.ground_then, braking_ground(),
                          actions_.gravity_factor.at(stepping_.time) * actions_.gravity, solver_.mass_scaling,
                          solver_.damping == DampingKind::viscous ? solver_.mass_damping : 0.0, eq1 ? gamma() : 0.0});
}

// As springs of the same stiffness in all directions, which bound them however they turn.
void World::add_member_springs(const Unit* alone, const Columns& velocity, const Columns& force) const {
  const std::vector<members::Node>& nodes = held_by_.members->nodes();
  const auto velocity_of = [&](const members::Node& node) {
    const int32_t body = blocks_[size_t(node.block)].body;
    if (body >= 0) {
      const auto i = size_t(body);
      return velocity.linear[i] + cross(velocity.angular[i], node.x - bodies_[i].x);
    }
    Vector v;
    for (const auto& [i, weight] : node.share) v += weight * velocity.node[size_t(i)];
    return v;
  };
  const auto has = [&](const members::Node& node) { return alone ? alone->has(node.block) : owns(node.block); };
  std::vector<Vector> moves(nodes.size());  // of blocks outside of a unit: none
  for (size_t n = 0; n < nodes.size(); ++n) {
    if (has(nodes[n])) moves[n] = velocity_of(nodes[n]);
  }
  if (!alone)
    all_gather(part_.ranks, std::span(moves), [&](size_t n) { return part_.rank_of_block[size_t(nodes[n].block)]; });
  const auto push = [&](const members::Node& node, const Vector& f) {
    if (!has(node)) return;
    const int32_t body = blocks_[size_t(node.block)].body;
    if (body >= 0) {
      const auto i = size_t(body);
      force.linear[i] += f, force.angular[i] += cross(node.x - bodies_[i].x, f);
      return;
    }
    for (const auto& [i, weight] : node.share) force.node[size_t(i)] += weight * f;
  };
  held_by_.members->each_spring([&](int a, int b, double stiffness) {
    const members::Node& from = nodes[size_t(a)];
    if (b == members::kGround) return push(from, stiffness * moves[size_t(a)]);
    const members::Node& to = nodes[size_t(b)];
    const double factor = alone && !(has(from) && has(to)) ? 2.0 : 1.0;
    const Vector f = factor * stiffness * (moves[size_t(b)] - moves[size_t(a)]);
    push(from, -f), push(to, f);
  });
}

}  // namespace quoin::blocks
