// Members in a model: where their nodes ride, and what they do to blocks.
#include "members/members.h"
#include "model/world.h"

namespace quoin::blocks {

void World::hold_by_members(std::shared_ptr<members::Members> members) {
  members_ = std::move(members);
  for (members::Node& node : members_->nodes()) {
    const Pose& start = start_[size_t(node.block)];
    if (blocks_[size_t(node.block)].body >= 0)
      node.arm = transposed_times(start.r, node.start - start.x);
    else
      node.share = shares_at(node.block, node.start);
  }
  find_time_step(true);
  // Dashpots act with velocities of half a step ago: stable where K + 2 C/dt has dt^2 times its eigenvalue below 4. A
  // smaller dt is stable too, so that one that fits is enough.
  constexpr double kTry = 0.95;
  for (double reckoned = dt_; members_->has_dashpots();) {
    members_->reckon_with(reckoned);
    find_time_step(true);
    if (dt_ >= reckoned) break;
    reckoned *= kTry;
  }
}

void World::follow_members() {
  for (members::Node& node : members_->nodes()) {
    const ModelBlock& b = blocks_[size_t(node.block)];
    if (b.body >= 0) {
      const Body& body = bodies_[size_t(b.body)];
      node.x = body.x + body.r * node.arm;
    } else {
      node.x = {};
      for (const auto& [i, weight] : node.share) node.x += weight * node_x_[size_t(i)];
    }
    if (node.turns) node.turn = orientation(node.block);
  }
  const bool eq1 = solver_.damping == DampingKind::local || solver_.damping == DampingKind::block;
  members_->pull({dt_, dt_ * ground_then_, braking_ground(), gravity_factor_.at(time_) * gravity_, solver_.mass_scaling,
                  solver_.damping == DampingKind::viscous ? solver_.mass_damping : 0.0, eq1 ? gamma() : 0.0});
}

// As springs of the same stiffness in all directions, which bound them however they turn.
void World::add_member_springs(const Unit* alone, const Columns& velocity, const Columns& force) const {
  const std::vector<members::Node>& nodes = members_->nodes();
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
  const auto push = [&](const members::Node& node, const Vector& f) {
    const int32_t body = blocks_[size_t(node.block)].body;
    if (body >= 0) {
      const auto i = size_t(body);
      force.linear[i] += f, force.angular[i] += cross(node.x - bodies_[i].x, f);
    }
    for (const auto& [i, weight] : node.share) force.node[size_t(i)] += weight * f;
  };
  members_->each_spring([&](int a, int b, double stiffness) {
    const members::Node& from = nodes[size_t(a)];
    if (b == members::kGround) {
      if (!alone || alone->has(from.block)) push(from, stiffness * velocity_of(from));
      return;
    }
    const members::Node& to = nodes[size_t(b)];
    const bool has_from = !alone || alone->has(from.block), has_to = !alone || alone->has(to.block);
    if (!has_from && !has_to) return;
    const double factor = has_from && has_to ? 1.0 : 2.0;
    const Vector f = factor * stiffness * (velocity_of(to) - velocity_of(from));
    push(from, -f), push(to, f);
  });
}

}  // namespace quoin::blocks
