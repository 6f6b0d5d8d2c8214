// Blocks of any convex shape and the contacts between them, in large motion: what they are, where they are now, what
// acts on them. Contacts and results are found here; step/large_motion.h advances blocks.
//
// Rigid blocks: position, quaternion, linear and angular momentum. Deformable blocks: zones, constant-strain
// tetrahedra. Contacts: block a owns the plane (a face, or the plane of two crossing edges), block b carries the
// points. Jumps are measured in a frame that moves with a. d_n is the distance from the plane less its reference, the
// slip increment is the change of b's position in that frame. So traction turns with a, spin about n included, and a
// rigid rotation of both changes no bit of physics. The pair of forces acts at one point in space: force and moment
// balance exactly.
#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>

#include "base/error.h"
#include "base/rank_rows.h"
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
  // Discretises blocks and finds the initial joints. materials: one a family, or empty to load the laws by their names.
  // Throws Error(bad_input): blocks that overlap at the start (names, place, depth), bad shapes, materials or settings.
  // ranks: those that share the model; then all is numbered, and nothing more exists before begin().
  World(const Assembly& scene, const SolverSettings& settings,
        std::vector<std::shared_ptr<const Material>> materials = {}, Ranks* ranks = nullptr);

  World(const World&) = delete;
  World& operator=(const World&) = delete;

  // What acts from now on.
  void set_gravity(const Vector& g, TimeSeries factor = {});                                         // m/s2
  void prescribe(int block, const Vector& velocity, const Vector& omega = {}, uint8_t held = 0x3f);  // m/s, rad/s
  void release(int block);
  void set_velocity(int block, const Vector& velocity, const Vector& omega = {});  // initial velocity of a free block
  void add(Load load);
  void add(Pressure pressure);
  // Force on the centre of mass of a block, on a deformable one shared by mass, N. Stays until changed.
  void apply_force(int block, const Vector& force);
  void clear_loads() {
    actions.loads.clear(), actions.pressures.clear(), actions.applied.clear();
    actions.loaded.assign(blocks.size(), 0);
  }
  // Settings of a stage: mass_scaling stays as it was at the start. The time step is chosen again.
  void set_solver(const SolverSettings& settings);
  // The law alone, for a state that is about to be restored.
  void take_law(int family, std::shared_ptr<const Material> material);
  // Another law for all points of a family, between two steps. state: columns of the new law one after the other.
  // opening_shift: by point, m, added to the opening of the law, so that tractions can stay. Points born later
  // start in the new law's dry state; the time step becomes shorter if the new law is stiffer.
  void replace_law(int family, std::shared_ptr<const Material> material, std::span<const double> state,
                   std::span<const double> opening_shift);
  void track_energy(bool on);  // from nothing
  // Energies of the steps from now on are added to what has been booked; off: that stays.
  void book_energy(bool on);
  // Velocity of the ground half a step ago and now, m/s: what mass-proportional and local damping brake against.
  void move_ground(const Vector& half_step_ago, const Vector& now) {
    actions.ground_then = half_step_ago, actions.ground_now = now;
  }
  // Members that hold blocks beside their joints (world_members.cpp). The time step is chosen again. exchange: gives
  // places and turns of nodes to ranks that do not have their blocks; empty: one process.
  using ExchangeNodes = std::function<void(std::vector<members::Node>& nodes)>;
  void hold_by_members(std::shared_ptr<members::Members> members, ExchangeNodes exchange = {});
  const members::Members* members() const { return held_by.members.get(); }
  members::Members* members() { return held_by.members.get(); }
  // Springs from outside that pull on its blocks, by their eigenvalue on the masses of these, 1/s2: they shorten the
  // time step.
  void hold_by_springs(double eigenvalue);

  double time() const { return stepping.time; }
  long steps() const { return stepping.count; }
  double time_step() const { return stepping.dt; }
  double critical_time_step() const { return stepping.critical_dt; }
  // Share of critical that the time step leaves of solver.impact_damping; 0: damping is not that of impacts.
  double impact_damping_in_use() const { return impacts_damped(solver) ? impacts.share * solver.impact_damping : 0.0; }
  // What moves most in the fastest vibration, which sets the step; of one process that has all blocks.
  StepLimit what_sets_time_step() const;
  long detections() const { return detection.count; }
  long divisions() const { return chunks.divisions; }  // number of divisions of the work so far
  // Whether the current step ends with a check of how far blocks have moved. Contacts are detected after such steps
  // alone.
  bool checks_motion() const { return stepping.count + 1 >= checks.next || stepping.dt != checks.dt; }

  // For ranks that share the model (world_parts.cpp). All have its outline: blocks, pairs that are close, how many
  // contact points they have. Arrays have the numbers of the whole model; laid out, and in memory, is what a rank works
  // with. It is its own blocks, the chunks of points that touch them, and what those and close pairs touch of others.
  void begin(std::vector<int> rank_of_block);
  // Blocks go to these ranks from now on. known: blocks that every rank is to have besides.
  void hold(std::vector<int> rank_of_block, std::span<const int> known);
  void exchange_blocks(std::span<const int> chosen);  // to all
  void exchange_joints(
      std::span<const int> of_blocks);    // to all: the contact points of these blocks, and what they touch
  size_t gather_everything(bool to_all);  // or to rank 0 alone; bytes
  // visit(rank, first byte, bytes): what steps change of blocks and points, by the rank that has it.
  using VisitOwned = std::function<void(int, void*, size_t)>;
  void each_owned_memory(const VisitOwned& visit);
  int unit_count() const { return units.count; }
  long narrow_calls() const { return detection.narrow_calls; }

  // Results.
  int chunk_count() const { return int(chunks.all.size()); }
  double chunk_work(int chunk) const { return chunks.all[size_t(chunk)].count; }
  int count_of(Piece::Kind kind) const;  // blocks that get their inner forces so
  int piece_count() const { return int(pieces.all.size()); }
  double piece_work(int piece) const;
  std::span<const int32_t> blocks_of_piece(int piece) const { return pieces.blocks_of(pieces.all[size_t(piece)]); }
  int block_count() const { return int(blocks.size()); }
  // Of joints that begin at blocks [first, end), in their order. With ranks of own blocks, after
  // exchange_parted_blocks().
  std::vector<PartedPoint> parted_points(int first_block, int end_block) const;
  void exchange_parted_blocks();                                           // by all ranks at the same moment
  bool has_replaced_points() const { return !start_joints.kept.empty(); }  // contact points, since the start
  // Pairs that have points in a chunk, and their blocks.
  template <class Visit>
  void each_contact_of_chunk(int chunk, Visit visit) const {
    const Chunk& c = chunks.all[size_t(chunk)];
    const std::vector<uint32_t>& of_family = contacts.of_family[size_t(c.family)];
    auto i = std::partition_point(of_family.begin(), of_family.end(), [&](uint32_t k) {
      return contacts.list[k].first + contacts.list[k].count <= c.first;
    });
    for (; i != of_family.end() && contacts.list[*i].first < c.first + c.count; ++i) visit(size_t(*i));
  }
  template <class Visit>
  void each_block_of_chunk(int chunk, Visit visit) const {
    each_contact_of_chunk(chunk, [&](size_t i) { visit(contacts.list[i].pair.a), visit(contacts.list[i].pair.b); });
  }
  const std::vector<Family>& families() const { return contacts.families; }
  Vector position(int block) const;  // centre of mass, m
  Vector start_position(int block) const;
  double moved(int block) const;   // displacement since the start, m
  double turned(int block) const;  // rad
  double moved_by_now(int block) const { return norm(position(block) - start_position(block)); }
  double turned_by_now(int block) const;
  Matrix orientation(int block) const;       // rotation since the start
  Vector velocity(int block) const;          // velocity of the centre of mass, m/s
  Vector angular_velocity(int block) const;  // rigid, rad/s
  Vector contact_force(int block) const;     // sum over all contacts of the last step, N
  Matrix frame_of(const Point& p) const;     // rows n, s, t in space, n from a to b
  Vector place_of(const Point& p) const;     // m
  Vector corner(int block, int vertex) const;
  // Corners of each face as it stands, counter-clockwise seen from outside: faces of rigid blocks, triangles of the
  // surface of deformable ones, m.
  std::vector<std::vector<Vector>> faces(int block) const;
  LaneVector<Vector>& change_node_positions() {
    frames.are_old = true;
    return nodes.x;
  }
  const LaneVector<Vector>& node_positions() const { return nodes.x; }
  LaneVector<Vector>& node_velocities() { return nodes.v; }
  const LaneVector<Vector>& node_reference() const { return nodes.reference; }
  const LaneVector<double>& node_mass() const { return nodes.mass; }
  size_t zone_count() const;
  Zone zone(int block, int index) const { return zones.zone(blocks[size_t(block)], index); }
  template <class Visit>
  void each_zone(Visit visit) const {  // visit(ModelBlock, Zone), block after block
    for (const ModelBlock& b : blocks) {
      for (int k = 0; k < b.zone_count; ++k) visit(b, zones.zone(b, k));
    }
  }
  Matrix zone_stress(int block, int index) const;  // Cauchy, Pa, tension positive
  const ModelBlock& block(int i) const { return blocks[i]; }
  Body& body(int block) { return bodies[blocks[block].body]; }
  // Holds gridpoints of deformable blocks: bits 0..2 of `held`.
  void hold_node(int node, uint8_t held) { nodes.held[node] = held, pieces.any_held_changed = true; }
  void hold_velocity(int node, const Vector& v) { nodes.held_v[node] = v, pieces.any_held_changed = true; }  // m/s
  const Energies& energies() const { return step_sums.energies; }
  double kinetic_energy() const;  // from the velocities half a step ago, J
  double kinetic_energy_of(int block) const;
  double kinetic_energy_of_all() const;  // the same on all ranks, J
  // On a block, of its free components, in the last step, without damping, N; of own blocks.
  Vector net_force_on(int block) const { return step_sums.of_block[size_t(block)].net; }
  Vector net_force() const { return step_sums.net; }  // force of the last step on all that is free to move, N
  double strain_energy() const;
  Vector linear_momentum() const;
  Vector angular_momentum(const Vector& about = {}) const;
  double unbalanced_ratio() const;  // largest unbalanced force / mean contact force of the last step; inf: none
  Deepest deepest_of_chunk(int chunk) const;
  Deepest deepest_of(const Chunk& chunk) const;
  double force_sum_of(const Chunk& chunk) const;
  // A chunk of points: of which family, the first one in it, how many.
  struct ChunkRange {
    int family;
    size_t first, count;
  };
  ChunkRange range_of_chunk(int chunk) const {
    const Chunk& c = chunks.all[size_t(chunk)];
    return {c.family, c.first, c.count};
  }
  size_t point_count() const;
  double extent() const;  // diagonal of the box around all blocks at the start, m
  double mass() const;
  double mass_of(int block) const;  // mass for weight, kg
  // parts: hands the bytes of an array on to a function, in pieces if need be; empty: all of it is here.
  using TakeBytes = std::function<void(std::span<const uint8_t>)>;
  using GiveParts = std::function<void(const void* first, size_t bytes, const TakeBytes& take)>;
  uint64_t hash(const GiveParts& parts = {}) const;

  // A run that goes on from one in small displacements (adopt_histories.cpp), before the first step. Clock; then the
  // pose of every rigid block, gridpoints by node_positions() and node_velocities(); then all contact points.
  // adopt_histories keeps tractions, states and openings as they are, whatever the turning of the blocks means for the
  // gap. Throws Error(numerical) when a history has no contact point here. Points without a history begin without load.
  void set_pose(int block, const Vector& centre, const Quaternion& turn);  // rigid; turn: since the start
  void adopt_histories(const std::vector<PointHistory>& histories);

  Assembly assembly;
  SolverSettings solver;
  ModelPart part;

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
  bool is_small = true;       // displacements: frames of contacts stay as at the start
  bool books_energy = false;  // energies are requested
  bool is_settling = false;   // damping is that of stages that run to equilibrium
};

inline double gamma(const World& w) {  // coefficient of eq. 1
  return w.is_settling ? w.solver.settling_damping.value_or(w.solver.local_damping) : w.solver.local_damping;
}
// Velocity of the ground at the time of damping: signs are of half a step ago, viscous forces of now.
inline Vector braking_ground(const World& w) {
  return w.solver.damping == DampingKind::viscous ? w.actions.ground_now : w.actions.ground_then;
}
inline int facets_a_point(const World& w, const Contact& c) {
  return int(w.blocks[size_t(c.pair.a)].body < 0) + int(w.blocks[size_t(c.pair.b)].body < 0);
}

}  // namespace quoin::blocks
