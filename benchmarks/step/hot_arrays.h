// The arrays that every step reads or writes, with their sizes.
#pragma once

#include <cstddef>
#include <vector>

#include "step/state.h"

namespace quoin {

// An array that every step reads or writes.
enum class HotOf { block, rigid_body, contact_point };
struct HotArray {
  const char* what;
  HotOf of;
  std::size_t bytes;  // size of the whole array
};

inline std::vector<HotArray> hot_arrays(const Simulation::Impl& s) {
  const Model& model = s.model;
  const std::size_t lanes = at(model.block_line_count) * kLine * sizeof(double), points = at(model.point_count);
  std::size_t own_inertia = 0, state_columns = 0;
  for (std::size_t g = 0; g < model.groups.size(); ++g) {
    const auto t = at(model.groups[g].brick_template);
    if (!s.inertia.shared_dt_over_mass[g]) own_inertia += at(model.templates[t].node_count) * kLine * sizeof(double);
  }
  struct Slots {
    std::size_t all = 0, scattered = 0;
  } of_blocks, of_bodies;
  const auto count_slots = [&](int first, int count, Slots* slots) {
    for (int i = first; i < first + count; ++i) {
      const std::int32_t run = model.slot_run[at(i)];
      ++slots->all;
      if (run == -1) ++slots->scattered;
    }
  };
  for (const BlockGroup& group : model.groups)
    count_slots(group.first_slot, model.slots[at(group.brick_template)].slot_count(), &of_blocks);
  for (const BodyGroup& group : model.body_groups)
    count_slots(group.first_slot, model.body_slots[at(group.slots)].slot_count(), &of_bodies);
  std::size_t driven_groups = 0;
  for (const BodyLanes& body : s.lattice.bodies) driven_groups += body.any_prescribed ? 1 : 0;
  for (const BoundCall& call : s.contacts.calls) {
    for (const quoin_out& column : call.state_new) state_columns += column.data ? call.batch.count : 0;
  }
  const std::size_t quantity = sizeof(BodyLanes::Quantity), body_records = s.lattice.bodies.size();
  return {
      {"displacement of gridpoints", HotOf::block, lanes},
      {"velocity of gridpoints", HotOf::block, lanes},
      {"inertia, where blocks of a group differ", HotOf::block, own_inertia},
      {"where slots find their points in a row", HotOf::block, of_blocks.all * sizeof(std::int32_t)},
      {"where other slots find their points", HotOf::block, of_blocks.scattered * kLanes * sizeof(std::int32_t)},
      {"displacement, rotation, velocity, spin", HotOf::rigid_body, 4 * quantity * body_records},
      {"applied force", HotOf::rigid_body, quantity * body_records},
      {"prescribed velocity, where bodies are driven", HotOf::rigid_body, 3 * quantity * driven_groups},
      {"mass, dt over inertia", HotOf::rigid_body, 7 * kLanes * sizeof(double) * s.inertia.of_body_group.size()},
      {"gridpoints: displacement along the normal, velocity across", HotOf::rigid_body,
       of_bodies.all * kLine * sizeof(double)},
      {"where slots find their points in a row", HotOf::rigid_body, of_bodies.all * sizeof(std::int32_t)},
      {"where other slots find their points", HotOf::rigid_body, of_bodies.scattered * kLanes * sizeof(std::int32_t)},
      {"offsets of the two gridpoints", HotOf::contact_point, 2 * points * sizeof(std::int32_t)},
      {"gridpoints in a row from here on", HotOf::contact_point, points * sizeof(std::uint8_t)},
      {"area", HotOf::contact_point, points * sizeof(double)},
      {"traction", HotOf::contact_point, 3 * points * sizeof(double)},
      {"force", HotOf::contact_point, 3 * points * sizeof(double)},
      {"state of the law", HotOf::contact_point, state_columns * sizeof(double)}};
}

}  // namespace quoin
