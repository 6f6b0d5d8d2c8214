// Members of a model.
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

// Members of the model. Stages make and change them; steps move their nodes.
struct HeldBy {
  std::shared_ptr<members::Members> members;  // null: none
  // Sends places and rotations of nodes to ranks that do not have their blocks; empty: one process.
  std::function<void(std::vector<members::Node>& nodes)> exchange;
  double work = 0.0;  // work of members that is booked, J
};

void follow_members(World& w);  // moves nodes with their blocks and computes their forces, before a step
// Columns of bodies (linear, angular) and gridpoints: velocities, or forces.
struct MotionColumns {
  LaneVector<geometry::Vector>&linear, &angular, &node;
};
void add_member_springs(const World& w, const Unit* alone, const MotionColumns& velocity, const MotionColumns& force);

}  // namespace quoin::blocks
