// Velocity at which a stage drives bodies, and what it watches.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/upright_axis.h"
#include "scene/scene.h"

namespace quoin {

// The control of a body in a stage. Where there is none, one is added that is free to move and to turn.
inline BodyControl& control_of(const std::string& body, Stage& stage) {
  const auto found = std::ranges::find(stage.controls, body, &BodyControl::body);
  if (found != stage.controls.end()) return *found;
  BodyControl& control = stage.controls.emplace_back();
  control.body = body;
  control.kind.fill(DofKind::free);
  control.may_turn = true;
  return control;
}

// Components that a stage prescribes, moved or held: displacements along x, y, z in bits 0..2, rotations in bits 3..5.
inline unsigned prescribed_by(const BodyControl& control) {
  unsigned bits = control.may_turn ? 0u : 0x38u;
  for (unsigned c = 0; c < 3; ++c) bits |= control.kind[c] == DofKind::velocity ? 1u << c : 0u;
  return bits;
}
inline constexpr std::uint8_t kAllPrescribed = 0x3f;

// Axes along which a stage drives bodies. only: those that count; empty: all.
inline std::array<bool, 3> driven_along(const Stage& stage, const std::vector<std::string>& only = {}) {
  std::array<bool, 3> driven{};
  for (const BodyControl& control : stage.controls) {
    for (std::size_t c = 0; c < 3 && (only.empty() || std::ranges::count(only, control.body) > 0); ++c)
      driven[c] = driven[c] || (control.kind[c] == DofKind::velocity && control.velocity[c] != 0.0);
  }
  return driven;
}

// Whether a control drives its bodies.
inline bool moves_body(const BodyControl& c) { return c.velocity != Vec3{} || c.omega != Vec3{} || c.in_cycles >= 0; }

// Whether a stage moves blocks: driven ones, or all at a collapse or under a moving load.
inline bool moves_blocks(const Stage& stage) {
  return stage.collapse || stage.moving_load || std::ranges::any_of(stage.controls, moves_body);
}

// gamma of eq. 1 in stages that move rigid blocks, where the scene has no damping of its own. In motion the sign of a
// velocity does not change, so that gamma times the chatter of contacts is drag. With 0.8 a pile on a table that tilts
// fell at 46 degrees in place of 27. A larger one is warned of. Results for less: host/scenes/BLOCKS.md.
inline constexpr double kGammaInMotion = 0.1;

// The only axis of these; else x.
inline int only_axis(const std::array<bool, 3>& axes) {
  return axes == std::array{false, true, false} ? 1 : axes == std::array{false, false, true} ? 2 : 0;
}

// Level axes along which the forces of a stage act, where they are its only action. Loads along the vertical press.
inline std::array<bool, 3> forced_along(const Stage& stage) {
  std::array<bool, 3> forced{};
  if (stage.ground || stage.collapse || stage.moving_load || !stage.pressures.empty()) return forced;
  for (const PointForce& f : stage.forces)
    for (std::size_t c = 0; c < 3; ++c) forced[c] = forced[c] || f.force[c] != 0.0;
  forced[static_cast<std::size_t>(upright_axis(stage.gravity))] = false;
  return forced;
}

// Stage::direction where the scene gives none: the only axis along which bodies are driven, else a level one of forces,
// else x. In a stage that ends by a displacement those count alone whose displacement that is.
inline int default_direction(const Stage& stage, const Scene& scene) {
  if (driven_along(stage) == std::array{false, false, false}) return only_axis(forced_along(stage));
  if (!stage.displacement) return only_axis(driven_along(stage));
  const std::string& monitor = stage.monitor.empty() ? scene.output.monitor : stage.monitor;
  return only_axis(driven_along(
      stage, stage.roof.empty() ? bodies_called(monitor, scene.building.value_or(BuildingSpec{})) : stage.roof));
}

// Velocity of the monitor or roof, or of the jack of a whiffletree, along the direction of the stage after its ramp,
// m/s. 0: the stage does not drive it.
inline double driven_velocity(const Stage& stage) {
  if (stage.whiffletree) return stage.whiffletree->velocity;
  const auto c = static_cast<std::size_t>(stage.direction);
  const std::string& body = stage.roof.empty() ? stage.monitor : stage.roof.front();
  const auto found = std::ranges::find(stage.controls, body, &BodyControl::body);
  return found == stage.controls.end() || found->kind[c] == DofKind::free ? 0.0 : found->velocity[c];
}

}  // namespace quoin
