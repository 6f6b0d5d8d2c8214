// What acts on blocks in large motion through a stage. Actions (step/actions) bind it when a stage begins and go on
// with it before each step; all of it is saved.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/vector.h"
#include "scene/scene.h"

namespace quoin {

// Control of a block of any shape through a stage.
struct Drive {
  int block = -1;
  std::uint8_t held = 0;       // bits 0..2: velocity along x, y, z prescribed; 3..5: rotation
  std::uint8_t in_cycles = 0;  // bits 0..2: this component follows the cycles of the stage
  // bits 0..2: this component is of the ground, which adds its record to the velocities below: what is left of earlier
  // records.
  std::uint8_t of_ground = 0;
  std::int32_t motion = 0;  // index of the motion: 0: that of the ground; from 1 on: of a group of supports
  geometry::Vector velocity_from, velocity_to, omega_from, omega_to;  // m/s, rad/s
  geometry::Vector force_from, force_to, force_now;                   // N, along free components
};

// Whether the first multiplier of a collapse stage is carried. After its ramp the blocks then have stood for as long as
// the multiplier takes to grow by a hundredth. They have stood four times as long as a fall by what counts as collapse,
// too. Else what moves them later may be what the ramp has set in motion.
struct FirstLoad {
  double since = -1.0;                 // s, in the stage; < 0: not checked yet
  double lowest = 0.0, highest = 0.0;  // largest displacement of a block since then, m
  bool carried = false;
  void look(double time, double moved, double allowed, double needed);   // s, m, m, s
  static double time_of(const Collapse& collapse, const Vec3& gravity);  // s
};

struct Actions {
  std::vector<Drive> drives;
  std::size_t fading_loads = 0, fading_pressures = 0;  // the first of the model's, from the stage before
  double multiplier = 0.0;                             // multiplier of the body force in a collapse stage
  FirstLoad first_load;

  const Drive* ground_drive() const;  // a block that moves as the ground does; null: none
};

}  // namespace quoin
