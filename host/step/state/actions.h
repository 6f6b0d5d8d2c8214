// Actions of the current stage on blocks in large motion. Actions (step/actions) bind these data when a stage begins
// and update them before each step. All of them are saved.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/broad_phase.h"
#include "geometry/vector.h"
#include "scene/driven.h"

namespace quoin {

constexpr std::uint16_t kOfGround = 0xf;  // Drive::of_ground of a block that moves as the ground along all axes

// Rank of a block or body as the one that stands for the ground. 0: it is none of the ground, or a support with a
// motion of its own.
constexpr int ground_rank(std::uint64_t of_ground, std::int64_t motion) {
  return of_ground == 0 || motion != 0 ? 0 : of_ground == kOfGround ? 2 : 1;
}

// Control of a block of any shape through a stage.
struct Drive {
  int block = -1;
  std::uint8_t held = 0;       // bits 0..2: velocity along x, y, z prescribed; 3..5: rotation
  std::uint8_t in_cycles = 0;  // bits 0..2: the velocity component follows the cycles of the stage
  // Bits 0..2: the velocity component is that of the ground. The stage's record is added to the velocities below, which
  // are what earlier records have left. Bit 3: the block is of the ground, also along components that a controller has
  // set.
  std::uint16_t of_ground = 0;
  std::int32_t motion = 0;  // index of the motion: 0: that of the ground; k: of the k-th group of supports
  std::int32_t unused = 0;  // see base/archive.h
  geometry::Vector velocity_from{}, velocity_to{}, omega_from{}, omega_to{};  // m/s, rad/s
  geometry::Vector force_from{}, force_to{}, force_now{};  // N, along free components; force_now: in this step
  geometry::Vector moment_from{}, moment_now{};  // N m, on free rotations: what held them, which fades over the ramp
};

// Whether a structure stands under the first multiplier of a collapse stage. After the ramp its blocks must stay at
// rest for the longer of two times. One is that in which the multiplier grows by a hundredth. The other is four times
// that of a free fall by the displacement of collapse. Else motion that the ramp has caused could be taken for
// collapse.
struct FirstLoad {
  double since = -1.0;                 // beginning of the time at rest in the stage, s; < 0: not checked yet
  double lowest = 0.0, highest = 0.0;  // displacements of the block that has moved farthest, since then, m
  std::uint64_t carried = 0;  // 1: it stands; as wide as the others, so that no byte of a checkpoint is undefined
  // Adds a check. time: s, in the stage; moved: largest displacement of a block, m; allowed: its largest change at
  // rest, m; needed: time at rest, s.
  void look(double time, double moved, double allowed, double needed);
  static double time_of(const Collapse& collapse, const Vec3& gravity);  // time at rest that is needed, s
};

struct Actions {
  std::vector<Drive> drives;
  std::size_t fading_loads = 0, fading_pressures = 0;  // number of loads of earlier stages, which fade
  double jacked_from = 0.0;                            // share of the pretension when the stage began
  double multiplier = 0.0;                             // multiplier of the body force in a collapse stage
  FirstLoad first_load;                                // for collapse stages
  std::vector<geometry::Vector> collapse_from;         // of blocks against the ground when a collapse stage began, m
  std::vector<geometry::Pair> open_beds;               // beds that were open when a collapse stage began, in order
  geometry::Vector collapse_left;  // body force by mass at the end of a collapse stage, which fades in the next, m/s2
  geometry::Vector ground_left;    // velocity that records have left to ground below springs that no block follows, m/s

  Drive* drive_of(int block) {  // null: it has none
    const auto found = std::ranges::find(drives, block, &Drive::block);
    return found == drives.end() ? nullptr : &*found;
  }
  const Drive* ground_drive() const;  // drive of a block that moves with the ground; null: none
};

}  // namespace quoin
