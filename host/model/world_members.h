// Members that hold blocks beside their joints, in a model.
#pragma once

#include <functional>
#include <memory>
#include <vector>

namespace quoin::members {
struct Node;
class Members;
}  // namespace quoin::members

namespace quoin::blocks {

// Members are made and changed by stages; steps move their nodes along.
struct HeldBy {
  std::shared_ptr<members::Members> members;  // null: none
  // Of places and turns of nodes, to ranks that do not have their blocks; empty: one process.
  std::function<void(std::vector<members::Node>& nodes)> exchange;
  double work = 0.0;  // of them, that energies have, J
};

}  // namespace quoin::blocks
