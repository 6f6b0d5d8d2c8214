// Checks of the motion of blocks since their contacts were detected.
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

// Share of the skin by which a block may move before detection is due.
inline constexpr double kOfSkin = 0.25;
// Share of their allowed motion from which on pairs and blocks take part in a detection that others have caused.
inline constexpr double kMostlyUsed = 0.8;

// Motion of a rigid block at its last check. Until the next check the block is assumed to move on so, with a deviation
// of at most `tolerated` at any of its parts. Members are in the order in which kernels read them.
struct AssumedMotion {
  Vector v;                // m/s
  double radius = 0.0;     // m
  Vector omega;            // rad/s
  double tolerated = 0.0;  // tolerated deviation of speed, m/s
  long step = 0;           // step of the last check
};

// The next check of a pair of blocks.
struct PairCheck {
  int32_t a, b;
  long mostly_used = 0;  // 1: it has used most of its allowed motion, and joins the next narrow phase
  long step = 0;
};

// The checks write these; kernels of rigid blocks read `assumed`.
struct MotionChecks {
  LaneVector<PairCheck> pair;         // check of each contact
  LaneVector<long> block;             // step of the next check, by block
  std::vector<uint8_t> due;           // by block: whether a check is due
  LaneVector<AssumedMotion> assumed;  // by body
  long next = 0;                      // earliest step of any next check
  double dt = 0.0;                    // time step of the checks, s; after a change all blocks are due
  bool any_deviates = false;          // whether some block deviated in the last step
};

bool moved_enough(World& w);
// Motion of b in the frame of a since the pair's last narrow phase, m: translation plus rotation times radius.
// allowed_motion is its bound, beyond which the pair is detected again.
double pair_motion(const World& w, const Contact& c, const PairPlace& place, const Pose& a, const Pose& b);
double allowed_motion(const World& w, const Contact& c, const PairPlace& place);
double detection_fraction(const World& w);  // share of a block's least extent
// Translation plus rotation times radius, m.
double motion_since_broad_phase(const World& w, int block, const Pose& now);
// Pose of a block at a check, and an upper bound of the speed of its parts. The bound is twice the fastest corner's
// speed; for rigid bodies, twice the larger one of |v| and |omega| radius.
struct CheckedMotion {
  Pose pose;
  double speed;  // m/s
};
CheckedMotion checked_motion(const World& w, int block);
bool check_pair_motion(const World& w, const Contact& c, const PairPlace& place, const CheckedMotion& now_a,
                       const CheckedMotion& now_b, PairCheck& check);

}  // namespace quoin::blocks
