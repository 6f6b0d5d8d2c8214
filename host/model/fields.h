// The table of all arrays that change in a run, each with its description. Checkpoints and state hashes are loops over
// it. So is what ranks gather, exchange and release, and what new contact points inherit. No other list of arrays
// exists. Fields of the lattice are in step/lattice_fields.h. Single numbers, which only checkpoints have, are listed
// there.
#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>

#include "model/field.h"
#include "model/world.h"

namespace quoin::blocks {

struct WorldFields {
  // visit(field, array).
  template <class World, class Visit>
  static void of_blocks(World& w, const Visit& visit) {
    constexpr auto nothing = Part::nothing;
    constexpr std::size_t kMotion = offsetof(Body, omega);  // place, orientation, velocity, angular momentum
    const Field place{Owner::gridpoint, "position"}, velocity{Owner::gridpoint, "velocity"};
    visit(Field{Owner::body, "rigid_body"}.in_hash(kMotion).in(Part::motion), w.bodies);
    visit(place.in_hash(sizeof(Vector)).in(Part::motion), w.nodes.x);
    visit(velocity.in_hash(sizeof(Vector)).in(Part::motion), w.nodes.v);
    visit(Field{Owner::block, "frame"}.in(Part::motion), w.frames.frame);
    visit(Field{Owner::gridpoint, "held"}.in(nothing), w.nodes.held);
    visit(Field{Owner::gridpoint, "held_velocity"}.in(nothing), w.nodes.held_v);
    visit(Field{Owner::block, "contact_force"}.in(Part::sums), w.step_sums.contact_force);
    visit(Field{Owner::block, "apart"}.in(nothing).on_all_ranks(), w.units.apart);
    visit(Field{Owner::block, "by_zone"}.in(nothing).on_all_ranks(), w.frames.by_zone);
    visit(Field{Owner::block, "fixed_frame"}.in(nothing).on_all_ranks(), w.frames.fixed);
    visit(Field{Owner::block, "pose_at_broad_phase"}.in(nothing), w.poses.broad);
    visit(Field{Owner::block, "next_look"}.in(nothing).only(When::after_checks), w.checks.block);
    visit(Field{Owner::body, "seen_motion"}.in(nothing).only(When::after_checks), w.checks.assumed);
  }

  // Fields of each pair within the skin.
  template <class World, class Visit>
  static void of_pairs(World& w, const Visit& visit) {
    visit(Field{Owner::pair, "place"}.in(Part::nothing), w.contacts.place);
    visit(Field{Owner::pair, "look"}.in(Part::nothing), w.checks.pair);
  }

  // Fields of the contact points of a family, or of several side by side: visit(field, array of each).
  template <class Visit, class First, class... Others>
  static void of_points(const Visit& visit, First& f, Others&... g) {
    constexpr auto damped = When::with_stiffness_damping, energies = When::with_energies;
    const auto field = [](const char* name) { return Field{Owner::contact_point, name}; };
    const auto each = [&](const Field& of, auto&... columns) {
      for (std::size_t k = 0; k < std::min({std::size(columns)...}); ++k) visit(of, columns[k]...);
    };
    const Field point{Owner::contact_point, "point"};  // steps change only points with one deformable side
    visit(point.in(Part::nothing), f.point, g.point...);
    each(field("slid"), f.slid, g.slid...);
    visit(field("normal_jump").in(Part::row), f.normal_jump, g.normal_jump...);
    each(field("slip"), f.slip, g.slip...);
    each(field("traction").in_hash(sizeof(double)).in(Part::row), f.traction, g.traction...);
    each(field("state").in_hash(sizeof(double)), f.state, g.state...);
    for (std::size_t k = 0; k < f.columns.size(); ++k)
      visit(field("property").in(Part::nothing).on_all_ranks(), f.columns[k].values, g.columns[k].values...);
    each(field("traction_before").only(damped), f.old_traction, g.old_traction...);
    visit(field("jump_before").only(damped), f.old_jump, g.old_jump...);
    visit(field("stored").only(energies), f.stored, g.stored...);
    each(field("dissipated").only(energies), f.dissipated, g.dissipated...);
    each(field("viscous_traction").only(damped).in(Part::row), f.viscous, g.viscous...);
    each(field("maxwell_traction").only(When::with_maxwell), f.maxwell, g.maxwell...);
  }

  // Visits all fields.
  template <class World, class Visit>
  static void each(World& w, const Visit& visit) {
    of_blocks(w, visit);
    for (auto& family : w.contacts.families) of_points(visit, family);
    visit(Field{Owner::facet, "facet"}.in(Part::nothing), w.contacts.facets);
    of_pairs(w, visit);
  }
};

}  // namespace quoin::blocks
