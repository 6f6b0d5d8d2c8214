// Inertia of the lattice in the time step in use, of what this rank holds. Written when a time step is chosen and when
// blocks are dealt out; it follows from the model.
#pragma once

#include <set>
#include <vector>

#include "model/model.h"
#include "model/time_step.h"
#include "step/rigid_bodies.h"

namespace quoin {

struct LatticeInertia {
  Inertia in_use;
  LaneVector<double> dt_over_mass;                 // lane layout, s/kg; 0 for held components
  std::set<std::vector<double>> tables;            // tables of groups whose blocks share them
  std::vector<const double*> shared_dt_over_mass;  // by block group, into tables; null: its blocks differ
  std::vector<BodyGroupInertia> of_body_group;

  void bind_body_groups(const Model& model, double time_step);
  void share(const Model& model, double time_step);  // where the blocks of a group are congruent
};

}  // namespace quoin
