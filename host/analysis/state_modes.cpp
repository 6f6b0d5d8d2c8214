#include "analysis/state_modes.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "base/error.h"
#include "results/checkpoint_file.h"
#include "results/provenance.h"
#include "scene/rest_scene.h"
#include "step/findings.h"
#include "step/large_motion.h"
#include "step/results.h"
#include "step/simulation.h"
#include "step/tangent.h"

namespace quoin {

Vibrating vibrating_now(const Simulation& simulation, Tangent tangent) {
  Vibrating v;
  v.stiffness = std::move(tangent.stiffness), v.mass = std::move(tangent.mass);
  for (const Tangent::Unknown& u : tangent.unknown)
    v.unknown.push_back({u.block, u.gridpoint, u.translation, u.spin, u.centre});
  v.groups = std::move(tangent.groups);
  v.points = tangent.points, v.open = tangent.open, v.zones = simulation.zone_count();
  v.symmetry_factor = tangent.symmetry_factor;
  for (int b = 0; b < static_cast<int>(simulation.block_count()); ++b) {
    const BlockMesh mesh = block_mesh(simulation, b);
    const std::vector<Vec3> moved = block_displacement(simulation, b);
    DrawnBlock& drawn = v.drawn.emplace_back();
    drawn.zone = mesh.zone, drawn.face = mesh.face, drawn.held = true;
    for (std::size_t i = 0; i < mesh.gridpoint.size(); ++i)
      drawn.point.push_back(geometry::vector(mesh.gridpoint[i]) + geometry::vector(moved[i]));
    v.label.push_back(block_label(simulation, b));
  }
  for (const Unknown& u : v.unknown) v.drawn[static_cast<std::size_t>(u.block)].held = false;
  const int last = static_cast<int>(simulation.scene().stages.size()) - 1;
  if (last >= 0) v.held = supports_in(simulation, last).held;
  return v;
}

Vibrating vibrating_about(const Scene& scene, const std::string& state, const std::string& stage) {
  if (scene.members)
    throw Error(
        Exit::bad_input,
        fmt::format("{}: modes of a state: not with [[tie]], [[spring]] and [[strip]], whose stiffness there is "
                    "not known; --state undamaged has that of ties and springs",
                    scene.file));
  const bool weight = state == "weight";
  if (!weight && !stage.empty())
    throw Error(Exit::bad_input,
                fmt::format("--stage {}: not with --state {}: a run has one end, with the supports of its last stage; "
                            "remove --stage",
                            stage, state));
  const std::optional<std::string> rest =
      weight ? std::optional(stage) : rest_asked(read_provenance(state).request.overrides);
  Scene there = rest ? at_rest(scene, *rest) : scene;
  there.start = weight ? "" : state;
  if (!weight) there.stages.push_back(there.stages.back());  // a stage after the run's last one, which is not begun
  Simulation simulation(std::move(there), 0);
  Observer nobody;
  if (weight)
    simulation.run(nobody);
  else
    take_start(&simulation);
  Vibrating v = vibrating_now(simulation, tangent_of(simulation));
  v.state = state;
  refuse_if_held(v, scene.file);
  return v;
}

}  // namespace quoin
