// Blocks of any convex shape and the contacts between them, in large motion: what they are, where they are now, what
// acts on them. They are found in contact and asked here; step/large_motion.h moves them on.
//
// Rigid blocks: position, quaternion, linear and angular momentum. Deformable blocks: zones, constant-strain
// tetrahedra. Contacts: block a owns the plane (a face, or the plane of two crossing edges), block b carries the
// points. Jumps are measured in a frame that rides on a. d_n is the distance from the plane less its reference, the
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

class World {
 public:
  // Discretises blocks and finds the initial joints. materials: one a family, or empty to load the laws by their names.
  // Throws Error(bad_input): blocks that overlap at the start (names, place, depth), bad shapes, materials or settings.
  // ranks: those that share the model; then all is numbered, and nothing more exists before begin().
  World(const Assembly& assembly, const SolverSettings& solver,
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
  std::vector<Load>& loads() { return actions_.loads; }
  std::vector<Pressure>& pressures() { return actions_.pressures; }
  // Force on the centre of mass of a block, on a deformable one shared by mass, N. Stays until changed.
  void apply_force(int block, const Vector& force);
  void clear_loads() {
    actions_.loads.clear(), actions_.pressures.clear(), actions_.applied.clear();
    actions_.loaded.assign(blocks_.size(), 0);
  }
  const std::array<MaxwellElement, kMaxwellElements>& maxwell_elements() const { return impacts_.maxwell; }
  // Of a stage: mass_scaling stays as it was at the start. The time step is chosen again.
  void set_solver(const SolverSettings& solver);
  // Damping of stages that run to equilibrium, or of others.
  void settle(bool on) { settling_ = on; }
  // The law alone, for a state that is about to be restored.
  void take_law(int family, std::shared_ptr<const Material> material);
  // Another law for all points of a family, between two steps. state: columns of the new law one after the other.
  // opening_shift: by point, m, added to the opening that the law sees, so that tractions can stay. Points born later
  // start in the new law's dry state; the time step becomes shorter if the new law is stiffer.
  void replace_law(int family, std::shared_ptr<const Material> material, std::span<const double> state,
                   std::span<const double> opening_shift);
  void track_energy(bool on);  // from nothing
  // Energies of the steps from now on are added to what has been booked; off: that stays.
  void book_energy(bool on);
  double dissipated_in_step() const { return step_sums_.dissipated; }  // by laws, in the last one, J; with energies
  // Velocity of the ground half a step ago and now, m/s: what mass-proportional and local damping brake against.
  void move_ground(const Vector& half_step_ago, const Vector& now) {
    actions_.ground_then = half_step_ago, actions_.ground_now = now;
  }
  // Members that hold blocks beside their joints (world_members.cpp). The time step is chosen again. exchange: gives
  // places and turns of nodes to ranks that do not have their blocks; empty: one process.
  using ExchangeNodes = std::function<void(std::vector<members::Node>& nodes)>;
  void hold_by_members(std::shared_ptr<members::Members> members, ExchangeNodes exchange = {});
  const members::Members* members() const { return held_by_.members.get(); }
  members::Members* members() { return held_by_.members.get(); }
  // Springs from outside that pull on its blocks, by their eigenvalue on the masses of these, 1/s2: they shorten the
  // time step.
  void hold_by_springs(double eigenvalue);

  double time() const { return stepping_.time; }
  long steps() const { return stepping_.count; }
  double time_step() const { return stepping_.dt; }
  double critical_time_step() const {
    return stepping_.critical_dt;
  }  // 2/omega_max of the assembled system, undamaged, s
  // Of solver.impact_damping what the time step leaves, of critical; 0: damping is not that of impacts.
  double impact_damping_in_use() const { return impacts_damped() ? impacts_.share * solver_.impact_damping : 0.0; }
  // What moves most in the fastest vibration, which sets the step; of one process that has all blocks.
  StepLimit what_sets_time_step() const;
  bool small_displacement() const { return small_; }
  long detections() const { return detection_.count; }
  long divisions() const { return chunks_.divisions; }  // how often the work has been divided again
  // Whether the step of now looks at how far blocks have moved, at its end: then only may contacts be detected.
  bool checks_motion() const {
    return stepping_.count + 1 >= checks_.next || (stepping_.dt != checks_.dt && !bodies_.empty());
  }

  // For ranks that share the model (world_parts.cpp). All have its outline: blocks, pairs that are close, how many
  // contact points they have. Arrays have the numbers of the whole model; laid out, and in memory, is what a rank works
  // with. It is its own blocks, the chunks of points that touch them, and what those and close pairs touch of others.
  void begin(std::vector<int> rank_of_block);
  // Blocks go to these ranks from now on. known: blocks that every rank is to have besides.
  void hold(std::vector<int> rank_of_block, std::span<const int> known);
  void exchange_blocks(std::span<const int> blocks);  // to all
  void exchange_joints(std::span<const int> blocks);  // to all: the contact points of these blocks, and what they touch
  size_t gather_everything(bool to_all);              // or to rank 0 alone; bytes
  bool is_laid_out(int block) const { return part_.laid_out[size_t(block)]; }
  bool owns(int block) const { return !part_.ranks || part_.rank_of_block[size_t(block)] == part_.ranks->rank(); }
  Vector rough_place(int block) const { return part_.rough_place[size_t(block)]; }  // the same on all ranks, m
  // visit(rank, first byte, bytes): what steps change of blocks and points, by the rank that has it.
  using VisitOwned = std::function<void(int, void*, size_t)>;
  void each_owned_memory(const VisitOwned& visit);
  // Called before contacts are detected or blocks go with others: where other processes have advanced some of them,
  // what they know is to be fetched.
  void before_dividing(std::function<void()> fetch) { part_.fetch = std::move(fetch); }
  int unit_count() const { return units_.count; }  // units in two halves that hold together
  long narrow_calls() const { return detection_.narrow_calls; }

  // Results.
  int chunk_count() const { return int(chunks_.all.size()); }
  double chunk_work(int chunk) const { return chunks_.all[size_t(chunk)].count; }
  int count_of(Piece::Kind kind) const;  // blocks that get their inner forces so
  int piece_count() const { return int(pieces_.all.size()); }
  double piece_work(int piece) const;
  std::span<const int32_t> blocks_of_piece(int piece) const { return pieces_.blocks_of(pieces_.all[size_t(piece)]); }
  int block_count() const { return int(blocks_.size()); }
  const Assembly& assembly() const { return assembly_; }
  const std::vector<Contact>& contacts() const { return contacts_.list; }  // in the order of their pairs
  const PairPlace& place_of_pair(size_t contact) const { return contacts_.place[contact]; }
  bool owns(const Contact& c) const { return owns(c.pair.a) || owns(c.pair.b); }
  // Of joints that begin at blocks [first, end), in their order. With ranks of own blocks, after
  // exchange_parted_blocks().
  std::vector<PartedPoint> parted_points(int first_block, int end_block) const;
  void exchange_parted_blocks();                                            // by all ranks at the same moment
  bool has_replaced_points() const { return !start_joints_.kept.empty(); }  // contact points, since the start
  // Pairs that have points in a chunk, and their blocks.
  template <class Visit>
  void each_contact_of_chunk(int chunk, Visit visit) const {
    const Chunk& c = chunks_.all[size_t(chunk)];
    const std::vector<uint32_t>& of_family = contacts_.of_family[size_t(c.family)];
    auto i = std::partition_point(of_family.begin(), of_family.end(), [&](uint32_t k) {
      return contacts_.list[k].first + contacts_.list[k].count <= c.first;
    });
    for (; i != of_family.end() && contacts_.list[*i].first < c.first + c.count; ++i) visit(size_t(*i));
  }
  template <class Visit>
  void each_block_of_chunk(int chunk, Visit visit) const {
    each_contact_of_chunk(chunk, [&](size_t i) { visit(contacts_.list[i].pair.a), visit(contacts_.list[i].pair.b); });
  }
  const std::vector<Family>& families() const { return contacts_.families; }
  Vector position(int block) const;  // centre of mass, m
  Vector start_position(int block) const;
  double moved(int block) const {
    return part_.ranks ? step_sums_.of_block[size_t(block)].moved : moved_by_now(block);
  }  // m
  double turned(int block) const {
    return part_.ranks ? step_sums_.of_block[size_t(block)].turned : turned_by_now(block);
  }  // rad
  std::span<const uint32_t> contacts_of_family(size_t family) const { return contacts_.of_family[family]; }
  Matrix orientation(int block) const;       // rotation since the start
  Vector velocity(int block) const;          // of the centre of mass, m/s
  Vector angular_velocity(int block) const;  // rigid, rad/s
  Vector contact_force(int block) const;     // of all contacts of the last step, N
  Matrix frame_of(const Point& p) const;     // rows n, s, t in space, n from a to b
  Vector place_of(const Point& p) const { return locate(p, contacts_.facets).at; }  // m
  Vector corner(int block, int vertex) const;
  // Corners of each face as it stands, counter-clockwise seen from outside: faces of rigid blocks, triangles of the
  // surface of deformable ones, m.
  std::vector<std::vector<Vector>> faces(int block) const;
  LaneVector<Vector>& change_node_positions() {
    frames_.are_old = true;
    return nodes_.x;
  }
  const LaneVector<Vector>& node_positions() const { return nodes_.x; }
  LaneVector<Vector>& node_velocities() { return nodes_.v; }
  const LaneVector<Vector>& node_reference() const { return nodes_.reference; }
  const LaneVector<double>& node_mass() const { return nodes_.mass; }
  size_t zone_count() const;
  Zone zone(int block, int index) const { return zone_of(blocks_[size_t(block)], index); }
  template <class Visit>
  void each_zone(Visit visit) const {  // visit(ModelBlock, Zone), block after block
    for (const ModelBlock& b : blocks_) {
      for (int k = 0; k < b.zone_count; ++k) visit(b, zone_of(b, k));
    }
  }
  Matrix zone_stress(int block, int index) const;  // Cauchy, Pa, tension positive
  const ModelBlock& block(int i) const { return blocks_[i]; }
  const LaneVector<Body>& bodies() const { return bodies_; }
  Body& body(int block) { return bodies_[blocks_[block].body]; }
  // Holds gridpoints of deformable blocks: bits 0..2 of `held`.
  void hold_node(int node, uint8_t held) { nodes_.held[node] = held, pieces_.any_held_changed = true; }
  void hold_velocity(int node, const Vector& v) { nodes_.held_v[node] = v, pieces_.any_held_changed = true; }  // m/s
  const Energies& energies() const { return step_sums_.energies; }
  double kinetic_energy() const;  // of the velocities half a step ago, J
  double kinetic_energy_of(int block) const;
  // On a block, of its free components, in the last step, without damping, N; of own blocks.
  Vector net_force_on(int block) const { return step_sums_.of_block[size_t(block)].net; }
  Vector net_force() const { return step_sums_.net; }  // on all that is free to move, of the last step, N
  double strain_energy() const;
  Vector linear_momentum() const;
  Vector angular_momentum(const Vector& about = {}) const;
  double unbalanced_ratio() const;  // largest unbalanced force / mean contact force of the last step; inf: none
  Deepest deepest_of_chunk(int chunk) const {
    const Chunk& c = chunks_.all[size_t(chunk)];
    return part_.ranks ? c.deepest : deepest_of(c);
  }
  // A chunk of points: of which family, the first one in it, how many.
  struct ChunkRange {
    int family;
    size_t first, count;
  };
  ChunkRange range_of_chunk(int chunk) const {
    const Chunk& c = chunks_.all[size_t(chunk)];
    return {c.family, c.first, c.count};
  }
  size_t point_count() const;
  double extent() const;  // diagonal of the box around all blocks at the start, m
  double mass() const;
  double mass_of(int block) const;  // that has weight, kg
  // parts: hands the bytes of an array on to a function, in pieces if need be; empty: all of it is here.
  using TakeBytes = std::function<void(std::span<const uint8_t>)>;
  using GiveParts = std::function<void(const void* first, size_t bytes, const TakeBytes& take)>;
  uint64_t hash(const GiveParts& parts = {}) const;

  // A run that goes on from one in small displacements (adopt_histories.cpp), before the first step. Clock; then the
  // pose of every rigid block, gridpoints by node_positions() and node_velocities(); then all contact points.
  // adopt_histories keeps tractions, states and openings as they are, whatever the turning of the blocks means for the
  // gap. Throws Error(numerical) when a history has no contact point here. Points without a history begin without load.
  void start_at(double time, long steps) { stepping_.time = time, stepping_.count = steps; }
  void set_pose(int block, const Vector& centre, const Quaternion& turn);  // rigid; turn: since the start
  void adopt_histories(const std::vector<PointHistory>& histories);

  // contact geometry checks, for tests
  void detect_now() { detect_contacts(true); }

 protected:
  friend struct WorldFields;
  bool moved_enough();
  void see(int block);
  bool check_block_motion(int block, long& step) const;
  bool check_pair_motion(const Contact& c, const PairPlace& place, const Pose& at_a, const Pose& at_b,
                         PairCheck& check) const;
  bool is_ripe(const Contact& c, const PairPlace& place, const PairCheck& check) const;  // to be looked at closely
  long step_after(double way, double speed, double acceleration = 0.0) const;
  long steps_of_gridpoints() const;
  void detect_contacts(bool everything = false);
  void draw_columns();  // of properties that scatter, for the points of the start
  // After contacts have changed. One process alone has then all that steps read; ranks are to hold their parts first.
  void divide_work();
  void bind_work();
  void bind_columns();
  void number_chunks();
  void bind_points(Chunk& chunk);
  void divide_blocks();
  void follow_members();  // to where their nodes are, and what they do there, before a step
  // Of bodies and gridpoints: velocities, or what acts on them.
  struct Columns {
    LaneVector<Vector>&linear, &angular, &node;
  };
  void add_member_springs(const Unit* alone, const Columns& velocity, const Columns& force) const;
  std::vector<std::pair<int32_t, double>> shares_at(int block, const Vector& point) const;  // of its gridpoints
  int most_gridpoints(const Piece& piece) const;                                            // of one of its blocks
  void fill_columns(Piece& piece);
  void fill_columns(std::span<const int32_t> blocks, const FixedColumns<double>& to) const;
  void follow_held();  // in the columns of pieces, before a step
  std::span<const ZoneLanes> zones_in_lanes(const ModelBlock& b) const {
    return {zones_.lanes.data() + b.first_lanes, size_t(b.lanes_count())};
  }
  Zone zone_of(const ModelBlock& b, int index) const {
    return zones_in_lanes(b)[size_t(index / ZoneLanes::kCount)].zone(index % ZoneLanes::kCount);
  }
  void divide_sides();
  void count_sides();
  void pack(const Chunk& chunk);
  void bind(Family& f, Chunk& chunk) const;
  void adopt(Family& f, std::shared_ptr<const Material> material, const std::string& initial_state);
  // Rigid motion is advanced apart from the rest: inertia is scaled apart, or damping is by block.
  bool splits_motion() const {
    return solver_.damping == DampingKind::block || solver_.deformation_inertia != 1.0 || solver_.unit_inertia != 1.0;
  }
  double gamma() const {  // of eq. 1
    return settling_ ? solver_.settling_damping.value_or(solver_.local_damping) : solver_.local_damping;
  }
  // Of the ground, at the time of what damping reads: signs are of half a step ago, viscous forces of now.
  Vector braking_ground() const {
    return solver_.damping == DampingKind::viscous ? actions_.ground_now : actions_.ground_then;
  }
  UnitInertia inertia_of(const Unit& unit) const;
  double rigid_kinetic_energy(const Unit& unit) const;
  void hold(uint8_t& held, uint8_t next, double mass, const Vector& v);
  void put_in_lanes(const Point& p, uint32_t index, Chunk& chunk);
  void put_on_gridpoints(const Point& p, uint32_t index, Chunk& chunk);
  void find_frames(InternalForces wanted);
  void make_congruent(int block);
  void find_units();
  void part_units();
  bool are_together(int a, int b) const;
  // By the first half or single block; others: nothing.
  std::vector<UnitInertia> inertia_of_units(std::span<const int> blocks) const;
  void scale_motion(std::span<const int> blocks, const std::vector<UnitInertia>& inertia, LaneVector<Vector>& y,
                    bool of_forces) const;
  void add_zone_forces(std::span<const int> blocks, const LaneVector<Vector>& velocity,
                       LaneVector<Vector>& force) const;
  bool viscous_contacts() const {
    return impacts_damped() || (solver_.damping == DampingKind::viscous && solver_.stiffness_damping > 0);
  }
  bool impacts_damped() const { return solver_.damping == DampingKind::impact; }
  bool has_maxwell() const { return impacts_damped() && solver_.maxwell_damping > 0.0; }
  bool has_columns(When when) const;  // of contact points
  void choose_impact_damping();
  using Landing = std::array<double, 2>;  // normal to the face and along it
  Landing landing_frequencies(int family) const;
  Landing landing_frequencies(const Contact& c, int block) const;
  double kinetic_energy_of_all() const;  // the same on all ranks, J

  void number(std::vector<std::shared_ptr<const Material>> materials);
  struct Counts;
  void number_block(int i, Counts& counts);
  void size_fields(const Counts& counts);
  void lay_out(int block);
  void lay_out_zones(int block);
  Body body_of(int block) const;
  static std::array<double, 6> zoning_key(const Block& block);
  std::shared_ptr<const geometry::Zoning> zoning_of(int block);
  geometry::Zoning make_zoning(int block) const;
  void forget_blocks(size_t first, size_t end);
  void find_time_step(bool may_grow = false);  // beside that in use

  // Exchange between processes; one alone has everything.
  int rank_of(const Contact& c) const { return part_.rank_of_block[size_t(c.pair.a)]; }
  template <class Memory>
  void gather_by_block(Memory& values) const;
  bool any(bool here) const;
  double largest(double here) const;
  void fail_together(const std::optional<Error>& here) const;  // throws on all ranks where one has failed
  struct Wanted;
  size_t exchange(const Wanted& wanted);  // bytes
  template <class Visit>
  void each_exchanged_memory(const Wanted& wanted, Visit visit);
  using VisitBytes = std::function<void(void*, size_t)>;
  struct Items {
    size_t first, end;
  };
  Items items_of_blocks(Owner owner, size_t first_block, size_t end_block) const;  // in a row
  void each_memory_of_block(int block, const VisitBytes& visit);
  Items start_points_of(int first_block, int end_block) const;  // of joints that begin at these blocks
  void each_memory_of_points(int family, size_t first, size_t end, const VisitBytes& visit);
  void forget_points(size_t family, const std::vector<bool>& contact_stays);
  void receive_new_neighbours(const std::vector<geometry::Pair>& pairs);
  void bind_neighbours();
  void receive_neighbours();
  int facets_a_point(const Contact& c) const {
    return int(blocks_[size_t(c.pair.a)].body < 0) + int(blocks_[size_t(c.pair.b)].body < 0);
  }
  // Springs of contact points, normal and along the joint, by family; and factors on the forces of zones and of
  // members.
  struct Stiffness {
    std::vector<std::array<double, 2>> of_family;
    double of_zones, of_members;
  };
  Stiffness stiffness() const;        // Pa/m, 1
  Stiffness impact_dashpots() const;  // Pa s/m, s
  Stiffness with_dashpots(double share, double dt) const;
  // Of these over the inertia, by the largest eigenvalue. mode: by 6 of bodies, 3 of gridpoints. alone: of this unit,
  // held, on springs to all others that are twice as stiff.
  double largest_over_inertia(const Stiffness& stiffness, LaneVector<double>* mode = nullptr,
                              const Unit* alone = nullptr) const;
  double highest_frequency(LaneVector<double>* mode = nullptr, const Unit* alone = nullptr) const;  // rad/s
  double step_under_impact_damping();                     // over the critical one
  bool shorten_step(std::span<const int> changed) const;  // these own blocks
  double local_stiffness_bound() const;
  double moved_by_now(int block) const { return norm(position(block) - start_position(block)); }
  double turned_by_now(int block) const;
  double force_sum_of(const Chunk& chunk) const;
  Deepest deepest_of(const Chunk& chunk) const;
  // Points of own blocks, or of this unit, that can close before part_units looks again, in the order of all points:
  // visit(family, point).
  template <class Visit>
  void each_own_point(Visit visit, const Unit* alone = nullptr) const;
  struct FrequencyHalo;
  struct Vibration;
  void place_blocks();
  geometry::Placed placed(int block) const;
  void pose(int block, Vector& x, Matrix& r) const;
  Pose pose(int block) const {
    Pose now;
    pose(block, now.x, now.r);
    return now;
  }
  double pair_motion(const Contact& c, const PairPlace& place, const Pose& a, const Pose& b) const;
  double lever_of(const Contact& c, double distance) const;
  double motion_since_broad_phase(int block) const;                       // translation plus rotation times radius, m
  double detection_fraction() const;                                      // of a block's least extent
  double allowed_motion(const Contact& c, const PairPlace& place) const;  // of a pair until it is detected again, m
  struct NewPoint;
  struct Finding;
  struct Heir;
  struct Detection;
  struct Before;
  std::vector<geometry::Pair> close_pairs(bool everything);
  void narrow_phase(const std::vector<geometry::Pair>& pairs, bool everything, Detection& found);
  void detect_pair(Contact& c, PairPlace& place, bool known, Finding& finding, Detection& found);
  void exchange_findings(Detection& found);
  void number_points(Detection& found, Before& before);
  bool carries(const Contact& c) const;
  void name_family(Contact& c, const Vector& normal, std::span<const NewPoint> points) const;
  void place_points(Detection& found);
  static void take_points(Family& f, Family& into);
  void keep_points(const Before& before, const Finding& finding, const Contact& c, uint32_t facets);
  void hand_over(const Before& before, const Finding& finding, const Contact& c, std::span<const NewPoint> points,
                 bool at_start);
  void inherit(const Family& old, size_t from, const Contact& c, Family& f, size_t to) const;
  void keep_energy(const Before& before, const Finding& finding, const Contact& c, std::span<const Heir> heirs);
  static double plastic_closure(const Family& f, size_t i);
  double energy_of_points(const Family& f, const LaneVector<Facet>& facets, uint32_t first, uint32_t count) const;
  Vector in_space(const Point& p, const Vector& v) const;  // of p's frame
  void make_points(const Contact& c, const geometry::Separation& s, bool at_start, std::vector<NewPoint>& out);
  RigidPoints rigid_points_of(const Contact& c, const Vector& normal, bool at_start) const;  // corners or cubic
  void face_points(int owner, int owner_face, int carrier, bool at_start, double nominal, RigidPoints rule,
                   std::vector<NewPoint>& out);
  bool edge_point(const geometry::Pair& pair, const geometry::Separation& separation, double area,
                  std::vector<NewPoint>& out);
  void note_start_joints();
  void keep_of_joint(const Contact& c, const Family& old, const LaneVector<Facet>& facets, uint32_t first,
                     uint32_t count);
  size_t kept_width() const;
  void keep_states_by_id(int family, const quoin_law& old, size_t old_width);
  std::vector<Vector> places_of(const Contact& c) const;
  void anchor(NewPoint& p, int block, const Vector& at, int face, bool plane_side);
  void choose_frame(NewPoint& p) const;
  bool may_have_frame(int block) const {  // deformable
    return !frames_.by_zone[size_t(block)] && (blocks_[size_t(block)].congruent >= 0 || !nodes_.anchor.empty());
  }
  // Along these axes of a joint: what a vector along slightly different ones becomes, of the same size.
  static std::pair<double, double> turned_into(const Vector& s, const Vector& t, const Vector& v);
  // Of what contact points have along s and t: turn(s before, t before, s now, t now), arrays by point.
  template <class Turn>
  static void turn_joint_vectors(const Family& old, Family& f, const Turn& turn) {
    turn(old.traction[1], old.traction[2], f.traction[1], f.traction[2]);
    if (!old.viscous[0].empty() && !f.viscous[0].empty())
      turn(old.viscous[1], old.viscous[2], f.viscous[1], f.viscous[2]);
    for (size_t k = 0; k < std::size(f.maxwell) && !old.maxwell[k].empty() && !f.maxwell[k].empty(); k += 3)
      turn(old.maxwell[k + 1], old.maxwell[k + 2], f.maxwell[k + 1], f.maxwell[k + 2]);
    for (size_t k = 0; k + 1 < f.state.size(); ++k) {
      if (f.material->api().states[k]->kind == QUOIN_STATE_PAIR_S)
        turn(old.state[k], old.state[k + 1], f.state[k], f.state[k + 1]);
    }
  }
  void refresh_facet_frame(Point& p, Facet& facet) const;
  Matrix start_of_frame(int block) const;     // R of a deformable block at the start
  Matrix rotation_of_frame(int block) const;  // of now; in small displacements that of the start
  void find_block_frames();                   // of all that are laid out
  double deformation(int block) const;
  void leave_frames_of_deformed();
  void leave_gridpoints(Family& f, size_t point);  // whose block a has no frame any more: it goes on from a triangle
  void take_back_facets();                         // frames and feet, from lanes to points
  struct Location {
    Vector at;
    double jump = 0.0, slid[2] = {0.0, 0.0};
  };
  Location locate(const Point& p, const LaneVector<Facet>& facets) const;
  void resize(Family& f, size_t n) const;

  // Of a rigid block, in the coordinates of its shape, without mass scaling.
  struct RigidMass {
    double mass;            // kg
    Vector centre;          // m
    geometry::Eigen3 axes;  // principal inertia, kg m2
  };
  RigidMass rigid_mass(const Block& block) const;
  double density_of(const Block& block) const;  // with the mass that is spread, kg/m3

  Assembly assembly_;
  SolverSettings solver_;
  ModelPart part_;

  // Blocks.
  std::vector<ModelBlock> blocks_;
  BlockShapes shapes_;
  Poses poses_;
  LaneVector<Body> bodies_;  // rigid
  Gridpoints nodes_;         // deformable
  Zones zones_;
  BlockFrames frames_;
  Units units_;

  // Contacts.
  Contacts contacts_;
  DetectionState detection_;
  MotionChecks checks_;
  StartJoints start_joints_;

  // Division of the work.
  Chunks chunks_;
  Sides sides_;
  Pieces pieces_;

  HeldBy held_by_;
  Actions actions_;
  Stepping stepping_;
  ImpactState impacts_;
  StepSums step_sums_;
  bool small_ = true;      // displacements
  bool energy_ = false;    // is booked
  bool settling_ = false;  // to equilibrium
};

}  // namespace quoin::blocks
