// Members that hold blocks beside their joints, in a model.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "geometry/vector.h"
#include "model/block_units.h"
#include "model/lanes.h"

namespace quoin::members {
struct Node;
class Members;
}  // namespace quoin::members

namespace quoin::blocks {

struct World;

// Members are made and changed by stages; steps move their nodes along.
struct HeldBy {
  std::shared_ptr<members::Members> members;  // null: none
  // Exchange of places and rotations of nodes with ranks that do not have their blocks; empty: one process.
  std::function<void(std::vector<members::Node>& nodes)> exchange;
  double work = 0.0;  // work of members that is booked, J
};

void follow_members(World& w);  // to where their nodes are, and what they do there, before a step
// Columns of bodies and gridpoints: velocities, or forces.
struct MotionColumns {
  LaneVector<geometry::Vector>&linear, &angular, &node;
};
void add_member_springs(const World& w, const Unit* alone, const MotionColumns& velocity, const MotionColumns& force);

}  // namespace quoin::blocks
