#include "step/rest.h"

#include <fmt/format.h>

#include "base/error.h"
#include "step/state.h"

#ifdef QUOIN_REST
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "model/world_results.h"
#include "sparse/sparse_cholesky.h"
#include "step/block_motion.h"
#include "step/controls.h"
#include "step/findings.h"
#include "step/lattice_step.h"
#include "step/measure.h"
#include "step/results.h"
#include "step/step.h"
#include "step/supports.h"
#include "step/unknowns.h"
#include "step/work_division.h"
#endif

namespace quoin {

#ifdef QUOIN_REST
namespace {

using Eigen::VectorXd;
using geometry::Vector;

// Most iterations, and the unbalanced ratio that ends them over that of the stage, which its steps check.
constexpr int kMostIterations = 100;
constexpr double kOfWanted = 1e-2;
// Least stiffness of open and of sliding points, over that of closed ones: enough for a regular matrix, too little to
// carry load.
constexpr double kOpen = 1e-6, kSlides = 1e-3;
// In the first iteration these points keep all of their stiffness. An iteration that has lowered the unbalanced ratio
// multiplies the share by kSofter, any other by kStiffer. Too stiff a system moves blocks too little; too soft a one
// moves them without bound.
constexpr double kSofter = 1.0 / 3.0, kStiffer = 10.0;
// Stiffness added to every unknown, over the largest entry of the matrix: it keeps the factor regular.
constexpr double kHeld = 1e-12;
// Displacement in an iteration, over the diagonal of the model, beyond which a block has no support.
constexpr double kFlies = 0.1;

class Search {
 public:
  explicit Search(Simulation::Impl& impl) : s_(impl) {
    apply_controls(s_);  // supports and full loads: a stage of rest has no ramp
    unknowns_.emplace(impl);
  }

  void run(double wanted, const std::function<bool()>& stop_requested) {
    VectorXd none = VectorXd::Zero(static_cast<Eigen::Index>(unknowns_->count()));
    move(none);
    std::unique_ptr<SparseCholesky> factor;
    std::vector<std::uint8_t> factored;  // states of the points in `factor`
    double last = std::numeric_limits<double>::infinity(), best = last, factored_with = 0.0, kept = 1.0;
    for (int i = 0; i < kMostIterations; ++i) {
      if (stop_requested())
        throw Error(Exit::interrupted, fmt::format("stopped in the search for the state of rest of stage '{}'",
                                                   s_.scene.stages[at(s_.progress.stage)].name));
      const std::vector<ContactPoint> points = contact_points(s_);
      if (points.empty()) return;
      const VectorXd rest = out_of_balance(points);
      const double ratio = ratio_of(rest, points);
      if (!std::isfinite(ratio) || ratio <= kOfWanted * wanted || ratio > kDiverges * best) return;
      if (i > 0) kept = ratio < last ? kept * kSofter : std::min(1.0, kept * kStiffer);
      last = ratio, best = std::min(best, ratio);
      std::vector<std::uint8_t> states = states_of(points);
      const bool all_closed = std::all_of(states.begin(), states.end(), [](std::uint8_t s) { return s == closed; });
      if (!factor || states != factored || (!all_closed && kept != factored_with)) {
        factor = std::make_unique<SparseCholesky>(stiffness_of(points, states, kept), unknowns_->groups());
        factored = std::move(states), factored_with = kept;
      }
      Eigen::MatrixXd moved = rest;
      factor->solve(moved);
      require_held(moved);
      move(moved.col(0));
    }
  }

 private:
  // Ratio over the best one so far beyond which iterations diverge: steps of the stage continue from there.
  static constexpr double kDiverges = 1e3;
  enum State : std::uint8_t { closed, slides, open };

  // ---- Forces ----------------------------------------------------------------------------------------------------

  static void add_to(VectorXd* sum, const std::array<int, 3>& unknown, const Vector& force) {
    for (int c = 0; c < 3; ++c)
      if (unknown[at(c)] >= 0) (*sum)(unknown[at(c)]) += force[c];
  }

  VectorXd out_of_balance(const std::vector<ContactPoint>& points) {
    VectorXd sum = VectorXd::Zero(static_cast<Eigen::Index>(unknowns_->count()));
    s_.large_motion ? add_large_motion_loads(&sum) : add_lattice_loads(&sum);
    add_contacts(points, &sum);
    return sum;
  }

  void add_zones(int b, VectorXd* sum) const {
    const Unknowns::OfBlock& u = unknowns_->blocks()[at(b)];
    each_stressed_zone(s_, b, [&](const StressedZone& zone) {
      for (std::size_t i = 0; i < 4; ++i)
        add_to(sum, u.gridpoint[at(zone.node[i])], -zone.volume * (zone.stress * zone.gradient[i]));
    });
  }

  void add_large_motion_loads(VectorXd* sum) const {
    const blocks::Model& m = *s_.large_motion;
    const Vector g = geometry::vector(s_.data.gravity);
    for (int b = 0; b < static_cast<int>(unknowns_->blocks().size()); ++b) {
      const Unknowns::OfBlock& u = unknowns_->blocks()[at(b)];
      const blocks::ModelBlock& block = m.blocks[b];
      if (u.rigid) {
        const blocks::Wrench loads = loads_on_body(m, b);
        add_to(sum, {u.body[0], u.body[1], u.body[2]}, block.mass * g + loads.force);
        add_to(sum, {u.body[3], u.body[4], u.body[5]}, loads.torque);
        continue;
      }
      double inertia = 0.0;  // mass over which weight and forces are distributed to its gridpoints, kg
      for (std::size_t n = 0; n < u.gridpoint.size(); ++n) inertia += m.nodes.mass[at(block.first_node) + n];
      const Vector applied = m.actions.applied.empty() ? Vector{} : m.actions.applied[at(b)].force;
      for (std::size_t n = 0; n < u.gridpoint.size(); ++n)
        add_to(sum, u.gridpoint[n], m.nodes.mass[at(block.first_node) + n] / inertia * (block.mass * g + applied));
      each_load_on_gridpoints(m, b, [&](std::int32_t node, const Vector& force) {
        add_to(sum, u.gridpoint[at(node - block.first_node)], force);
      });
      add_zones(b, sum);
    }
  }

  // Adds weight, loads, and forces of zones.
  void add_lattice_loads(VectorXd* sum) const {
    const Vector g = geometry::vector(s_.data.gravity);
    for (int b = 0; b < static_cast<int>(unknowns_->blocks().size()); ++b) {
      const Unknowns::OfBlock& u = unknowns_->blocks()[at(b)];
      const Model::BlockPlace& place = s_.model.place[at(b)];
      if (u.rigid) {
        const auto [index, lane] = s_.lattice.place[at(place.body)];
        Vector force = s_.model.bodies[at(place.body)].mass * g, moment;
        for (int c = 0; c < 3; ++c) {
          force[c] += s_.lattice.bodies[at(index)].applied_force[c][lane];
          moment[c] = s_.lattice.bodies[at(index)].applied_moment[c][lane];
        }
        add_to(sum, {u.body[0], u.body[1], u.body[2]}, force);
        add_to(sum, {u.body[3], u.body[4], u.body[5]}, moment);
        continue;
      }
      Vector acceleration = g;
      if (const double* const load = s_.controls.load_of_group[at(place.group)])
        for (int c = 0; c < 3; ++c) acceleration[c] += load[c * static_cast<int>(kLanes) + place.lane];
      std::size_t n = 0;
      s_.model.for_each_gridpoint(
          b, [&](std::size_t, double mass) { add_to(sum, u.gridpoint[n++], mass * acceleration); });
      add_zones(b, sum);
    }
  }

  void add_contacts(const std::vector<ContactPoint>& points, VectorXd* sum) {
    std::vector<UnknownShare> shares;
    for (const ContactPoint& p : points) {
      unknowns_->shares_of(p, &shares);
      const Vector force = force_of(p);
      for (const UnknownShare& share : shares) (*sum)(share.unknown) -= dot(force, share.moves);
    }
  }

  // Unbalanced ratio as in steps of the stage: largest force on a gridpoint or body over the mean contact force.
  double ratio_of(const VectorXd& rest, const std::vector<ContactPoint>& points) const {
    double mean = 0.0, largest = 0.0;
    for (const ContactPoint& p : points)
      mean += p.area * std::hypot(p.traction[0], p.traction[1], p.traction[2]) / static_cast<double>(points.size());
    const auto force_at = [&](int x, int y, int z) {
      double squares = 0.0;
      for (const int i : {x, y, z})
        if (i >= 0) squares += rest(i) * rest(i);
      largest = std::max(largest, std::sqrt(squares));
    };
    for (const Unknowns::OfBlock& u : unknowns_->blocks()) {
      if (u.rigid) force_at(u.body[0], u.body[1], u.body[2]);
      for (const auto& of_point : u.gridpoint) force_at(of_point[0], of_point[1], of_point[2]);
    }
    // Moments of rigid blocks, over the diagonal of the model.
    for (const Unknowns::OfBlock& u : unknowns_->blocks()) {
      for (std::size_t c = 3; c < 6 && u.rigid; ++c)
        if (u.body[c] >= 0) largest = std::max(largest, std::abs(rest(u.body[c])) / s_.small_motion.extent);
    }
    return largest == 0.0 ? 0.0 : largest / std::max(mean, 1e-300);
  }

  // ---- Stiffness -------------------------------------------------------------------------------------------------

  static std::vector<std::uint8_t> states_of(const std::vector<ContactPoint>& points) {
    std::vector<std::uint8_t> states;
    for (const ContactPoint& p : points) {
      const bool carries_nothing = p.traction[0] == 0.0 && p.jump[0] > 0.0;
      const bool sliding = (p.flags & QUOIN_FLAG_SLIPPING) != 0;
      states.push_back(carries_nothing ? open : sliding ? slides : closed);
    }
    return states;
  }

  Eigen::SparseMatrix<double> stiffness_of(const std::vector<ContactPoint>& points,
                                           const std::vector<std::uint8_t>& states, double kept) {
    StiffnessEntries entries;
    unknowns_->add_zones(&entries);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const ContactPoint& p = points[i];
      const quoin_stiffness_bounds bounds = stiffness_bounds_at(s_, p);
      const double normal = p.area * bounds.normal * (states[i] == open ? std::max(kOpen, kept) : 1.0);
      const double shear = p.area * bounds.shear *
                           (states[i] == open     ? std::max(kOpen, kept)
                            : states[i] == slides ? std::max(kSlides, kept)
                                                  : 1.0);
      unknowns_->add_point(p, normal, shear, &entries);
    }
    const auto n = static_cast<Eigen::Index>(unknowns_->count());
    Eigen::SparseMatrix<double> stiffness(n, n);
    double largest = 0.0;
    for (const auto& entry : entries) largest = std::max(largest, entry.value());
    for (int i = 0; i < unknowns_->count(); ++i) entries.emplace_back(i, i, kHeld * largest);
    stiffness.setFromTriplets(entries.begin(), entries.end());
    return stiffness;
  }

  // ---- Motion ----------------------------------------------------------------------------------------------------

  void require_held(const Eigen::MatrixXd& moved) const {
    for (std::size_t g = 0; g < unknowns_->groups().place.size(); ++g) {
      for (int i = unknowns_->groups().begin[g];
           i < std::min(unknowns_->groups().begin[g + 1], unknowns_->groups().begin[g] + 3); ++i) {
        if (std::abs(moved(i, 0)) <= kFlies * s_.small_motion.extent) continue;
        throw Error(
            Exit::numerical,
            fmt::format("stage '{}': no state of rest: block {} is held by nothing that its loads press on, or what it "
                        "stands on buckles; quoin limit tells whether it stands as it is at the start",
                        s_.scene.stages[at(s_.progress.stage)].name, block_label(s_, unknowns_->block_of_group(g))));
      }
    }
  }

  static Vector of(const VectorXd& moved, const std::array<int, 3>& unknown) {
    Vector v{};
    for (int c = 0; c < 3; ++c)
      if (unknown[at(c)] >= 0) v[c] = moved(unknown[at(c)]);
    return v;
  }

  // Moves all blocks, evaluates the laws, and sets all velocities to zero.
  void move(const VectorXd& moved) {
    if (s_.large_motion) return move_large_motion(moved);
    // Slip increments are velocities times the time step. The second call is without motion, as some laws settle in two
    // calls.
    for (const bool moving : {true, false}) {
      for (int b = 0; b < static_cast<int>(unknowns_->blocks().size()); ++b)
        unknowns_->blocks()[at(b)].rigid ? move_body(b, moved, moving) : move_gridpoints(b, moved, moving);
      for (const int i : chunks_here(s_)) {
        const ContactChunk& chunk = s_.model.chunks[at(i)];
        contact_jumps(s_.model, chunk, s_.data, s_.division.jumps[0].get());
        evaluate_law(s_, i, *s_.division.jumps[0], false, false);
        contact_forces(s_.model, chunk, s_.data);
      }
    }
    if (s_.contacts.law_failed.load(std::memory_order_relaxed)) report_failed_points(s_);
  }

  void move_gridpoints(int b, const VectorXd& moved, bool moving) {
    std::size_t n = 0;
    s_.model.for_each_gridpoint(b, [&](std::size_t offset, double) {
      const Vector by = of(moved, unknowns_->blocks()[at(b)].gridpoint[n++]);
      for (int c = 0; c < 3; ++c) {
        const std::size_t o = offset + at(c) * kLanes;
        if (moving) s_.lattice.displacement[o] += by[c];
        s_.lattice.velocity[o] = moving ? by[c] / s_.data.time_step : 0.0;
      }
    });
  }

  void move_body(int b, const VectorXd& moved, bool moving) {
    const std::array<int, 6>& u = unknowns_->blocks()[at(b)].body;
    const int index = s_.model.place[at(b)].body;
    const RigidBody& body = s_.model.bodies[at(index)];
    const auto [record, lane] = s_.lattice.place[at(index)];
    BodyLanes& lanes = s_.lattice.bodies[at(record)];
    const Vector by = of(moved, {u[0], u[1], u[2]}), turn = of(moved, {u[3], u[4], u[5]});
    Vector displacement{}, rotation{};
    for (int c = 0; c < 3; ++c) {
      if (moving) lanes.displacement[c][lane] += by[c], lanes.rotation[c][lane] += turn[c];
      displacement[c] = lanes.displacement[c][lane], rotation[c] = lanes.rotation[c][lane];
      if (!moving) lanes.velocity[c][lane] = lanes.spin[c][lane] = 0.0;
    }
    // Gridpoints of the body hold what its joints read: displacement along the normal, velocity across it.
    for (std::size_t k = 0; k < body.slave.size(); ++k) {
      const Vector arm = geometry::vector(body.arm[k]);
      const Vector place = displacement + cross(rotation, arm), speed = by + cross(turn, arm);
      const int n = s_.model.point_axis[at(body.point[k])];
      for (int c = 0; c < 3; ++c) {
        const std::size_t o = static_cast<std::size_t>(body.slave[k]) + at(c) * kLanes;
        if (c == n)
          s_.lattice.displacement[o] = place[c];
        else
          s_.lattice.velocity[o] = moving ? speed[c] / s_.data.time_step : 0.0;
      }
    }
  }

  void move_large_motion(const VectorXd& moved) {
    blocks::Model& m = *s_.large_motion;
    for (int b = 0; b < static_cast<int>(unknowns_->blocks().size()); ++b) {
      Unknowns::OfBlock& u = unknowns_->blocks()[at(b)];
      if (u.rigid) {
        blocks::Body& body = body_of(m, b);
        body.x += of(moved, {u.body[0], u.body[1], u.body[2]});
        body.turn_to(normalized(geometry::rotation(of(moved, {u.body[3], u.body[4], u.body[5]})) * body.q));
        body.v = body.omega = body.momentum = {};
        u.centre = body.x;
        continue;
      }
      const int first = m.blocks[b].first_node;
      for (std::size_t n = 0; n < u.gridpoint.size(); ++n) {
        change_node_positions(m)[at(first) + n] += of(moved, u.gridpoint[n]);
        change_node_velocities(m)[at(first) + n] = {};
      }
    }
    m.begin_step();
    for (int chunk = 0; chunk < m.chunk_count(); ++chunk) m.advance_contacts(chunk);
  }

 public:
  // Dampers have no force at rest: the way to it is no motion of theirs.
  void relax_dampers() {
    const double unknown = std::nan("");
    std::ranges::fill(s_.lattice.old_jump, unknown);
    if (!s_.large_motion) return;
    for (blocks::Family& f : s_.large_motion->contacts.families) {
      std::ranges::fill(f.old_jump, unknown);
      for (auto& column : f.maxwell) std::ranges::fill(column, 0.0);
    }
  }

  // Rest is that against the ground, which earlier records may have left with a velocity.
  void follow_ground() {
    const Vector ground =
        s_.large_motion ? s_.large_motion->actions.ground_then : geometry::vector(s_.data.ground_velocity);
    if (norm(ground) == 0.0 || !all_fixed_follow()) return;
    for (int b = 0; b < static_cast<int>(unknowns_->blocks().size()); ++b)
      s_.large_motion ? follow_ground_in_large_motion(b, ground) : follow_ground_on_lattice(b, ground);
  }

 private:
  // Whether all fixed blocks move with the ground: others, as supports that a stage holds, carry blocks that rest.
  bool all_fixed_follow() const {
    int fixed = 0;
    for (int b = 0; b < block_count(s_); ++b) fixed += is_fixed(s_, b);
    return fixed == std::ranges::count_if(s_.actions.drives, [&](const Drive& d) {
             return is_fixed(s_, d.block) && ground_rank(d.of_ground, d.motion) == 2;
           });
  }

  void follow_ground_in_large_motion(int b, const Vector& ground) {
    blocks::Model& m = *s_.large_motion;
    const auto follow = [&](const auto& unknown, Vector& velocity) {
      for (int c = 0; c < 3; ++c)
        if (unknown[at(c)] >= 0) velocity[c] = ground[c];
    };
    const Unknowns::OfBlock& u = unknowns_->blocks()[at(b)];
    if (u.rigid) return follow(u.body, body_of(m, b).v);
    for (std::size_t n = 0; n < u.gridpoint.size(); ++n)
      follow(u.gridpoint[n], change_node_velocities(m)[at(m.blocks[b].first_node) + n]);
  }

  void follow_ground_on_lattice(int b, const Vector& ground) {
    const Unknowns::OfBlock& u = unknowns_->blocks()[at(b)];
    const auto follow = [&](std::size_t first) {
      for (int c = 0; c < 3; ++c) s_.lattice.velocity[first + at(c) * kLanes] = ground[c];
    };
    if (!u.rigid) return s_.model.for_each_gridpoint(b, [&](std::size_t first, double) { follow(first); });
    const int index = s_.model.place[at(b)].body;
    const auto [record, lane] = s_.lattice.place[at(index)];
    for (int c = 0; c < 3; ++c) s_.lattice.bodies[at(record)].velocity[c][lane] = ground[c];
    for (const std::int32_t slave : s_.model.bodies[at(index)].slave) follow(static_cast<std::size_t>(slave));
  }

  Simulation::Impl& s_;
  std::optional<Unknowns> unknowns_;
};

}  // namespace

void find_rest(Simulation::Impl& impl, const std::function<bool()>& stop_requested) {
  const Stage& stage = impl.scene.stages[at(impl.progress.stage)];
  const auto out_of_books = [&] { return impl.energy.now ? impl.energy.now->balance_error() : 0.0; };
  const double before = impl.progress.step > 0 ? out_of_books() : 0.0;
  Search search(impl);
  search.run(stage.equilibrium_ratio.value_or(1e-4), stop_requested);
  search.relax_dampers();
  search.follow_ground();
  // The work of loads is the energy that blocks and joints have taken up, as for loads that grow slowly.
  step_once(impl, true, true);
  const double taken_up = out_of_books() - before;
  impl.energy.external += taken_up;
}

#else

void find_rest(Simulation::Impl&, const std::function<bool()>&) {}

#endif

namespace {

void require(const Stage& stage, bool on_ranks) {
#ifndef QUOIN_REST
  if (stage.kind == "rest")
    throw Error(Exit::bad_input, fmt::format("{}: this program finds no states of rest; build it with "
                                             "libopenblas-serial-dev",
                                             stage.source.text));
#endif
  if (!on_ranks) return;
  if (stage.kind == "rest")
    throw Error(Exit::bad_input, fmt::format("{}: a stage of rest runs in one process; start quoin without mpirun, or "
                                             "give the stage equilibrium_ratio without kind = \"rest\"",
                                             stage.source.text));
  if (stage.solver && damping_of(*stage.solver).is_implicit())
    throw Error(Exit::bad_input, fmt::format("{}: solver.implicit_contacts runs in one process; start quoin without "
                                             "mpirun, or remove it from the stage",
                                             stage.source.text));
}

}  // namespace

void require_coming_stages(const Simulation& simulation) {
  const Simulation::Impl& s = simulation;
  const auto first = at(simulation.stages_ended() + (s.progress.in_stage ? 1 : 0));
  for (std::size_t i = first; i < s.scene.stages.size(); ++i) require(s.scene.stages[i], s.ranks != nullptr);
}

}  // namespace quoin
