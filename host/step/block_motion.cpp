#include "step/block_motion.h"

#include <algorithm>

#include "members/members.h"
#include "model/world_results.h"
#include "scene/generate_blocks.h"
#include "step/gather.h"
#include "step/lattice_motion.h"
#include "step/reactions.h"

namespace quoin {

using geometry::Vector;

namespace {

// A quantity of a rigid brick, or the mean by mass of that of gridpoints.
Vector of_brick(const Simulation::Impl& s, int block, BodyLanes::Quantity BodyLanes::*of_body,
                const LaneVector<double>& of_gridpoints) {
  if (const int body = s.model.place[at(block)].body; body >= 0)
    return geometry::vector(s.lattice.of_body(body, of_body));
  Vector sum;
  double whole = 0.0;
  s.model.for_each_gridpoint(block, [&](std::size_t offset, double mass) {
    whole += mass;
    for (int c = 0; c < 3; ++c) sum[c] += mass * of_gridpoints[offset + at(c) * kLanes];
  });
  return sum / whole;
}

}  // namespace

std::vector<int> blocks_named(const Simulation::Impl& s, const std::string& name, const std::string& where) {
  return s.large_motion ? blocks::find_blocks(s.large_motion->assembly, name, where) : s.model.blocks_named(name);
}

const members::Members* members_of(const Simulation::Impl& s) {
  return s.large_motion ? s.large_motion->held_by.members.get() : nullptr;
}

std::span<const members::Bed> beds_of(const Simulation::Impl& s) {
  const members::Members* const members = members_of(s);
  return members ? std::span(members->beds()) : std::span<const members::Bed>();
}

const std::vector<int>& shown_blocks(const Simulation::Impl& s) {
  return s.controls.floors.empty() ? s.monitor.blocks : s.controls.floors.back();
}

Vector displacement_of(const Simulation::Impl& s, int block) {
  if (s.large_motion) return moved_by_now(*s.large_motion, block);
  return of_brick(s, block, &BodyLanes::displacement, s.lattice.displacement);
}

Vector velocity_of(const Simulation::Impl& s, int block) {
  if (s.large_motion) return velocity_of(*s.large_motion, block);
  return of_brick(s, block, &BodyLanes::velocity, s.lattice.velocity);
}

Vector spin_of(const Simulation::Impl& s, int block) {
  if (s.large_motion) return spin_of(*s.large_motion, block);
  const int body = s.model.place[at(block)].body;
  return body < 0 ? Vector{} : geometry::vector(s.lattice.of_body(body, &BodyLanes::spin));
}

Vec3 displacement_now(const Simulation::Impl& s, const std::vector<int>& blocks) {
  Vector mean;
  for (const int block : blocks) mean += displacement_of(s, block) / static_cast<double>(blocks.size());
  return geometry::array(mean);
}

Vec3 displacement_at_forces(const Simulation::Impl& s, const std::vector<int>& blocks) {
  Vector mean = geometry::vector(displacement_now(s, blocks));
  for (const int block : blocks) mean -= s.data.time_step * velocity_of(s, block) / static_cast<double>(blocks.size());
  return geometry::array(mean);
}

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
  const int body = s.model.place[at(block)].body;
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
  const int body = s.model.place[at(block)].body;
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
  const int body = s.model.place[at(block)].body;
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
