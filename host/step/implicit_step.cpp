#include "step/implicit_step.h"

#include <algorithm>

#include "step/state.h"

namespace quoin {

void weigh_chunk(Simulation::Impl& s, int index, const ChunkJumps& jump, const double* normal_way) {
  const ContactChunk& chunk = s.model.chunks[static_cast<std::size_t>(index)];
  const ContactFamily& family = s.model.families[static_cast<std::size_t>(chunk.family)];
  const auto first = static_cast<std::size_t>(chunk.first_point);
  ImplicitContacts::Chunk c{};
  c.viscosity = s.time_step.impacts.viscosity[static_cast<std::size_t>(chunk.family)];
  for (std::size_t k = 0; k < 3; ++k) {
    c.traction[k] = s.lattice.traction[k].data() + first, c.old_traction[k] = jump.old_traction[k];
    if (c.viscosity[0] > 0.0) c.viscous[k] = s.lattice.viscous[k].data() + first;
  }
  c.way[0] = normal_way, c.way[1] = jump.slip_s, c.way[2] = jump.slip_t;
  c.area = s.model.area.data() + first;
  c.normal_stiffness = family.normal_stiffness, c.shear_stiffness = family.shear_stiffness;
  s.contacts.implicit.weigh(chunk, c, s.data.time_step);
  if (c.viscosity[0] == 0.0) std::copy_n(jump.normal, chunk.point_count, s.lattice.old_jump.data() + first);
}

// Completes the velocities of the gridpoints of prescribed bodies: a step writes only those across joints.
void settle_contacts(Simulation::Impl& s) {
  for (std::size_t b = 0; b < s.model.bodies.size(); ++b) {
    const Vec3 moves = s.lattice.of_body(static_cast<int>(b), &BodyLanes::velocity);
    for (const std::int32_t slave : s.model.bodies[b].slave) {
      for (std::size_t c = 0; c < 3; ++c) s.lattice.velocity[static_cast<std::size_t>(slave) + c * kLanes] = moves[c];
    }
  }
  auto settle = [&](int, int piece) { s.contacts.implicit.settle(piece, s.data); };
  s.pool.for_each(s.contacts.implicit_end, settle);
}

}  // namespace quoin
