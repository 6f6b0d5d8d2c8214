// What a step does with joints that act by its mean (implicit_contacts.h).
#include <algorithm>

#include "step/state.h"

namespace quoin {

void Simulation::Impl::weigh_chunk(int index, const ChunkJumps& jump, const double* normal_way) {
  const ContactChunk& chunk = model.chunks[static_cast<std::size_t>(index)];
  const ContactFamily& family = model.families[static_cast<std::size_t>(chunk.family)];
  const auto first = static_cast<std::size_t>(chunk.first_point);
  ImplicitContacts::Chunk c{};
  c.viscosity = time_step.impacts.viscosity[static_cast<std::size_t>(chunk.family)];
  for (std::size_t k = 0; k < 3; ++k) {
    c.traction[k] = traction[k].data() + first, c.old_traction[k] = jump.old_traction[k];
    if (c.viscosity[0] > 0.0) c.viscous[k] = viscous[k].data() + first;
  }
  c.way[0] = normal_way, c.way[1] = jump.slip_s, c.way[2] = jump.slip_t;
  c.area = model.area.data() + first;
  c.normal_stiffness = family.normal_stiffness, c.shear_stiffness = family.shear_stiffness;
  implicit_contacts.weigh(chunk, c, data.time_step);
  if (c.viscosity[0] == 0.0) std::copy_n(jump.normal, chunk.point_count, old_jump.data() + first);
}

// Gridpoints of bodies that move as prescribed have velocities across their joints alone until here.
void Simulation::Impl::settle_contacts() {
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const Vec3 moves = of_body(static_cast<int>(b), &BodyLanes::velocity);
    for (const std::int32_t slave : model.bodies[b].slave) {
      for (std::size_t c = 0; c < 3; ++c) velocity[static_cast<std::size_t>(slave) + c * kLanes] = moves[c];
    }
  }
  auto settle = [&](int, int piece) { implicit_contacts.settle(piece, data); };
  pool.for_each(implicit_end, settle);
}

}  // namespace quoin
