// Pairs of blocks without a joint, in small displacements. If two of them come into contact, the contacts of the start
// do not describe it.
#pragma once

#include <functional>
#include <vector>

#include "geometry/broad_phase.h"
#include "scene/assembly.h"
#include "step/motion_bound.h"

namespace quoin {

// Two blocks at the distance g0 at the start may approach to min(g0, h)/2. h is half of the least extent of a block.
// Two that touch at an edge or corner at the start may overlap by sliding_bound of the smaller one's least extent:
// their neighbours may slide.
class UnjoinedBlocks {
 public:
  UnjoinedBlocks() = default;
  explicit UnjoinedBlocks(const Assembly& assembly);  // the assembly must outlive this

  // Whether two blocks that meet across this axis have contact by the rules of the scene.
  using HaveContact = std::function<bool(int a, int b, int axis)>;
  // Updates `seen` with the current motion. motion: one a brick. Returns the least time, s, in which a pair could
  // approach to half of its least distance allowed, at this acceleration, m/s2. The next check is due then.
  double look(const std::vector<WholeMotion>& motion, double sliding_bound, double acceleration,
              const HaveContact& have_contact, MotionSeen* seen);

 private:
  struct Near {
    double gap;        // m; < 0: depth of an overlap
    double least_gap;  // least distance allowed, m
    int axis;          // axis of the largest gap
  };
  void find_pairs(const std::vector<WholeMotion>& motion);
  bool has_moved(const std::vector<WholeMotion>& motion) const;  // enough for other pairs to be near
  Near nearness(const geometry::Pair& pair, const std::vector<WholeMotion>& motion, double sliding_bound) const;

  const Assembly* assembly_ = nullptr;
  double reach_ = 0.0;                  // h, m
  std::vector<geometry::Pair> joined_;  // sorted
  std::vector<geometry::Pair> pairs_;   // closer than 3/2 h at the last broad phase
  std::vector<Vec3> there_;             // translations of blocks at that time, m
};

}  // namespace quoin
