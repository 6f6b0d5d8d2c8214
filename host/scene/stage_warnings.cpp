#include "scene/stage_warnings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "base/smooth_step.h"
#include "scene/block_kinds.h"
#include "scene/damping_text.h"
#include "scene/driven.h"
#include "scene/members.h"

namespace quoin {

bool ends_by_duration(const Stage& stage) {
  return stage.kind == "custom" && !stage.equilibrium_ratio && !stage.displacement && !stage.ground && !stage.cycles &&
         !moves_blocks(stage);
}

// Each gives the warning of a stage; empty: none.
namespace {

// Ground motion, and inertia of whole blocks that is raised.
std::string raised_inertia(const Scene& scene, std::size_t stage) {
  const SolverSettings& solver = scene.solver_in(stage);
  std::string raised;  // that of whole blocks; deformation_inertia and unit_inertia are not
  if (solver.mass_scaling != 1.0) raised = fmt::format("mass_scaling = {:g}", solver.mass_scaling);
  if (solver.selective_time_step > 0.0)
    raised = fmt::format("selective_time_step = {:g} s", solver.selective_time_step);
  if (!scene.stages[stage].ground || raised.empty()) return "";
  return fmt::format(
      "stage '{}' moves the ground, and {} raises inertia: frequencies are lower than the true ones, and forces are "
      "those of more mass; compare with a run without it",
      scene.stages[stage].name, raised);
}

// Ground motion, and damping in space.
std::string damped_ground(const Scene& scene, std::size_t stage) {
  const std::string damping = damping_in_space(scene, stage);
  if (!scene.stages[stage].ground || damping.empty()) return "";
  return fmt::format(
      "stage '{}' moves the ground, and its {} acts on the motion of whole blocks on the ground, where nothing brakes "
      "them: what slides, rocks or falls goes wrong by multiples; {}",
      scene.stages[stage].name, damping, kDampingForMotion);
}

// Ground motion without weight, or with weight that comes at once.
std::string weight_under_ground(const Scene& scene, std::size_t stage) {
  const Stage& now = scene.stages[stage];
  if (!now.ground) return "";
  if (now.gravity == Vec3{})
    return fmt::format(
        "stage '{}' moves the ground and has no weight (gravity is 0): dry joints carry nothing, and friction is that "
        "of pressures alone; give it gravity = [0, -9.81, 0]",
        now.name);
  const Vec3 before = stage > 0 ? scene.stages[stage - 1].gravity : Vec3{};
  if (now.gravity == before || now.ramp_time > 0.0) return "";
  return fmt::format(
      "stage '{}' moves the ground, and its gravity comes at once: joints vibrate under up to twice the weight; put a "
      "stage of weight with equilibrium_ratio before it",
      now.name);
}

// Loads that change at once where nothing is driven, and eq. 1 that brakes the vibrations that follow. Not for the
// first stage, which is taken for settling.
std::string damped_release(const Scene& scene, std::size_t stage) {
  if (stage == 0 || local_damping_in(scene, stage) == 0.0) return "";
  const Stage &before = scene.stages[stage - 1], &now = scene.stages[stage];
  const bool has_same_loads = now.gravity == before.gravity && now.controls == before.controls &&
                              now.forces == before.forces && now.pressures == before.pressures;
  if (!ends_by_duration(now) || has_same_loads || now.ramp_time > 0.0) return "";
  return fmt::format(
      "stage '{}' changes loads at once (ramp_time 0) and ends by its duration, and its {} brakes the vibrations that "
      "follow: amplitudes and forces are not those of free vibration; {}. Where only the state at rest counts, give "
      "equilibrium_ratio or ramp_time",
      now.name, damping_in_space(scene, stage), kDampingForMotion);
}

// gamma of eq. 1 at the gridpoints of deformable blocks; 0: none.
double gamma_at_gridpoints(const Scene& scene, std::size_t stage) {
  const Damping damping = damping_of(scene.solver_in(stage), scene.stages[stage].equilibrium_ratio.has_value());
  return kinds_of_blocks(scene).deformable && damping.eq1 == Eq1::gridpoints ? damping.gamma : 0.0;
}

// Rigid blocks that are moved under eq. 1.
std::string drag_of_rigid_blocks(const Scene& scene, std::size_t stage) {
  const Damping damping = damping_of(scene.solver_in(stage));
  if (!scene.blocks || damping.eq1 != Eq1::gridpoints || !(damping.gamma > kGammaInMotion) ||
      !moves_blocks(scene.stages[stage]) || !kinds_of_blocks(scene).rigid)
    return "";
  return fmt::format(
      "stage '{}' moves blocks, rigid ones among them, under local damping (gamma {:g}), which turns the chatter of "
      "their contacts into "
      "drag: a pile on a table that tilts fell at 46 degrees in place of 27, and multipliers of collapse were up to 9 "
      "% too large; take damping = \"impact\" or \"viscous\" there",
      scene.stages[stage].name, damping.gamma);
}

// A collapse of deformable units under eq. 1 at gridpoints, whose vibrations carry a share of the load.
std::string damped_collapse(const Scene& scene, std::size_t stage) {
  const Stage& settings = scene.stages[stage];
  const double gamma = gamma_at_gridpoints(scene, stage);
  if (!settings.collapse || gamma == 0.0) return "";
  return fmt::format(
      "stage '{}' looks for a collapse, and local damping (gamma {:g}) at gridpoints that vibrate on carries a share "
      "of the load: walls that should fall creep, and multipliers were up to 5 % too large, 40 % where blocks move "
      "at an angle to the axes; take damping = \"block\" or \"impact\"",
      settings.name, gamma);
}

// Motion at an angle to the axes of space, and eq. 1 at gridpoints, which acts on components along them.
std::string damped_at_an_angle(const Scene& scene, std::size_t stage) {
  constexpr double kStraight = 0.05;  // of the velocity; less across an axis counts as along it
  const Stage& now = scene.stages[stage];
  const double gamma = gamma_at_gridpoints(scene, stage);
  if (gamma == 0.0) return "";
  for (const BodyControl& c : now.controls) {
    const auto& v = c.velocity;
    const double largest = std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])});
    if (std::hypot(v[0], v[1], v[2]) <= largest * std::hypot(1.0, kStraight)) continue;
    return fmt::format(
        "stage '{}' drives '{}' at an angle to the axes, and local damping (gamma {:g}) acts on the components of "
        "motion along them: vibrations across the driven motion brake it, so that a wall at 37 degrees in plan was 12 "
        "% too strong; take damping = \"block\", or lay the wall along an axis",
        now.name, c.body, gamma);
  }
  return "";
}

// Soil beside masonry that ground motion moves.
std::string soil_stays_behind(const Scene& scene, std::size_t stage) {
  const Stage& now = scene.stages[stage];
  if (!now.ground || !scene.members || scene.members->fills.empty()) return "";
  return fmt::format(
      "stage '{}' moves the ground, and the soil of [[fill]] '{}' stays where it is: the motion of the ground itself "
      "presses the masonry against it, up to its passive or active limit; give accelerations as weight along the "
      "motion "
      "(gravity), or leave the soil out and add its pressure",
      now.name, scene.members->fills.front().name);
}

// Viscous damping without a coefficient.
std::string viscous_without_coefficients(const Scene& scene, std::size_t stage) {
  const SolverSettings& solver = scene.solver_in(stage);
  if (solver.damping != DampingKind::viscous || solver.mass_damping > 0.0 || solver.stiffness_damping > 0.0) return "";
  return fmt::format(
      "stage '{}' has damping = \"viscous\" with mass_damping = 0 and stiffness_damping = 0, so that nothing is "
      "damped; "
      "give one of them, or take damping = \"none\"",
      scene.stages[stage].name);
}

// Records that begin after the end of the stage.
std::string record_outside(const Stage& stage) {
  if (!stage.ground || !stage.duration) return "";
  const auto look = [&](const GroundMotion& ground) -> std::string {
    for (const GroundMotion::Component& c : ground.components) {
      if (begins_after(c, *stage.duration))
        return fmt::format(
            "stage '{}': the record along ({:g}) begins at {:g} s, when the stage of {:g} s has ended: it "
            "moves nothing; give the time from which it is taken (start), or a longer duration",
            stage.name, fmt::join(c.direction, ", "), c.acceleration.time.front(), *stage.duration);
    }
    return "";
  };
  std::string text = look(*stage.ground);
  for (const GroundMotion& support : stage.ground->supports) text = text.empty() ? look(support) : text;
  return text;
}

// A record where the stage itself moves or holds all fixed blocks. Springs move with the ground on their own.
std::string record_of_none(const Scene& scene, std::size_t stage) {
  const Stage& now = scene.stages[stage];
  const bool blocks_alone = scene.blocks && !scene.wall && !scene.building && scene.blocks->walls.empty() &&
                            scene.blocks->arches.empty() && !(scene.members && !scene.members->springs.empty());
  if (!now.ground || !blocks_alone) return "";
  std::vector<std::string> held;
  for (const BlockSpec& block : scene.blocks->blocks) {
    if (!block.fixed_names.empty()) return "";
    if (!block.fixed) continue;
    if (std::ranges::find(now.controls, block.name, &BodyControl::body) == now.controls.end()) return "";
    held.push_back(block.name);
  }
  if (held.empty()) return "";
  return fmt::format(
      "stage '{}': ground_motion moves nothing, as the stage has a velocity for all fixed blocks ({}); leave their "
      "velocity out, or the ground_motion",
      now.name, fmt::join(held, ", "));
}

// A displacement that ends the stage, along an axis on which its monitor is held.
std::string held_monitor(const Scene& scene, std::size_t stage) {
  const Stage& now = scene.stages[stage];
  const std::string& monitor = now.monitor.empty() ? scene.output.monitor : now.monitor;
  const auto c = static_cast<std::size_t>(now.direction);
  const auto found = std::ranges::find(now.controls, monitor, &BodyControl::body);
  const bool ends_otherwise = now.duration || now.equilibrium_ratio || now.collapse || now.moving_load || now.ground;
  if (!now.displacement || ends_otherwise || !now.roof.empty() || now.cycles || now.whiffletree ||
      found == now.controls.end() || found->kind[c] == DofKind::free || found->velocity[c] != 0.0 ||
      found->omega != Vec3{})
    return "";
  return fmt::format(
      "stage '{}' ends by the displacement of '{}' along {}, where it holds that body, so it may never end; give "
      "another direction or monitor",
      now.name, monitor, "xyz"[c]);
}

// A body that the stage before has driven, and that goes on over the ramp before it stops or turns back.
std::string goes_on_in_ramp(const Scene& scene, std::size_t stage) {
  constexpr double kAllowed = 0.05;  // of the smaller displacement at which the two stages end
  const Stage& now = scene.stages[stage];
  if (stage == 0 || now.ramp_time <= 0.0 || now.cycles) return "";
  const Stage& before = scene.stages[stage - 1];
  const double asked = std::min(before.displacement.value_or(1e300), now.displacement.value_or(1e300));
  for (const BodyControl& c : now.controls) {
    const auto then = std::ranges::find(before.controls, c.body, &BodyControl::body);
    for (std::size_t k = 0; k < 3 && then != before.controls.end(); ++k) {
      if (before.cycles || c.kind[k] == DofKind::free || then->kind[k] == DofKind::free) continue;
      const double from = then->velocity[k], to = c.velocity[k];
      if (from == 0.0 || from * to > 0.0) continue;
      double on = 0.0;  // m, farthest along the old velocity
      constexpr int kParts = 100;
      for (int i = 1; i <= kParts; ++i)
        on = std::max(on, std::copysign(1.0, from) * way_between(from, to, now.ramp_time * i / kParts, now.ramp_time));
      if (on <= kAllowed * asked) continue;
      return fmt::format(
          "stage '{}' takes '{}' from {:g} to {:g} m/s along {} over its ramp_time of {:g} s, in which it goes on by "
          "{:.3g} mm before it {}; give a shorter ramp_time",
          now.name, c.body, from, to, "xyz"[k], now.ramp_time, on * 1e3, to == 0.0 ? "stands still" : "turns back");
    }
  }
  return "";
}

// A duration that ends the stage inside its ramp. Cycles have ramps of their own.
std::string ends_in_ramp(const Stage& stage) {
  if (!stage.duration || *stage.duration >= stage.ramp_time || stage.equilibrium_ratio || stage.displacement ||
      stage.cycles)
    return "";
  return fmt::format(
      "stage '{}' ends by its duration of {:g} s, inside its ramp_time of {:g} s: {:.2g} % of the change of its loads "
      "and velocities has come by then; give a duration above ramp_time, or a shorter ramp_time",
      stage.name, *stage.duration, stage.ramp_time, 100.0 * smooth_step(*stage.duration / stage.ramp_time));
}

// Forces of the stage before on bodies that no control of this one names: they end with it.
std::string loads_that_end(const Scene& scene, std::size_t stage) {
  if (stage == 0 || !(scene.wall || scene.building)) return "";
  const Stage& now = scene.stages[stage];
  Vec3 sum{};
  const BodyControl* first = nullptr;
  std::vector<std::string> bodies;
  for (const BodyControl& c : scene.stages[stage - 1].controls) {
    if (c.force == Vec3{} || std::ranges::count(now.controls, c.body, &BodyControl::body)) continue;
    if (!first) first = &c;
    bodies.push_back(c.body);
    for (std::size_t i = 0; i < 3; ++i) sum[i] += c.force[i];
  }
  if (!first) return "";
  return fmt::format(
      "stage '{}' ends the loads of the stage before on {}: ({:g}) N in all. A stage with [[stage.control]] alone has "
      "the loads that these state; where they are to stay, give each body its own, as body = \"{}\", velocity = "
      "[\"free\", \"free\", \"free\"], rotation_held = false, force = [{:g}]",
      now.name, fmt::join(bodies, ", "), fmt::join(sum, ", "), first->body, fmt::join(first->force, ", "));
}

// Whether a stage pushes or moves masonry along an axis.
bool acts_along(const Stage& stage, std::size_t axis) {
  const auto has = [axis](const Vec3& v) { return v[axis] != 0.0; };
  const auto shakes = [&](const GroundMotion& ground) {
    return std::ranges::any_of(ground.components, has, &GroundMotion::Component::direction);
  };
  return has(stage.gravity) || (stage.collapse && has(stage.collapse->direction)) ||
         (stage.ground && (shakes(*stage.ground) || std::ranges::any_of(stage.ground->supports, shakes))) ||
         std::ranges::any_of(stage.controls, [&](const BodyControl& c) { return has(c.velocity) || has(c.force); }) ||
         std::ranges::any_of(stage.forces, has, &PointForce::force) ||
         std::ranges::any_of(stage.pressures, has, &FacePressure::normal);
}

// Bending out of plane of joints between deformable bricks with few zones through the thickness. Gridpoints share the
// area of a joint in proportion to zones. So its second moment is 1 + 2/n^2 times the true one.
std::string few_zones_in_bending(const Scene& scene, std::size_t stage) {
  constexpr int kEnough = 4;  // 12 % too stiff
  const Stage& now = scene.stages[stage];
  const int zones = scene.building                           ? scene.building->zones[2]
                    : scene.wall && !scene.wall->rigid_units ? scene.wall->zones[2] * (1 + scene.wall->half_thickness)
                                                             : kEnough;
  const auto is_across = [&](const BuildingSpec::Wall& wall) { return acts_along(now, wall.axis == 0 ? 2 : 0); };
  const bool bends = scene.building
                         ? (now.ground || now.collapse) && std::ranges::any_of(scene.building->walls, is_across)
                         : acts_along(now, 2);
  if (zones >= kEnough || !bends) return "";
  return fmt::format(
      "stage '{}' bends walls out of plane, and their joints have {} zone{} through the thickness: elastic ones are "
      "{:.3g} times too stiff, and those that break at once so much too strong, as 1 + 2/n^2 for n zones; take 4 or "
      "more in the last number of zones{}",
      now.name, zones, zones > 1 ? "s" : "", 1.0 + 2.0 / (zones * zones), scene.wall ? ", or rigid_units = true" : "");
}

}  // namespace

std::vector<StageWarning> stage_warnings(const Scene& scene, std::size_t stage) {
  std::vector<StageWarning> all = {
      {"damping", damped_ground(scene, stage)},          {"release", damped_release(scene, stage)},
      {"drag", drag_of_rigid_blocks(scene, stage)},      {"collapse", damped_collapse(scene, stage)},
      {"angle", damped_at_an_angle(scene, stage)},       {"ramp", goes_on_in_ramp(scene, stage)},
      {"short_ramp", ends_in_ramp(scene.stages[stage])}, {"held_monitor", held_monitor(scene, stage)},
      {"record", record_outside(scene.stages[stage])},   {"record", record_of_none(scene, stage)},
      {"weight", weight_under_ground(scene, stage)},     {"inertia", raised_inertia(scene, stage)},
      {"thickness", few_zones_in_bending(scene, stage)}, {"viscous", viscous_without_coefficients(scene, stage)},
      {"soil", soil_stays_behind(scene, stage)},         {"loads", loads_that_end(scene, stage)}};
  std::erase_if(all, [](const StageWarning& warning) { return warning.text.empty(); });
  return all;
}

}  // namespace quoin
