// Blocks of any convex shape in large motion, the contacts between them, and the actions on them. Contacts and results
// are computed in host/model; step/large_motion.h advances blocks.
//
// Rigid blocks have position, quaternion, linear and angular momentum. Deformable blocks have zones, constant-strain
// tetrahedra. In a contact, block a owns the plane (a face, or the plane of two crossing edges), and block b carries
// the points. Jumps are measured in a frame that moves with a. d_n is the distance from the plane less its reference;
// the slip increment is the change of b's position in that frame. So traction turns with a, spin about n included, and
// a common rigid rotation of both blocks changes no stress. The opposite forces act at one point in space: force and
// moment balance exactly. In fixed frames moments do to the order of the rotation (fixed_frames.h).
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <span>

#include "base/error.h"
#include "base/rank_rows.h"
#include "base/thread_pool.h"
#include "law/law_library.h"
#include "model/block_frames.h"
#include "model/block_inertia.h"
#include "model/block_units.h"
#include "model/block_zones.h"
#include "model/chunks.h"
#include "model/contacts.h"
#include "model/detection.h"
#include "model/field.h"
#include "model/gridpoints.h"
#include "model/impact_state.h"
#include "model/loads.h"
#include "model/model_block.h"
#include "model/model_part.h"
#include "model/motion_checks.h"
#include "model/parted_points.h"
#include "model/pieces.h"
#include "model/point_history.h"
#include "model/rigid_bodies.h"
#include "model/sides.h"
#include "model/step_sums.h"
#include "model/stepping.h"
#include "model/world_members.h"
#include "scene/blocks.h"

namespace quoin::blocks {

struct World {
  // Discretises blocks and finds the initial joints. materials: one per family, or empty to load the laws by their
  // names. Throws Error(bad_input) for blocks that overlap at the start (names, place, depth), bad shapes, materials or
  // settings. ranks: those that share the model; then items are only numbered, and begin() lays them out.
  World(const Assembly& scene, const SolverSettings& settings,
        std::vector<std::shared_ptr<const Material>> materials = {}, Ranks* ranks = nullptr,
        ThreadPool* pool = nullptr);

  World(const World&) = delete;
  World& operator=(const World&) = delete;

  // Actions from now on.
  void set_gravity(const Vector& g);                                                                 // m/s2
  void prescribe(int block, const Vector& velocity, const Vector& omega = {}, uint8_t held = 0x3f);  // m/s, rad/s
  void set_velocity(int block, const Vector& velocity, const Vector& omega = {});  // initial velocity of a free block
  void add(Load load);
  void add(Pressure pressure);
  // Force on the centre of mass of a block, N, and moment about it, N m; gridpoints of a deformable block share them by
  // mass. They stay until changed.
  void apply_force(int block, const Vector& force, const Vector& moment = {});
  // Settings of a stage; mass_scaling keeps its value of the start. The time step is chosen again.
  void set_solver(const SolverSettings& settings);
  void settle(bool on);  // on: damping of stages that run to equilibrium
  // Replaces the law alone, for a state that is about to be restored.
  void take_law(int family, std::shared_ptr<const Material> material);
  // Replaces the law of all points of a family, between two steps. state: columns of the new law one after the other.
  // opening_shift: by point, m, added to the opening of the law, so that tractions can stay. Points placed later start
  // in the new law's dry state. The time step becomes shorter if the new law is stiffer.
  void replace_law(int family, std::shared_ptr<const Material> material, std::span<const double> state,
                   std::span<const double> opening_shift);
  void track_energy(bool on);  // starts from zero
  // Adds energies of later steps to those already booked; off: the booked energies stay.
  void book_energy(bool on);
  // Velocity of the ground half a step ago and now, m/s: reference of mass-proportional and local damping.
  void move_ground(const Vector& half_step_ago, const Vector& now) {
    actions.ground_then = half_step_ago, actions.ground_now = now;
  }
  // Adds members (world_members.cpp); the time step is chosen again. exchange: sends places and rotations of nodes to
  // ranks that do not have their blocks; empty: one process.
  using ExchangeNodes = std::function<void(std::vector<members::Node>& nodes)>;
  void hold_by_members(std::shared_ptr<members::Members> members, ExchangeNodes exchange = {});
  // Adds external springs on its blocks, by their eigenvalue on the masses of these blocks, 1/s2. They shorten the time
  // step.
  void hold_by_springs(double eigenvalue);

  // Lays out the blocks of this rank. For ranks that share the model, of which all have the outline (world_parts.h).
  void begin(std::vector<int> rank_of_block);

  int block_count() const { return int(blocks.size()); }
  int chunk_count() const { return int(chunks.all.size()); }
  int piece_count() const { return int(pieces.all.size()); }
  size_t point_count() const;
  size_t zone_count() const;
  // parts: passes the bytes of an array to a function, in pieces if need be; empty: this process has the whole array.
  using TakeBytes = std::function<void(std::span<const uint8_t>)>;
  using GiveParts = std::function<void(const void* first, size_t bytes, const TakeBytes& take)>;
  uint64_t hash(const GiveParts& parts = {}) const;

  Assembly assembly;
  SolverSettings solver;
  ModelPart part;
  ThreadPool* pool = nullptr;  // threads of detection and of the time step; null: the caller alone

  // Blocks.
  std::vector<ModelBlock> blocks;
  BlockShapes shapes;
  Poses poses;
  LaneVector<Body> bodies;  // rigid
  Gridpoints nodes;         // deformable
  Zones zones;
  BlockFrames frames;
  Units units;

  // Contacts.
  Contacts contacts;
  DetectionState detection;
  MotionChecks checks;
  StartJoints start_joints;

  // Division of the work.
  Chunks chunks;
  Sides sides;
  Pieces pieces;

  HeldBy held_by;
  Actions actions;
  Stepping stepping;
  ImpactState impacts;
  StepSums step_sums;
  bool is_small = true;       // whether displacements are small: frames of contacts stay those of the start
  bool books_energy = false;  // whether energies are requested
  bool is_settling = false;   // whether the stage runs to equilibrium
  Damping damping;            // damping of `solver` and `is_settling`
};

// Whether rigid motion is advanced apart from deformation: inertia is scaled, or damping is by block.
inline bool splits_motion(const World& w) {
  return w.damping.splits_motion() || w.solver.deformation_inertia != 1.0 || w.solver.unit_inertia != 1.0;
}
// Velocity of the ground at the time of damping: signs need that of half a step ago, viscous forces the current one.
inline Vector braking_ground(const World& w) {
  return w.damping.alpha > 0.0 ? w.actions.ground_now : w.actions.ground_then;
}
inline int facets_a_point(const World& w, const Contact& c) {
  return int(w.blocks[size_t(c.pair.a)].body < 0) + int(w.blocks[size_t(c.pair.b)].body < 0);
}

// Whether the current step ends with a check of the motion of blocks. Contacts are detected only after such steps.
inline bool checks_motion(const World& w) {
  return w.stepping.count + 1 >= w.checks.next || w.stepping.dt != w.checks.dt;
}
inline Body& body_of(World& w, int block) { return w.bodies[w.blocks[block].body]; }
inline LaneVector<Vector>& change_node_velocities(World& w) {
  copy_velocities(w);
  w.pieces.motion_is_old = true;
  return w.nodes.v;
}
inline LaneVector<Vector>& change_node_positions(World& w) {
  change_node_velocities(w);
  w.frames.are_old = true;
  return w.nodes.x;
}
// Current velocity of gridpoint n of a deformable block, m/s, after any step.
inline Vector gridpoint_velocity(const World& w, int block, int n) {
  const ModelBlock& b = w.blocks[size_t(block)];
  if (!w.pieces.velocities_lag || w.pieces.lane_of_block[size_t(block)] < 0) return w.nodes.v[size_t(b.first_node + n)];
  const double* const v =
      w.pieces.motion.data() + w.pieces.lane_of_block[size_t(block)] + std::int64_t{b.node_count + n} * kLine;
  return {v[0], v[kLanes], v[2 * kLanes]};
}
inline Zone zone_of(const World& w, int block, int index) { return w.zones.zone(w.blocks[size_t(block)], index); }
template <class Visit>
void each_zone(const World& w, Visit visit) {  // visit(ModelBlock, Zone), block after block
  for (const ModelBlock& b : w.blocks) {
    for (int k = 0; k < b.zone_count; ++k) visit(b, w.zones.zone(b, k));
  }
}
// Visits pairs that have points in a chunk, and their blocks.
template <class Visit>
void each_contact_of_chunk(const World& w, int chunk, Visit visit) {
  const Chunk& c = w.chunks.all[size_t(chunk)];
  const std::vector<uint32_t>& of_family = w.contacts.of_family[size_t(c.family)];
  auto i = std::partition_point(of_family.begin(), of_family.end(), [&](uint32_t k) {
    return w.contacts.list[k].first + w.contacts.list[k].count <= c.first;
  });
  for (; i != of_family.end() && w.contacts.list[*i].first < c.first + c.count; ++i) visit(size_t(*i));
}
template <class Visit>
void each_block_of_chunk(const World& w, int chunk, Visit visit) {
  each_contact_of_chunk(w, chunk,
                        [&](size_t i) { visit(w.contacts.list[i].pair.a), visit(w.contacts.list[i].pair.b); });
}

}  // namespace quoin::blocks
