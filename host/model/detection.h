// Contact detection: its tolerances and counters.
#pragma once

namespace quoin::blocks {

struct World;

struct DetectionState {
  double size = 1.0;                 // least extent of all blocks, m
  double skin = 0.0;                 // distance within which the broad phase keeps pairs, m
  double reach = 0.0;                // distance up to which contact points are placed, m
  double joint_tolerance = 0.0;      // largest gap or overlap of joints of the start, m
  long count = 0, narrow_calls = 0;  // numbers of detections, and of pairs in the narrow phase
};

void detect_contacts(World& w, bool everything = false);

}  // namespace quoin::blocks
