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
  constexpr double kAtRest = 1e-12;  // m/s; velocity that rounding leaves of a record that ends at rest: counts as 0
  const double end = component.velocity.at(component.acceleration, component.acceleration.time.back());
  return std::abs(end) < kAtRest ? 0.0 : end;
}

namespace {

constexpr double kRounding = 1e-9;  // s

}  // namespace

bool begins_after(const GroundMotion::Component& component, double duration) {
  return component.acceleration.time.front() >= duration - kRounding;
}

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

}  // namespace quoin
