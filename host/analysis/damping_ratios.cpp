#include "analysis/damping_ratios.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "analysis/modes.h"
#include "analysis/state_modes.h"
#include "base/error.h"
#include "step/collect.h"
#include "step/results.h"

namespace quoin {

namespace {

constexpr int kCount = 3;

// Reason where modes cost too much beside the stage; else empty.
std::string why_dear(const Simulation& simulation, const Stage& stage) {
  double unknowns = 0.0;
  for (int block = 0; block < static_cast<int>(simulation.block_count()); ++block) {
    const BlockSize size = block_size(simulation, block);
    unknowns += size.zones > 0 ? 3.0 * static_cast<double>(size.gridpoints) : 6.0;
  }
  // Measured cost in steps (manual/EARTHQUAKES.md).
  constexpr double kLikeSteps = 6000.0, kFew = 3000.0, kShare = 0.03;
  const double steps = stage.duration.value_or(0.0) / simulation.time_step_report().time_step;
  if (unknowns <= kFew || kLikeSteps <= kShare * steps) return "";
  return fmt::format("that would take more than {:g} % of the stage", 100.0 * kShare);
}

}  // namespace

StageModes damped_modes(const Simulation& simulation, int stage) {
  StageModes found{stage, {}, ""};
  const auto without = [&](std::string why) {
    found.why_none = std::move(why);
    return found;
  };
  const Scene& scene = simulation.scene();
  const Damping damping = damping_of(scene.solver_in(static_cast<std::size_t>(stage)));
  if (damping.alpha == 0.0 && !damping.of_contacts()) return without("no viscosity damps");
  if (ranks_collect(simulation)) return without("not on several ranks");
  if (scene.members) return without("stiffness of ties, floors and beams is not in them");
  if (std::string why = why_dear(simulation, scene.stages[static_cast<std::size_t>(stage)]); !why.empty())
    return without(std::move(why));
  try {
    Tangent tangent = tangent_of(simulation);
    if (tangent.unknown.empty()) return without("nothing is free");
    const Eigen::SparseMatrix<double> viscosity = std::move(tangent.viscosity);
    const Vibrating v = vibrating_now(simulation, std::move(tangent));
    ModesSettings settings;
    settings.count = std::min(kCount, static_cast<int>(v.unknown.size()));
    const Modes modes = find_modes(v, settings);
    const auto mass = Eigen::Map<const Eigen::VectorXd>(v.mass.data(), static_cast<Eigen::Index>(v.mass.size()));
    for (std::size_t i = 0; i < modes.mode.size(); ++i) {
      const double omega = 2.0 * std::numbers::pi * modes.mode[i].frequency;
      if (omega <= 0.0) continue;
      const Eigen::VectorXd shape = modes.shape.col(static_cast<Eigen::Index>(i));
      const Eigen::VectorXd force = viscosity.selfadjointView<Eigen::Lower>() * shape;
      found.modes.push_back(
          {modes.mode[i].frequency, shape.dot(force) / (2.0 * omega * mass.dot(shape.cwiseProduct(shape)))});
    }
  } catch (const Error& error) {
    found.modes.clear();
    return without(error.what());
  }
  if (found.modes.empty()) return without("the first modes have no stiffness");
  return found;
}

}  // namespace quoin
