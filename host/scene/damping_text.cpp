#include "scene/damping_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace quoin {

const char* name_of(DampingKind kind) {
  switch (kind) {
    case DampingKind::none:
      return "none";
    case DampingKind::local:
      return "local";
    case DampingKind::viscous:
      return "viscous";
    case DampingKind::block:
      return "block";
  }
  return "";
}

namespace {

double gamma_of(const SolverSettings& solver, bool settling) {
  if (solver.damping != DampingKind::local && solver.damping != DampingKind::block) return 0.0;
  return settling ? solver.settling_damping.value_or(solver.local_damping) : solver.local_damping;
}

}  // namespace

double local_damping_in(const Scene& scene, std::size_t stage) {
  return gamma_of(scene.solver_in(stage), scene.stages[stage].equilibrium_ratio.has_value());
}

std::string solver_text(const SolverSettings& solver, bool settling) {
  std::string text = fmt::format("damping {}", name_of(solver.damping));
  const double gamma = gamma_of(solver, settling);
  if (solver.damping == DampingKind::local) text += fmt::format(" {:g}", gamma);
  if (solver.damping == DampingKind::block)
    text += fmt::format(" {:g}, of deformation {:g}", gamma, solver.deformation_damping);
  if (solver.damping == DampingKind::viscous)
    text += fmt::format(", mass {:g} 1/s, stiffness {:g} s", solver.mass_damping, solver.stiffness_damping);
  return text + fmt::format(", time_step_fraction {:g}", solver.time_step_fraction);
}

std::string own_solver_text(const Scene& scene, std::size_t stage) {
  const SolverSettings& solver = scene.solver_in(stage);
  return &solver == &scene.solver ? "" : solver_text(solver, scene.stages[stage].equilibrium_ratio.has_value());
}

std::string damping_in_space(const Scene& scene, std::size_t stage) {
  const SolverSettings& solver = scene.solver_in(stage);
  if (const double gamma = local_damping_in(scene, stage); gamma > 0.0)
    return fmt::format("{} (gamma {:g})", solver.damping == DampingKind::local ? "local damping" : "damping by block",
                       gamma);
  if (solver.damping == DampingKind::viscous && solver.mass_damping > 0.0)
    return fmt::format("mass damping ({:g} 1/s)", solver.mass_damping);
  return "";
}

std::string ground_damping_warning(const Scene& scene, std::size_t stage) {
  const std::string damping = damping_in_space(scene, stage);
  if (!scene.stages[stage].ground || damping.empty()) return "";
  return fmt::format(
      "stage '{}' moves the ground, and its {} acts on the motion of whole blocks in space, where nothing brakes them: "
      "what slides, rocks or falls goes wrong by multiples; {}",
      scene.stages[stage].name, damping, kDampingForMotion);
}

double end_velocity(const GroundMotion& ground) {
  return ground.acceleration.integral(ground.acceleration.time.back());
}

std::string ground_text(const GroundMotion& ground) {
  const auto& time = ground.acceleration.time;
  return fmt::format("record of {:g} s along ({:g}), which ends at {:.3g} m/s", time.back() - time.front(),
                     fmt::join(ground.direction, ", "), end_velocity(ground));
}

}  // namespace quoin
