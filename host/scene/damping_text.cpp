#include "scene/damping_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <utility>

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
    case DampingKind::impact:
      return "impact";
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
  if (solver.damping == DampingKind::impact)
    text += fmt::format(" {:g} of critical on closed contacts", solver.impact_damping);
  if (solver.damping == DampingKind::impact && solver.maxwell_damping > 0.0)
    text += fmt::format(", Maxwell {:g} from {:g} to {:g} Hz", solver.maxwell_damping, solver.maxwell_band[0],
                        solver.maxwell_band[1]);
  if (solver.damping == DampingKind::impact && solver.implicit_contacts)
    text += ", joints implicit while blocks are on the lattice";
  return text + fmt::format(", time_step_fraction {:g}", solver.time_step_fraction);
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
      "stage '{}' moves the ground, and its {} acts on the motion of whole blocks on the ground, where nothing brakes "
      "them: "
      "what slides, rocks or falls goes wrong by multiples; {}",
      scene.stages[stage].name, damping, kDampingForMotion);
}

// What rounding leaves of a record that ends at rest counts as 0.
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
  constexpr double kRounding = 1e-12;  // m/s
  const double end = component.velocity.at(component.acceleration, component.acceleration.time.back());
  return std::abs(end) < kRounding ? 0.0 : end;
}

std::string ground_text(const GroundMotion& ground) {
  std::string text = ground.blocks.empty() ? "" : fmt::format("of {}: ", fmt::join(ground.blocks, ", "));
  bool first = true;
  for (const GroundMotion::Component& c : ground.components) {
    const auto& time = c.acceleration.time;
    text += fmt::format("{}record of {:g} s along ({:g}), which ends at {:.3g} m/s",
                        std::exchange(first, false) ? "" : "; ", time.back() - time.front(),
                        fmt::join(c.direction, ", "), end_velocity(c));
  }
  for (const std::string& note : ground.notes) text += "; " + note;
  for (const GroundMotion& support : ground.supports)
    text += (std::exchange(first, false) ? "" : "; ") + ground_text(support);
  return text;
}

}  // namespace quoin
