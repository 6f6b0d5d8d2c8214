// Blocks whose mean motion is watched: the monitor, or a floor of a building.
#pragma once

#include <vector>

namespace quoin {

struct WatchedBlocks {
  std::vector<int> bodies, loaded;  // on the lattice; loaded: indices into Controls::loaded_blocks
  std::vector<int> large_motion;    // blocks in large motion; bodies and loaded are then empty

  double count() const { return static_cast<double>(bodies.size() + loaded.size() + large_motion.size()); }
  bool empty() const { return bodies.empty() && loaded.empty() && large_motion.empty(); }
};

}  // namespace quoin
