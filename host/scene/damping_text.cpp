#include "scene/damping_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace quoin {

double local_damping_in(const Scene& scene, std::size_t stage) {
  return damping_of(scene.solver_in(stage), scene.stages[stage].equilibrium_ratio.has_value()).gamma;
}

std::string solver_text(const SolverSettings& solver, bool settling) {
  return fmt::format("damping {}, time_step_fraction {:g}", damping_text(solver, settling), solver.time_step_fraction);
}

bool has_own_inertia(const Scene& scene, std::size_t stage) {
  const SolverSettings& solver = scene.solver_in(stage);
  return solver.deformation_inertia != scene.solver.deformation_inertia ||
         solver.unit_inertia != scene.solver.unit_inertia;
}

std::string own_solver_text(const Scene& scene, std::size_t stage) {
  const SolverSettings& solver = scene.solver_in(stage);
  if (&solver == &scene.solver) return "";
  return solver_text(solver, scene.stages[stage].equilibrium_ratio.has_value()) +
         (has_own_inertia(scene, stage) ? fmt::format(", deformation_inertia {:g}, unit_inertia {:g}",
                                                      solver.deformation_inertia, solver.unit_inertia)
                                        : "");
}

std::string damping_in_space(const Scene& scene, std::size_t stage) {
  const Damping damping = damping_of(scene.solver_in(stage), scene.stages[stage].equilibrium_ratio.has_value());
  if (damping.gamma > 0.0)
    return fmt::format("{} (gamma {:g})", damping.eq1 == Eq1::gridpoints ? "local damping" : "damping by block",
                       damping.gamma);
  return damping.alpha > 0.0 ? fmt::format("mass damping ({:g} 1/s)", damping.alpha) : "";
}

std::string ground_inertia_warning(const Scene& scene, std::size_t stage) {
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

std::string ground_damping_warning(const Scene& scene, std::size_t stage) {
  const std::string damping = damping_in_space(scene, stage);
  if (!scene.stages[stage].ground || damping.empty()) return "";
  return fmt::format(
      "stage '{}' moves the ground, and its {} acts on the motion of whole blocks on the ground, where nothing brakes "
      "them: "
      "what slides, rocks or falls goes wrong by multiples; {}",
      scene.stages[stage].name, damping, kDampingForMotion);
}

std::string release_damping_warning(const Scene& scene, std::size_t stage) {
  if (stage == 0 || local_damping_in(scene, stage) == 0.0) return "";
  const Stage &before = scene.stages[stage - 1], &now = scene.stages[stage];
  const auto is_driven = [](const BodyControl& c) { return c.velocity != Vec3{} || c.omega != Vec3{}; };
  const bool ends_by_duration =
      now.kind == "custom" && !now.equilibrium_ratio && !now.displacement && !now.collapse && !now.moving_load;
  const bool has_same_loads = now.gravity == before.gravity && now.controls == before.controls &&
                              now.forces == before.forces && now.pressures == before.pressures;
  if (!ends_by_duration || has_same_loads || now.ground || now.ramp_time > 0.0 ||
      std::ranges::any_of(now.controls, is_driven))
    return "";
  return fmt::format(
      "stage '{}' changes loads at once (ramp_time 0) and ends by its duration, and its {} brakes the vibrations that "
      "follow: amplitudes and forces are not those of free vibration; {}. Where only the state at rest counts, give "
      "equilibrium_ratio or ramp_time",
      now.name, damping_in_space(scene, stage), kDampingForMotion);
}

std::string collapse_damping_warning(const Scene& scene, std::size_t stage) {
  const Stage& settings = scene.stages[stage];
  const Damping damping = damping_of(scene.solver_in(stage), settings.equilibrium_ratio.has_value());
  const bool deforms = scene.building || (scene.wall && !scene.wall->rigid_units);
  if (!settings.collapse || !deforms || damping.eq1 != Eq1::gridpoints || damping.gamma == 0.0) return "";
  return fmt::format(
      "stage '{}' looks for a collapse, and local damping (gamma {:g}) at gridpoints that vibrate on carries a share "
      "of "
      "the load: walls that should fall creep, and multipliers were up to 5 % too large; take damping = \"block\" or "
      "\"impact\"",
      settings.name, damping.gamma);
}

double landing_restitution(double damping_ratio) {
  const double z = damping_ratio;
  if (z <= 0.0) return 1.0;
  if (z >= 1.0) {  // without a cycle: the force is 0 where tanh(w t) = 2 z w/(2 z^2 - 1)
    const double w = std::sqrt(z * z - 1.0);
    return z == 1.0 ? std::exp(-2.0) : std::exp(-z / w * std::log((z + w) / (z - w)));
  }
  const double w = std::sqrt(1.0 - z * z);
  return std::exp(-z / w * std::atan2(2.0 * z * w, 2.0 * z * z - 1.0));
}

double end_velocity(const GroundMotion::Component& component) {
  constexpr double kRounding = 1e-12;  // m/s; velocity that rounding leaves of a record that ends at rest: counts as 0
  const double end = component.velocity.at(component.acceleration, component.acceleration.time.back());
  return std::abs(end) < kRounding ? 0.0 : end;
}

namespace {

constexpr double kRounding = 1e-9;  // s

bool begins_after(const GroundMotion::Component& component, double duration) {
  return component.acceleration.time.front() >= duration - kRounding;
}

}  // namespace

std::string ground_text(const GroundMotion& ground, std::optional<double> duration) {
  std::string text = ground.blocks.empty() ? "" : fmt::format("of {}: ", fmt::join(ground.blocks, ", "));
  bool first = true;
  for (const GroundMotion::Component& c : ground.components) {
    const auto& time = c.acceleration.time;
    text += fmt::format("{}record of {:g} s along ({:g}), which ends at {:.3g} m/s",
                        std::exchange(first, false) ? "" : "; ", time.back() - time.front(),
                        fmt::join(c.direction, ", "), end_velocity(c));
    if (time.front() > 0.0) text += fmt::format(" and begins at {:g} s", time.front());
    if (duration && begins_after(c, *duration))
      text += ", after the end of the stage";
    else if (duration && time.back() > *duration + kRounding)
      text += fmt::format(", cut at the end of the stage, after {:g} s, at {:.3g} m/s", *duration,
                          c.velocity.at(c.acceleration, *duration));
  }
  for (const std::string& note : ground.notes) text += "; " + note;
  for (const GroundMotion& support : ground.supports)
    text += (std::exchange(first, false) ? "" : "; ") + ground_text(support, duration);
  return text;
}

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

}  // namespace quoin
