#include "step/state/lattice_inertia.h"

#include <algorithm>

namespace quoin {

void LatticeInertia::bind_body_groups(const Model& model, double time_step) {
  of_body_group.clear();
  for (const BodyGroup& group : model.body_groups) of_body_group.push_back(inertia_of(group, model, in_use, time_step));
}

// Tables of the gridpoints that this rank holds.
void LatticeInertia::share(const Model& model, double time_step) {
  const std::size_t doubles = model.node_free.size();
  dt_over_mass = LaneVector<double>(doubles);
  for (std::size_t i = 0; i < doubles; ++i) {
    if (model.node_free[i] != 0.0 && in_use.node[i] > 0.0)
      dt_over_mass[i] = time_step / (in_use.deformation * in_use.node[i]);
  }
  shared_dt_over_mass.clear(), tables.clear();
  for (const BlockGroup& group : model.groups) {
    std::vector<double> table;
    bool uniform = true;
    for (int n = 0; n < model.templates[static_cast<std::size_t>(group.brick_template)].node_count; ++n) {
      for (int c = 0; c < 3; ++c) {
        const double* lane = dt_over_mass.data() + (group.first_line + n) * kLine + c * kLanes;
        table.push_back(lane[0]);
        uniform = uniform && std::all_of(lane, lane + group.block_count, [&](double x) { return x == lane[0]; });
      }
    }
    shared_dt_over_mass.push_back(uniform ? tables.insert(std::move(table)).first->data() : nullptr);
  }
}

}  // namespace quoin
