#include "step/driven_block.h"

#include <algorithm>

#include "model/world_results.h"
#include "step/gather.h"
#include "step/lattice_motion.h"
#include "step/reactions.h"

namespace quoin {

using geometry::Vector;

namespace {

// A rigid body of the lattice in its lanes.
struct BodyLane {
  BodyLanes& lanes;
  int lane;
};

BodyLane lane_of(Simulation::Impl& s, int body) {
  const auto [index, lane] = s.lattice.place[at(body)];
  return {s.lattice.bodies[at(index)], lane};
}

// Rigid body of a brick; -1: it is deformable.
int body_of_brick(const Simulation::Impl& s, int block) { return s.model.place[at(block)].body; }

}  // namespace

const std::string& name_in_stages(const Simulation::Impl& s, int block) {
  return s.large_motion ? s.large_motion->assembly.blocks[at(block)].name_in_stages()
                        : s.model.assembly.bricks[at(block)].body;
}

bool is_rigid(const Simulation::Impl& s, int block) {
  return s.large_motion ? s.large_motion->blocks[block].body >= 0 : s.model.assembly.bricks[at(block)].rigid;
}

bool is_fixed(const Simulation::Impl& s, int block) {
  if (s.large_motion) return s.large_motion->assembly.blocks[at(block)].fixed;
  return s.model.assembly.bricks[at(block)].fixed && is_rigid(s, block);
}

Vector net_force(const Simulation::Impl& s, int block) {
  if (const auto& m = s.large_motion)
    return m->step_sums.contact_force[block] + m->blocks[block].mass * m->actions.gravity + load_on(*m, block);
  const int body = body_of_brick(s, block);
  const Vector weight = s.model.bodies[at(body)].mass * geometry::vector(s.data.gravity);
  return geometry::vector(joint_wrench(s, block).force) + weight +
         geometry::vector(s.lattice.of_body(body, &BodyLanes::applied_force));
}

Vector net_moment(const Simulation::Impl& s, int block) {
  if (!s.large_motion) return geometry::vector(joint_wrench(s, block).moment);
  const blocks::Model& m = *s.large_motion;
  const JointWrench joints =
      s.parts.divided && !has_all(s) ? s.reactions.wrench[at(block)] : sum_large_motion_wrenches(s, {block}).front();
  const Vector centre = position_of(m, block);
  Vector moment =
      geometry::vector(joints.moment) + cross(geometry::vector(joints.centre) - centre, geometry::vector(joints.force));
  if (is_rigid(s, block)) return moment + loads_on_body(m, block).torque;
  each_load_on_gridpoints(
      m, block, [&](std::int32_t node, const Vector& force) { moment += cross(m.nodes.x[at(node)] - centre, force); });
  return moment;
}

void prescribe(Simulation::Impl& s, int block, const Vector& velocity, const Vector& omega, std::uint8_t held) {
  if (s.large_motion) return s.large_motion->prescribe(block, velocity, omega, held);
  const int body = body_of_brick(s, block);
  if (body < 0) return;
  const auto [lanes, lane] = lane_of(s, body);
  for (std::size_t c = 0; c < 3; ++c) {
    const double holds = held >> c & 1, holds_turn = held >> (c + 3) & 1;
    const double linear =
        0.5 * s.inertia.in_use.body_mass[at(body)] * lanes.velocity[c][lane] * lanes.velocity[c][lane];
    const double angular = 0.5 * s.inertia.in_use.body_inertia[at(body)][c] * lanes.spin[c][lane] * lanes.spin[c][lane];
    s.energy.external +=
        (lanes.prescribed[c][lane] - holds) * linear + (lanes.prescribed[c + 3][lane] - holds_turn) * angular;
    lanes.prescribed[c][lane] = holds, lanes.prescribed[c + 3][lane] = holds_turn;
    lanes.prescribed_velocity[c][lane] = velocity[static_cast<int>(c)];
    if (holds_turn != 0.0) lanes.spin[c][lane] = omega[static_cast<int>(c)];
  }
  lanes.any_prescribed |= held != 0;
}

void apply_force(Simulation::Impl& s, int block, const Vector& force, const Vector& moment) {
  if (s.large_motion) return s.large_motion->apply_force(block, force, moment);
  const int body = body_of_brick(s, block);
  if (body < 0) return s.controls.load_brick(s.model, block, geometry::array(force));
  const auto [lanes, lane] = lane_of(s, body);
  for (std::size_t c = 0; c < 3; ++c) {
    lanes.applied_force[c][lane] = force[static_cast<int>(c)];
    lanes.applied_moment[c][lane] = moment[static_cast<int>(c)];
  }
}

void remove_forces(Simulation::Impl& s) {
  if (s.large_motion) {
    s.large_motion->actions.applied.clear();
    s.large_motion->actions.loaded.assign(s.large_motion->blocks.size(), 0);
  }
  for (BodyLanes& lanes : s.lattice.bodies) {
    for (auto* applied : {&lanes.applied_force, &lanes.applied_moment}) std::fill_n(&(*applied)[0][0], 3 * kLanes, 0.0);
  }
  std::fill(s.controls.load.begin(), s.controls.load.end(), 0.0);
}

}  // namespace quoin
