// Inertia of the lattice, for the part that this rank holds, in the current time step. It is written when a time step
// is chosen and when work is divided. It follows from the model.
#pragma once

#include <set>
#include <vector>

#include "model/model.h"
#include "model/time_step.h"
#include "step/rigid_bodies.h"

namespace quoin {

struct LatticeInertia {
  Inertia in_use;
  LaneVector<double> dt_over_mass;                 // dt/(s_b m), lane layout, s/kg; 0 for held components
  std::set<std::vector<double>> tables;            // dt/(s_b m) by gridpoint and component, of groups with equal blocks
  std::vector<const double*> shared_dt_over_mass;  // by block group, into tables; null: its blocks differ
  std::vector<BodyGroupInertia> of_body_group;

  void bind_body_groups(const Model& model, double time_step);
  void share(const Model& model, double time_step);  // tables of groups whose blocks are congruent
};

}  // namespace quoin
