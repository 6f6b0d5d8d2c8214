// The table of arrays that change in a run of bricks on the lattice (model/fields.h): one line each. In large motion
// they are empty.
#pragma once

#include "model/fields.h"
#include "step/state/lattice_state.h"

namespace quoin {

// visit(field, array, joint family of its contact points; -1: all families).
template <class State, class Visit>  // State: LatticeState, const or not
void each_lattice_field(State& lattice, const Visit& visit) {
  constexpr std::size_t kWhole = sizeof(double);
  visit(Field{Owner::body, "rigid_body"}.in_hash(sizeof(BodyLanes)).in(Part::row).on_all_ranks(), lattice.bodies, -1);
  visit(Field{Owner::gridpoint, "displacement"}.in_hash(kWhole), lattice.displacement, -1);
  visit(Field{Owner::gridpoint, "velocity"}.in_hash(kWhole), lattice.velocity, -1);
  for (auto& column : lattice.traction) visit(Field{Owner::contact_point, "traction"}.in_hash(kWhole), column, -1);
  for (std::size_t f = 0; f < lattice.law_state.size(); ++f)
    visit(Field{Owner::contact_point, "state"}.in_hash(kWhole), lattice.law_state[f], static_cast<int>(f));
  visit(Field{Owner::contact_point, "normal_shift"}.only(When::after_law_swaps), lattice.normal_shift, -1);
  constexpr When kDamped = When::with_stiffness_damping;
  for (auto& column : lattice.viscous) visit(Field{Owner::contact_point, "viscous_traction"}.only(kDamped), column, -1);
  visit(Field{Owner::contact_point, "jump_before"}.only(kDamped), lattice.old_jump, -1);
  visit(Field{Owner::contact_point, "flags"}.not_saved(), lattice.flags, -1);
}

}  // namespace quoin
