// Members of a model: positions of their nodes, and their forces on blocks. With ranks, each process computes all
// members. Owners of blocks send the positions of nodes to the others.
#include "model/world_members.h"

#include <array>

#include "base/rank_rows.h"
#include "members/members.h"
#include "model/block_layout.h"
#include "model/stepping.h"
#include "model/world.h"
#include "model/world_results.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

// Attachment of a node to its block, in a form that ranks exchange; gridpoints below 0 are unused.
struct Ride {
  Vector arm;
  std::array<int32_t, 4> gridpoint{-1, -1, -1, -1};
  std::array<double, 4> weight{};
};

}  // namespace

void World::hold_by_members(std::shared_ptr<members::Members> members, ExchangeNodes exchange) {
  held_by.members = std::move(members), held_by.exchange = std::move(exchange);
  std::vector<members::Node>& riders = held_by.members->nodes();
  std::vector<Ride> rides(riders.size());
  for (size_t n = 0; n < riders.size(); ++n) {
    const int block = riders[n].block;
    if (!part.owns(block)) continue;
    const Pose& start = poses.start[size_t(block)];
    if (blocks[size_t(block)].body >= 0) {
      rides[n].arm = transposed_times(start.r, riders[n].start - start.x);
      continue;
    }
    size_t k = 0;
    for (const auto& [gridpoint, weight] : shares_at(*this, block, riders[n].start))
      rides[n].gridpoint[k] = gridpoint, rides[n].weight[k++] = weight;
  }
  all_gather(part.ranks, std::span(rides), [&](size_t n) { return part.rank_of_block[size_t(riders[n].block)]; });
  for (size_t n = 0; n < riders.size(); ++n) {
    riders[n].arm = rides[n].arm;
    for (size_t k = 0; k < rides[n].gridpoint.size(); ++k) {
      if (rides[n].gridpoint[k] >= 0) riders[n].share.push_back({rides[n].gridpoint[k], rides[n].weight[k]});
    }
  }
  find_time_step(*this, true);
  // Forces of dashpots use velocities half a step ago. A step dt is stable where dt^2 times the eigenvalue of K + 2
  // C/dt is below 4, and so are smaller ones. The critical step for C/dt lies between the solution and dt.
  constexpr double kBelow = 0.99;  // of that step, so that a few tries suffice
  for (double whole = stepping.critical_dt; held_by.members->has_dashpots(); whole = kBelow * stepping.critical_dt) {
    held_by.members->set_step(whole);
    find_time_step(*this, true);
    if (stepping.critical_dt >= whole) break;
  }
}

void follow_members(World& w) {
  for (members::Node& node : w.held_by.members->nodes()) {
    if (!w.part.owns(node.block)) continue;
    const ModelBlock& b = w.blocks[size_t(node.block)];
    if (b.body >= 0) {
      const Body& body = w.bodies[size_t(b.body)];
      node.x = body.x + body.r * node.arm;
    } else {
      node.x = {};
      for (const auto& [i, weight] : node.share) node.x += weight * w.nodes.x[size_t(i)];
    }
    if (node.turns) node.turn = orientation_of(w, node.block);
  }
  if (w.held_by.exchange) w.held_by.exchange(w.held_by.members->nodes());
  members::Surroundings step;
  step.dt = w.stepping.dt;
  step.ground_way = w.stepping.dt * w.actions.ground_then, step.ground_velocity = braking_ground(w);
  step.gravity = w.actions.gravity, step.of_collapse = w.actions.of_collapse;
  step.mass_scaling = w.solver.mass_scaling;
  step.mass_damping = w.damping.alpha, step.local_damping = w.damping.gamma;
  w.held_by.members->pull(step);
}

// Adds springs of the same stiffness in all directions, an upper bound for members in any orientation.
void add_member_springs(const World& w, const Unit* alone, const MotionColumns& velocity, const MotionColumns& force) {
  const std::vector<members::Node>& nodes = w.held_by.members->nodes();
  const auto velocity_of = [&](const members::Node& node) {
    const int32_t body = w.blocks[size_t(node.block)].body;
    if (body >= 0) {
      const auto i = size_t(body);
      return velocity.linear[i] + cross(velocity.angular[i], node.x - w.bodies[i].x);
    }
    Vector v;
    for (const auto& [i, weight] : node.share) v += weight * velocity.node[size_t(i)];
    return v;
  };
  const auto has = [&](const members::Node& node) { return alone ? alone->has(node.block) : w.part.owns(node.block); };
  std::vector<Vector> moves(nodes.size());  // 0 for blocks outside the unit, or of other ranks
  for (size_t n = 0; n < nodes.size(); ++n) {
    if (has(nodes[n])) moves[n] = velocity_of(nodes[n]);
  }
  if (!alone)
    all_gather(w.part.ranks, std::span(moves), [&](size_t n) { return w.part.rank_of_block[size_t(nodes[n].block)]; });
  const auto push = [&](const members::Node& node, const Vector& f) {
    if (!has(node)) return;
    const int32_t body = w.blocks[size_t(node.block)].body;
    if (body >= 0) {
      const auto i = size_t(body);
      force.linear[i] += f, force.angular[i] += cross(node.x - w.bodies[i].x, f);
      return;
    }
    for (const auto& [i, weight] : node.share) force.node[size_t(i)] += weight * f;
  };
  w.held_by.members->each_spring([&](int a, int b, double stiffness) {
    const members::Node& from = nodes[size_t(a)];
    if (b == members::kGround) return push(from, stiffness * moves[size_t(a)]);
    const members::Node& to = nodes[size_t(b)];
    const double factor = alone && !(has(from) && has(to)) ? 2.0 : 1.0;
    const Vector f = factor * stiffness * (moves[size_t(b)] - moves[size_t(a)]);
    push(from, -f), push(to, f);
  });
}

}  // namespace quoin::blocks
