#include "step/promotion.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <span>

#include "base/error.h"
#include "base/rank_rows.h"
#include "base/ranks.h"
#include "model/fixed_frames.h"
#include "model/world_results.h"
#include "scene/from_bricks.h"
#include "scene/generate_blocks.h"
#include "step/actions/actions.h"
#include "step/actions/ground.h"
#include "step/large_motion_run.h"
#include "step/lattice_motion.h"
#include "step/monitor.h"
#include "step/reactions.h"
#include "step/results.h"
#include "step/set_up.h"
#include "step/stages.h"
#include "step/state.h"
#include "step/work_division.h"

namespace quoin {

using geometry::Matrix;
using geometry::Vector;

namespace {

// Gridpoints of a deformable block of the lattice.
struct GridpointMotion {
  std::vector<Vector> place, displacement, velocity;  // position at the start, m; m; m/s
  std::vector<double> mass;                           // kg
};

GridpointMotion motion_of_gridpoints(const Simulation::Impl& s, int brick) {
  GridpointMotion field;
  s.model.for_each_gridpoint(brick, [&](std::size_t o, double mass) {
    const auto n = static_cast<int>(field.place.size());
    field.place.push_back(geometry::vector(s.model.gridpoint_position(brick, n)));
    field.displacement.push_back(geometry::vector(at_gridpoint(s.lattice.displacement, o)));
    field.velocity.push_back(geometry::vector(at_gridpoint(s.lattice.velocity, o)));
    field.mass.push_back(mass);
  });
  return field;
}

// Kinetic energy of the rigid part, J.
double rigid_kinetic_energy(const GridpointMotion& f, bool symmetry_plane) {
  constexpr std::uint8_t kAlongZ = 4;
  const std::vector<std::uint8_t> held(f.place.size(), symmetry_plane ? kAlongZ : 0);
  const blocks::RigidInertia inertia(f.place, f.mass, held);
  const blocks::Rigid moving = inertia.acceleration(blocks::sum_about(inertia.centre(), f.place, f.velocity, f.mass));
  return 0.5 * dot(inertia.force(moving), moving);
}

// Index of each gridpoint of a brick among those of its block in large motion, by position at the start.
std::vector<std::size_t> gridpoint_order(const Brick& brick, const std::vector<Vector>& place,
                                         const LaneVector<Vector>& reference, const blocks::ModelBlock& block) {
  const auto key = [&](const Vector& x) {
    std::array<long, 3> steps{};
    for (int c = 0; c < 3; ++c)
      steps[at(c)] = std::lround((x[c] - brick.origin[at(c)]) / brick.size[at(c)] * brick.zones[at(c)]);
    return steps;
  };
  std::map<std::array<long, 3>, std::size_t> index;
  for (std::int32_t i = block.first_node; i < block.first_node + block.node_count; ++i)
    index[key(reference[at(i)])] = at(i);
  std::vector<std::size_t> order;
  for (const Vector& x : place) order.push_back(index.at(key(x)));
  return order;
}

// Motion of a rigid block of the lattice: position at the start, displacement, rotation, velocities; m, rad, m/s,
// rad/s.
struct BodyMotion {
  Vec3 centre, displacement, rotation, velocity, spin;
};

// Slip of a point so far, m, where steps have not kept it: the shear displacement less its elastic part. That is the
// law's for slip in one direction, and less for slip to and fro. at_start: slip of joints with damage, m.
// shear_stiffness: of the point while it is elastic, Pa/m.
double slip_so_far(const Simulation::Impl& s, std::int32_t point, double shear_stiffness, double at_start) {
  constexpr double kRounding = 1e-9;  // of the shear displacement, which is elastic if no more is left
  const Vec3 jump = jump_at_traction(s, point);
  const double whole = std::hypot(jump[1], jump[2]);
  const double traction = std::hypot(s.lattice.traction[1][at(point)], s.lattice.traction[2][at(point)]);
  const double slip = whole - traction / shear_stiffness;
  return at_start + (slip > kRounding * whole ? slip : 0.0);
}

// Contact points of the lattice with tractions and states.
std::vector<blocks::PointHistory> histories_of(Simulation::Impl& s) {
  std::vector<blocks::PointHistory> histories;
  for (std::int32_t i = 0; i < s.model.point_count; ++i) {
    const auto p = at(i);
    const Model::Sides sides = s.model.sides_of(i);
    blocks::PointHistory& h = histories.emplace_back();
    h.block_a = sides.a;
    h.block_b = sides.b;
    h.position = geometry::vector(s.model.point_position[p]);
    const int n = s.model.point_axis[p];
    h.s[(n + 1) % 3] = h.t[(n + 2) % 3] = 1.0;
    const double shift = s.lattice.normal_shift.empty() ? 0.0 : s.lattice.normal_shift[p];
    h.opening = jump_of(s, i, 1.0, 0.0)[0] + shift;
    h.opening_at_traction = opening_at_traction(s, i);
    const Vec3 pending = jump_of(s, i, 0.0, s.data.time_step);
    h.slip = {pending[1], pending[2]};
    h.traction = {s.lattice.traction[0][p], s.lattice.traction[1][p], s.lattice.traction[2][p]};
    for (std::size_t f = 0; f < s.model.families.size(); ++f) {
      const ContactFamily& family = s.model.families[f];
      const auto k = static_cast<std::int32_t>(i - family.first_point);
      if (k < 0 || k >= family.point_count) continue;
      const quoin_law& law = family.material->api();
      for (std::size_t state = 0; state < law.state_count; ++state)
        h.state.push_back(s.lattice.law_state[f][state * at(family.point_count) + at(k)]);
      const int slip = family.material->law().state_index("slip");
      if (slip >= 0 && !keeps_state(s, law, at(slip)))
        h.state[at(slip)] =
            slip_so_far(s, i, stiffness_bounds_at(*family.material, family.columns, at(k)).shear, h.state[at(slip)]);
      for (const PropertyColumn& c : family.columns) h.properties.push_back(c.values[at(k)]);
    }
  }
  return histories;
}

}  // namespace

// v M' v/2 less v M v/2 (model/rigid_motion.h). All ranks call it together.
double added_kinetic_energy(const Simulation::Impl& s) {
  const double s_b = s.inertia.in_use.deformation, s_u = s.inertia.in_use.unit;
  if (s_b == 1.0 && s_u == 1.0) return 0.0;
  const bool halved = s.model.assembly.symmetry_plane_z0;
  std::vector<double> added(s.model.unit_groups.size(), 0.0);
  for (std::size_t u = 0; u < added.size(); ++u) {
    if (s.ranks && !s.division.share.owns_item(static_cast<int>(u), s.ranks->rank())) continue;
    const UnitGroup& unit = s.model.unit_groups[u];
    const BlockGroup& first = s.model.groups[at(unit.first_group)];
    for (int lane = 0; lane < first.block_count; ++lane) {
      GridpointMotion whole;
      double all = 0.0, blocks = 0.0;
      for (int g = unit.first_group; g < unit.first_group + unit.group_count; ++g) {
        const GridpointMotion f = motion_of_gridpoints(s, s.model.groups[at(g)].block[at(lane)]);
        for (std::size_t i = 0; i < f.place.size(); ++i) all += 0.5 * f.mass[i] * dot(f.velocity[i], f.velocity[i]);
        blocks += rigid_kinetic_energy(f, halved);
        whole.place.insert(whole.place.end(), f.place.begin(), f.place.end());
        whole.velocity.insert(whole.velocity.end(), f.velocity.begin(), f.velocity.end());
        whole.mass.insert(whole.mass.end(), f.mass.begin(), f.mass.end());
      }
      added[u] += (s_b - 1.0) * (all - blocks);
      if (unit.group_count > 1) added[u] += (s_u - 1.0) * (blocks - rigid_kinetic_energy(whole, halved));
    }
  }
  all_gather(s.ranks, std::span(added), [&s](std::size_t u) { return s.division.share.rank_of_item[u]; });
  return std::accumulate(added.begin(), added.end(), 0.0);
}

void promote(Simulation::Impl& s, const std::string& why, int stage) {
  if (s.scene.solver.selective_time_step > 0.0)  // before the lattice is changed
    throw Error(Exit::numerical,
                fmt::format("step {} of stage '{}': {}, and large motion, in which the run would go on, takes no "
                            "solver.selective_time_step; make that smaller than {:g} s, use mass_scaling, or choose "
                            "solver.large_motion = \"never\"",
                            s.progress.stage_step, current_stage(s).name, why, s.scene.solver.selective_time_step));
  constexpr double kLost = 1e6;  // diagonals of the model; squares of distances overflow far beyond
  if (!(s.small_motion.seen.translation <= kLost))
    throw Error(Exit::numerical, fmt::format("step {} of stage '{}': {}; check the velocities and forces of the stage, "
                                             "or reduce solver.time_step_fraction",
                                             s.progress.stage_step, current_stage(s).name, why));
  Promotion promotion{why, stage, s.progress.step, time_now(s), 0.0, 0.0};
  const double dt = s.data.time_step;

  // Data of the lattice, before it is removed.
  const std::vector<blocks::PointHistory> histories = histories_of(s);
  const std::size_t count = s.model.assembly.bricks.size();
  std::vector<GridpointMotion> fields(count);
  std::vector<BodyMotion> bodies(count);
  for (std::size_t b = 0; b < count; ++b) {
    const int body = s.model.place[b].body;
    if (body < 0) {
      fields[b] = motion_of_gridpoints(s, static_cast<int>(b));
    } else {
      bodies[b] = {s.model.bodies[at(body)].centre, s.lattice.of_body(body, &BodyLanes::displacement),
                   s.lattice.of_body(body, &BodyLanes::rotation), s.lattice.of_body(body, &BodyLanes::velocity),
                   s.lattice.of_body(body, &BodyLanes::spin)};
    }
  }
  std::vector<Drive> continued = std::move(s.actions.drives);  // blocks keep their indices

  // The same blocks in large motion: built at rest, then moved to their current positions.
  leave_lattice(s);
  blocks::Model& m = *s.large_motion;
  m.stepping.time = promotion.time, m.stepping.count = s.progress.step;
  for (const Drive& drive : continued)
    m.prescribe(drive.block, {}, {}, drive.held);  // at rest: supports take no motion
  for (std::size_t b = 0; b < count; ++b) {
    const int i = static_cast<int>(b);
    const blocks::ModelBlock& block = m.blocks[i];
    if (block.body < 0) {
      const auto order = gridpoint_order(s.left->bricks[b], fields[b].place, m.nodes.reference, block);
      LaneVector<Vector>& x = change_node_positions(m);  // velocities change with them
      for (std::size_t n = 0; n < order.size(); ++n) {
        x[order[n]] = m.nodes.reference[order[n]] + fields[b].displacement[n];
        m.nodes.v[order[n]] = fields[b].velocity[n];
      }
    } else {
      const BodyMotion& body = bodies[b];
      set_pose(m, i, geometry::vector(body.centre) + geometry::vector(body.displacement),
               geometry::rotation(geometry::vector(body.rotation)));
      m.set_velocity(i, geometry::vector(body.velocity), geometry::vector(body.spin));
    }
  }
  m.frames.fixed.assign(m.blocks.size(), 1);  // displacements are small ones so far, of all blocks
  promotion.strain_energy = strain_energy(m);
  begin_with_fixed_frames(m);
  promotion.energy_jump = strain_energy(m) - promotion.strain_energy;
  adopt_histories(m, histories);

  m.set_gravity(geometry::vector(s.data.gravity));  // of which the forces on held blocks are computed below
  s.actions.drives = std::move(continued);
  const Stage& settings = current_stage(s);
  if (const SolverSettings& solver = solver_in_use(s); &solver != &s.scene.solver) {
    const double booked = m.step_sums.later.detection;
    m.set_solver(solver);
    m.step_sums.later.detection = booked;  // no inertia is lost: the lattice had that of these settings
  }
  follow_time_step(s);
  s.progress.stage_start = promotion.time - static_cast<double>(s.progress.stage_step) * dt;
  watch_blocks(s, settings);
  bind_floors(s);
  s.controls.settled = false;  // the next step applies the controls of the stage to these blocks
  s.progress.row_interval =
      std::max(1L, std::lround(static_cast<double>(s.progress.row_interval) * dt / s.data.time_step));
  s.outcome.promotion = promotion;
  s.watch.pending = false;  // energies of the lattice are computed differently: no comparison with them
  partition_work(s);        // pieces and monitored blocks have changed
}

void leave_lattice(Simulation::Impl& s) {
  std::vector<std::shared_ptr<const Material>> materials;
  for (const ContactFamily& family : s.model.families) materials.push_back(family.material);
  s.left = std::move(s.model.assembly);
  Assembly families_alone;
  families_alone.families = s.left->families;
  families_alone.symmetry_factor = s.left->symmetry_factor;
  take_bricks(s, std::move(families_alone), materials);
  blocks::Assembly shapes = blocks::from_bricks(*s.left);
  if (s.scene.blocks) {  // a lattice found among blocks: pairs that meet later follow the rules of the scene
    blocks::Assembly given = blocks::assemble(s.scene);
    shapes.family_of = std::move(given.family_of);
    for (std::size_t i = 0; i < shapes.blocks.size(); ++i) shapes.blocks[i].fixed = given.blocks[i].fixed;
    mark_freed_blocks(s.scene, &shapes);
  }
  build_large_motion(s, shapes, materials);
  find_restraints(s);
  bind_step(s);
}

void return_to_lattice(Simulation::Impl& s) {
  std::vector<std::shared_ptr<const Material>> materials;
  for (const ContactFamily& family : s.model.families) materials.push_back(family.material);
  s.large_motion.reset();
  s.actions.drives.clear(), s.monitor.blocks = {};
  s.outcome.collapse_multiplier.reset(), s.outcome.base_slip_at_uplift.reset();
  take_bricks(s, std::move(*s.left), materials);
  s.left.reset();
  find_base_of_lattice(s);
  find_restraints(s);
  bind_step(s);
}

}  // namespace quoin
