// Checks of how far blocks have moved since their contacts were found.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/vector.h"
#include "model/contacts.h"
#include "model/lanes.h"
#include "model/model_block.h"

namespace quoin::blocks {

struct World;

using geometry::Vector;

// Motion that the next checks of a rigid block assume (motion_checks.cpp). It moves as at the last one, but for so much
// of the speed of any part of it. In the order in which kernels read it.
struct SeenMotion {
  Vector v;                // m/s
  double radius = 0.0;     // m
  Vector omega;            // rad/s
  double unnoticed = 0.0;  // m/s
  long step = 0;           // step of the last check
};

// The next check of a pair of blocks.
struct PairCheck {
  int32_t a, b;
  bool ripe = false;  // whether it has moved by most of its way, and is due in the next narrow phase
  long step = 0;
};

// Written by the checks; kernels of rigid blocks read what has been seen.
struct MotionChecks {
  LaneVector<PairCheck> pair;   // check of each contact
  LaneVector<long> block;       // step, by block
  std::vector<uint8_t> due;     // by block: whether a check is due
  LaneVector<SeenMotion> seen;  // by body
  long next = 0;                // step of the next check of any of them
  double dt = 0.0;              // time step of the checks, s; after a change all blocks are due
  bool any_deviates = false;    // some block in the last step
};

bool moved_enough(World& w);
// Motion of b as seen from a since the pair's last narrow detection, m: translation plus rotation times radius.
// allowed_motion is its bound, beyond which the pair is detected again.
double pair_motion(const World& w, const Contact& c, const PairPlace& place, const Pose& a, const Pose& b);
double allowed_motion(const World& w, const Contact& c, const PairPlace& place);
double detection_fraction(const World& w);                   // share of a block's least extent
double motion_since_broad_phase(const World& w, int block);  // translation plus rotation times radius, m
// A block as a check finds it.
struct CheckedMotion {
  Pose pose;
  double speed;  // twice that of its fastest corner, m/s
};
CheckedMotion checked_motion(const World& w, int block);
bool check_pair_motion(const World& w, const Contact& c, const PairPlace& place, const CheckedMotion& now_a,
                       const CheckedMotion& now_b, PairCheck& check);

}  // namespace quoin::blocks
