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

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>

#include "base/error.h"
#include "base/rank_rows.h"
#include "geometry/broad_phase.h"
#include "geometry/separation.h"
#include "law/law_library.h"
#include "model/block_inertia.h"
#include "model/congruent_blocks.h"
#include "model/field.h"
#include "model/halo.h"
#include "model/kept_items.h"
#include "model/lanes.h"
#include "model/maxwell.h"
#include "model/property_columns.h"
#include "scene/blocks.h"

namespace quoin::members {
struct Node;
class Members;
}  // namespace quoin::members

namespace quoin::blocks {

// Rigid block. Body frame: principal axes through the centre of mass. In the order in which kernels read it.
struct Body {
  Vector x;                  // centre of mass, m
  Quaternion q;              // body frame to space
  Vector v;                  // m/s, at half steps
  Vector momentum;           // angular, about the centre of mass, in space, at half steps
  Vector omega;              // rad/s, in space, at half steps
  Vector force, torque;      // of the step
  double weight_mass = 0.0;  // of weight, kg
  double mass = 0.0;         // of inertia, kg (mass scaling included)
  Vector inertia;            // principal, kg m2
  Vector held_v, held_omega;
  Matrix r, transposed_r;  // of q
  uint8_t held = 0;        // bits 0..2: velocity prescribed along x, y, z; 3..5: rotation about them
  uint8_t support = 0;     // of these, the ones that a plane of symmetry holds for good

  void turn_to(const Quaternion& orientation) {
    q = orientation;
    r = matrix(q);
    transposed_r = transposed(r);
  }
};

// The frame of a deformable block that deforms little (step/deformable_kernels.h), as its gridpoints stand.
struct BlockFrame {
  Matrix transposed_r;  // of R, from the undeformed shape to space
  Matrix f;             // F = R U = sum x b^T
};

struct Zone {
  int32_t node[4];
  Vector gradient[4];  // of the shape functions in the reference configuration, 1/m
  double volume;       // reference, m3
  double lambda, mu;   // Pa

  double energy(const Matrix& strain) const;  // stored under a uniform strain, symmetric, J
};

// Zones of a block in lanes, as their kernel reads them; those beyond `count` have no volume.
struct ZoneLanes {
  static constexpr int kCount = 8;
  alignas(64) double gradient[3][3][kCount];                // of the shape functions of corners 1 to 3, 1/m
  double volume[kCount], lambda[kCount], twice_mu[kCount];  // m3, Pa
  int32_t node[4][kCount];                                  // of the block
  int count;
};

// A contact point. Everything is in the frame of block a. Rigid blocks have the body frame; deformable ones BlockFrame
// where both sides are gridpoints, else that of a triangle.
struct Point {
  int32_t a, b;                        // blocks
  int32_t facet_a = -1, facet_b = -1;  // index into World::facets_ for a deformable side
  bool on_gridpoints = false;          // the first ones of both facets; n, s, t are in the frame of block a
  // Unit, n from a to b. In space where a triangle is the frame: of the last step, or the last detection (see
  // frame_of).
  Vector n, s, t;
  double offset = 0.0;     // d_n = n . position in a's frame - offset, m (rigid a); reference gap (deformable a)
  Vector arm;              // of the point in b's body frame (rigid b), m
  double area = 0.0;       // m2
  double reference = 0.0;  // gap at which d_n = 0, m
  Vector at;               // in space where it was placed; of the last step if a side is deformable, m
  // Of the last step, if a side is deformable:
  Vector force;                  // on a, in space, viscous part included, N
  double shear[2] = {0.0, 0.0};  // traction along s and t that goes with it, Pa
};

// Where a point sits on a triangle of a deformable block.
struct Facet {
  int32_t node[3];
  double weight[3];
  double gradient[3][2];  // of the shape functions along s, t, 1/m; of the triangle that owns the plane
};
// On its first one.
inline bool sits_on_gridpoint(const Facet& f) { return f.weight[0] == 1.0 && f.weight[1] == 0.0 && f.weight[2] == 0.0; }

// Points of one joint family, law columns in structure-of-arrays form.
struct Family {
  std::shared_ptr<const Material> material;
  std::vector<double> initial, dry;  // state values
  double kn = 0.0, ks = 0.0;         // stiffness bounds, Pa/m
  LaneVector<Point> point;
  LaneVector<double> slid[2];  // position along s, t in a's frame at the last step, m
  LaneVector<double> normal_jump, slip[2], traction[3];
  std::vector<LaneVector<double>> state;
  std::vector<PropertyColumn> columns;  // of what scatters
  LaneVector<double> old_traction[3];   // when stiffness damping or contact inspection needs it
  LaneVector<double> stored, dissipated[QUOIN_DISSIPATED_COUNT];  // when energies are asked for, J/m2
  LaneVector<double> old_jump;
  LaneVector<double> viscous[3];                     // traction of damping in the last step, Pa
  LaneVector<double> maxwell[3 * kMaxwellElements];  // tractions of its Maxwell elements, one after the other, Pa
  LaneVector<double> arm[3], offset, area;           // of the points, side by side for the step
  size_t size() const { return point.size(); }
};

// Points in a row between two rigid blocks, in one plane: what they share, and what they add up to.
struct RigidPair {
  int32_t a, b;           // bodies
  uint32_t first, count;  // points of the family
  Vector axis[3];         // n, s, t in a's body frame, unit
  // Of the last step:
  double in_space[3][4];             // the axes; the fourth has no meaning
  Vector force, moment_a, moment_b;  // on a, N; about the centre of a, on a, and of b, on b, N m
};

// Points in a row of one pair of deformable blocks, which sit on gridpoints of both. Axes turn with the frame of block
// a.
struct GridpointPair {
  int32_t a, b;           // blocks
  uint32_t first, count;  // points of the family
  uint32_t row;           // force of the first point in World::facet_rows_, which has one row a point
  Vector axis[3];         // n, s, t in the frame of block a, unit
  Vector moment;          // of the last step, on the frame of a, which turns the axes, N m
};
// The axes of a pair in space: n, s, t; the fourth number has no meaning. A step forms them again: they never leave the
// cache.
struct PairAxes {
  double axis[3][4];
};

// Up to kCount points in a row on triangles, lane by lane; those beyond `count` repeat the last one.
struct FacetLanes {
  static constexpr int kCount = 8;
  uint32_t first, count;  // points of the family
  uint32_t row;           // of the first point, which has FacetRow::kCount of them, in World::facet_rows_
  bool on_gridpoints;     // all points sit on the first gridpoint of b's triangle
  int32_t node_a[3][kCount], node_b[3][kCount];
  int32_t facet_a[kCount];  // where the weights go back to
  alignas(64) double weight_b[3][kCount];
  double reference[kCount], area[kCount];  // m, m2
  double weight_a[3][kCount];  // of the foot of the point on the triangle that owns the plane; of the last step
};
// Frames of those triangles as they stand. In large motion a step forms them again: they never leave the cache.
struct FacetFrames {
  static constexpr int kCount = FacetLanes::kCount;
  alignas(64) double n[3][kCount];
  double s[3][kCount], t[3][kCount];
  double slope[3][kCount];  // along s of corner 1, along t of corners 1 and 2: gradients of shape functions, 1/m
};
// Of what a point does to a, N: all of it, and the parts of corners 1 and 2 of a's triangle. The rest is corner 0's,
// and b has the opposite of it all by its weights. The fourth number of a row has no meaning.
struct FacetRow {
  static constexpr int kCount = 3;
  double force[4];
};

// The smallest opening of some points, m, and where it is, m.
struct Deepest {
  double opening;
  Vector at;
};

// A run of points of one family: one call of its law, one piece of work. At most kChunk points.
struct Chunk {
  int family = 0;
  uint32_t first = 0, count = 0;
  quoin_batch batch{};
  std::vector<quoin_in> state_old;
  std::vector<quoin_out> state_new;
  std::vector<quoin_property_column> properties;  // that scatter
  std::vector<RigidPair> pairs;                   // of its points between rigid blocks
  std::vector<GridpointPair> gridpoint_pairs;     // of those on gridpoints
  std::vector<PairAxes> pair_axes;                // of these; in small displacements, where they stay
  std::vector<int32_t> node_a, node_b;            // of these, by point of the chunk
  std::vector<FacetLanes> facets;                 // on triangles
  std::vector<FacetFrames> frames;                // of these; in small displacements, where they stay
  std::vector<uint32_t> others;                   // with one deformable side
  // of the last step
  quoin_status status = QUOIN_OK;
  bool failed = false;
  double stored = 0.0, dissipated[QUOIN_DISSIPATED_COUNT] = {}, damping = 0.0;  // J
  // for rows of the history
  double force_sum = 0.0;  // of the sizes of the points' forces, N
  Deepest deepest{};
};
inline constexpr uint32_t kChunk = 256;
inline constexpr int kBodies = 8;  // blocks that move on side by side
// Congruent blocks from which on one product with the stiffness of all costs less than one of each with its own.
inline constexpr size_t kFewestAlike = 3;
// |u| of a frame over the least extent of its block, beyond which it goes zone by zone: error of its stiffness 1 %.
inline constexpr double kLargestDeformation = 0.01;

// One side of a contact point, as its block sees it.
struct Touch {
  int32_t family;
  uint32_t point;
  bool side_a;
};
// One side of a point of two deformable blocks, as its block sees it. It owns the plane, carries the point on a
// triangle, or has it on a gridpoint.
struct OwnerTouch {
  uint32_t row;
  int32_t node[3];
};
struct CarrierTouch {
  uint32_t row;
  int32_t node[3];
  double weight[3];
};
struct GridpointTouch {
  uint32_t row;
  int32_t node;
};
// Sides of points, block after block.
template <class Touch>
struct ByBlock {
  std::vector<Touch> touch;
  std::vector<uint32_t> end;  // by block
  std::span<const Touch> of(int block) const {
    const uint32_t first = block > 0 ? end[size_t(block) - 1] : 0;
    return std::span(touch).subspan(first, end[size_t(block)] - first);
  }
};
using MomentTouch = const GridpointPair*;  // of block a
// One side of a pair of rigid blocks.
struct PairTouch {
  const RigidPair* pair;
  bool side_a;
};

// Blocks that move on together: rigid ones, or deformable ones that stand alone, or first the one and then the other
// halves of units.
struct Piece {
  uint32_t first, count;  // of World::piece_blocks_; at most kBodies in a group
  bool halves;            // two groups: lane by lane the two halves of a unit
  enum class Kind : uint8_t { rigid, congruent, distinct, by_zone } kind;
  int32_t congruent = -1;  // into World::congruent_, of congruent blocks
  static constexpr size_t kNoColumns = size_t(-1);
  size_t columns[2] = {kNoColumns, kNoColumns};  // where FixedColumns of its groups begin in World::piece_columns_
  bool some_held = false;
  size_t group_count() const { return halves ? 2 : 1; }
  bool in_frame() const { return kind == Kind::congruent || kind == Kind::distinct; }
};

// What steps seldom change of the gridpoints of up to kLanes deformable blocks, side by side. A line is a gridpoint:
// three numbers a lane of vectors, one of others. Gridpoints that a block does not have are without mass and stand
// where its first one does; lanes without a block repeat the last one.
template <class Number>
struct FixedColumns {
  Number *mass, *over_mass;  // of inertia, kg, 1/kg or 0
  Number *place, *anchor;    // of blocks in frames of their own: X from the first gridpoint, m, and b, 1/m; else null
  Number *held, *held_v;     // where some are held: 1 or 0, m/s; else null
  FixedColumns(Number* from, int node_count, bool distinct, bool some_held) {
    const auto take = [&](bool wanted, int numbers) {
      Number* const column = wanted ? from : nullptr;
      if (wanted) from += size_t(node_count) * size_t(numbers);
      return column;
    };
    mass = take(true, kLanes), over_mass = take(true, kLanes);
    place = take(distinct, kLine), anchor = take(distinct, kLine);
    held = take(some_held, kLine), held_v = take(some_held, kLine);
  }
  static size_t size(int node_count, bool distinct, bool some_held) {
    return size_t(node_count) * size_t(2 * kLanes + (distinct ? 2 * kLine : 0) + (some_held ? 2 * kLine : 0));
  }
};

// Motion that the next checks of a rigid block assume (motion_checks.cpp). It moves as at the last one, but for so much
// of the speed of any part of it. In the order in which kernels read it.
struct SeenMotion {
  Vector v;                // m/s
  double radius = 0.0;     // m
  Vector omega;            // rad/s
  double unnoticed = 0.0;  // m/s
  long step = 0;           // of the look
};

// When a pair of blocks is looked at next.
struct PairCheck {
  int32_t a, b;
  bool ripe = false;  // has moved by most of its way
  long step = 0;
};

// What the step of one block adds up to.
struct BlockSums {
  double unbalanced = 0.0;  // largest net force on a body or gridpoint, of its free components, N; NaN stays
  Vector net;               // their sum, N
  double positions = 0.0;   // sum of coordinates; its only use is that it is not finite when one of them is not
  double kinetic = 0.0, strain = 0.0, damping = 0.0, external = 0.0;  // J
  double deformation = 0.0;          // in a frame, the largest |u| beside the first gridpoint, m
  bool deviates = false;             // moves otherwise than it was seen to
  double moved = 0.0, turned = 0.0;  // since the start, for a row of the history, m, rad
};

// What a contact point of the start goes on from: its law's columns in a model of small displacements.
struct PointHistory {
  int block_a, block_b;              // the normal of the joint points from a to b
  Vector position, s, t;             // of the start; m, unit, in the plane of the joint
  double opening = 0.0;              // that its law sees next, m
  double opening_at_traction = 0.0;  // that it has seen last, m
  std::array<double, 2> slip{};      // along s and t, that its law has not seen yet, m
  std::array<double, 3> traction{};  // Pa
  std::vector<double> state;
  std::vector<double> properties{};  // that scatter, in the order of the family's columns
};

// Two blocks close to each other: what every process has of them.
struct Contact {
  geometry::Pair pair;
  int family = -1;
  uint32_t first = 0, count = 0;  // points in Family::point
  uint32_t first_facet = 0;       // of these, in World::facets_
  bool initial = false;           // a joint of the start
  bool beside_joint = false;      // blocks that only touch along an edge or at a corner since the start
};
// The same pair at its last narrow detection.
struct PairPlace {
  geometry::Separation separation;
  Vector relative_x;  // pose of b seen from a
  Matrix relative_r;
};

// A joint of the start, and its contact points then.
struct StartJoint {
  geometry::Pair pair;
  int family;
  uint32_t first, count;  // of World::start_point_
};
struct StartPoint {
  Vector at;    // m
  double area;  // m2
};
// A contact point of the start where its blocks are no longer in contact (parted_points.cpp).
struct PartedPoint {
  int a, b, family;                // n points from block a to block b
  Vector side_a, side_b;           // where what was one place is now, on a and on b, m
  Vector n, s;                     // of the last contact point there, unit, turned along with a
  double area;                     // of the start, m2
  double normal_jump;              // of the last contact point there, m; and so:
  double traction[3];              // Pa
  std::vector<double> state;       // of the law
  std::vector<double> properties;  // that scatter, in the order of the family's columns
};

// Deformable blocks that move on together: one, or the two halves of a masonry unit.
struct Unit {
  int block[2] = {-1, -1};
  int count = 1;
  std::span<const int> blocks() const { return {block, size_t(count)}; }
  bool has(int i) const { return i == block[0] || (count == 2 && i == block[1]); }
};

// Those of one block.
struct Gridpoints {
  std::span<const Vector> x, v;  // m, m/s
  std::span<const double> mass;  // kg
  std::span<const uint8_t> held;
};

struct Energies {        // J
  double kinetic = 0.0;  // of components that are free to move
  double strain = 0.0, contact_stored = 0.0;
  double dissipated[QUOIN_DISSIPATED_COUNT] = {};  // tension, cohesion, friction, crushing
  double damping = 0.0;                            // taken by damping
  double external = 0.0;  // done by weight, loads and supports: what joints take from these, whatever their inertia
  // Energy lost (> 0) or gained when contact points were placed again, and lost with the inertia of halves on each
  // other when a unit came apart.
  double detection = 0.0;
  double members_stored = 0.0, members_dissipated = 0.0;  // of host/members
  double dissipated_total() const { return dissipated[0] + dissipated[1] + dissipated[2] + dissipated[3]; }
  // what has appeared from nowhere (> 0) or vanished since the start
  double balance_error(double at_start) const {
    return kinetic + strain + contact_stored + members_stored + dissipated_total() + members_dissipated + damping +
           detection - external - at_start;
  }
};

// What belongs to the energies of the next step. It is the work of forces in the second half of their own, and what is
// lost at its end. That is lost with points that are placed again and with units that come apart.
struct HalfStep {
  double damping = 0.0, external = 0.0, detection = 0.0;  // J
};

struct Load {
  int block;
  Vector point;  // in the block's frame of the start (space coordinates at the start), m; moves with the block
  Vector force;  // N, direction fixed in space
  TimeSeries factor;
  std::vector<std::pair<int32_t, double>> share;  // deformable: nodes and weights
  Vector arm;                                     // rigid: in the body frame
  double scale = 1.0;                             // for stages, whose loads grow and fade
};
struct Pressure {
  int block, face;
  double value;  // Pa, > 0 pushes on the block; follows the face
  TimeSeries factor;
  std::vector<std::array<int32_t, 3>> triangles;  // deformable
  Vector arm, push;                               // rigid: centroid and -normal * area in the body frame
  double scale = 1.0;
};

// One block in the model.
struct ModelBlock {
  const geometry::ConvexPolyhedron* shape;  // topology; body-frame vertices of rigid blocks are in `corner`
  int32_t body = -1;                        // rigid: index into bodies
  int32_t first_node = 0, node_count = 0;   // deformable
  int32_t first_zone = 0, zone_count = 0;
  int32_t first_lanes = 0;  // into the zones in lanes, which congruent blocks share
  int32_t congruent = -1;   // into what blocks of the same shape share; -1: too few of them
  int32_t lanes_count() const { return (zone_count + ZoneLanes::kCount - 1) / ZoneLanes::kCount; }
  uint32_t first_corner = 0;  // into corner arrays: vertices of the shape
  uint32_t first_normal = 0;
  double radius = 0.0;                                     // largest distance of a vertex from the centre, m
  double least_extent = 0.0;                               // m
  double corner_area = 0.0;                                // nominal area of an edge or corner contact, m2
  std::vector<geometry::Zoning::SurfaceTriangle> surface;  // deformable, global node numbers
};

struct Pose {
  Vector x;
  Matrix r;
};

// A rigid block, or a gridpoint and the flattest zone at it.
struct StepLimit {
  int block = -1;
  Vector at;                                 // m
  double height = 0.0, shortest_edge = 0.0;  // of the zone, m; 0: a rigid block
};

// The time step with these settings over the critical one, s, without damping.
double step_over_critical(const SolverSettings& solver, double critical);

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
  std::vector<Load>& loads() { return loads_; }
  std::vector<Pressure>& pressures() { return pressures_; }
  // Force on the centre of mass of a block, on a deformable one shared by mass, N. Stays until changed.
  void apply_force(int block, const Vector& force);
  void clear_loads() {
    loads_.clear(), pressures_.clear(), applied_.clear();
    loaded_.assign(blocks_.size(), 0);
  }
  const std::array<MaxwellElement, kMaxwellElements>& maxwell_elements() const { return maxwell_; }
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
  double dissipated_in_step() const { return dissipated_in_step_; }  // by laws, in the last one, J; with energies
  // Velocity of the ground half a step ago and now, m/s: what mass-proportional and local damping brake against.
  void move_ground(const Vector& half_step_ago, const Vector& now) { ground_then_ = half_step_ago, ground_now_ = now; }
  // Members that hold blocks beside their joints (world_members.cpp). The time step is chosen again. exchange: gives
  // places and turns of nodes to ranks that do not have their blocks; empty: one process.
  using ExchangeNodes = std::function<void(std::vector<members::Node>& nodes)>;
  void hold_by_members(std::shared_ptr<members::Members> members, ExchangeNodes exchange = {});
  const members::Members* members() const { return members_.get(); }
  members::Members* members() { return members_.get(); }
  // Springs from outside that pull on its blocks, by their eigenvalue on the masses of these, 1/s2: they shorten the
  // time step.
  void hold_by_springs(double eigenvalue);

  double time() const { return time_; }
  long steps() const { return step_count_; }
  double time_step() const { return dt_; }
  double critical_time_step() const { return critical_dt_; }  // 2/omega_max of the assembled system, undamaged, s
  // Of solver.impact_damping what the time step leaves, of critical; 0: damping is not that of impacts.
  double impact_damping_in_use() const { return impacts_damped() ? impact_share_ * solver_.impact_damping : 0.0; }
  // What moves most in the fastest vibration, which sets the step; of one process that has all blocks.
  StepLimit what_sets_time_step() const;
  bool small_displacement() const { return small_; }
  long detections() const { return detections_; }
  long divisions() const { return divisions_; }  // how often the work has been divided again
  // Whether the step of now looks at how far blocks have moved, at its end: then only may contacts be detected.
  bool checks_motion() const { return step_count_ + 1 >= next_check_ || dt_ != check_dt_; }

  // For ranks that share the model (world_parts.cpp). All have its outline: blocks, pairs that are close, how many
  // contact points they have. Arrays have the numbers of the whole model; laid out, and in memory, is what a rank works
  // with. It is its own blocks, the chunks of points that touch them, and what those and close pairs touch of others.
  void begin(std::vector<int> rank_of_block);
  // Blocks go to these ranks from now on. known: blocks that every rank is to have besides.
  void hold(std::vector<int> rank_of_block, std::span<const int> known);
  void exchange_blocks(std::span<const int> blocks);  // to all
  void exchange_joints(std::span<const int> blocks);  // to all: the contact points of these blocks, and what they touch
  size_t gather_everything(bool to_all);              // or to rank 0 alone; bytes
  bool is_laid_out(int block) const { return laid_out_[size_t(block)]; }
  bool owns(int block) const { return !ranks_ || rank_of_block_[size_t(block)] == ranks_->rank(); }
  Vector rough_place(int block) const { return rough_place_[size_t(block)]; }  // the same on all ranks, m
  // visit(rank, first byte, bytes): what steps change of blocks and points, by the rank that has it.
  using VisitOwned = std::function<void(int, void*, size_t)>;
  void each_owned_memory(const VisitOwned& visit);
  // Called before contacts are detected or blocks go with others: where other processes have advanced some of them,
  // what they know is to be fetched.
  void before_dividing(std::function<void()> fetch) { fetch_ = std::move(fetch); }
  int unit_count() const { return unit_count_; }  // units in two halves that hold together
  long narrow_calls() const { return narrow_calls_; }

  // Results.
  int chunk_count() const { return int(chunks_.size()); }
  double chunk_work(int chunk) const { return chunks_[size_t(chunk)].count; }
  int count_of(Piece::Kind kind) const;  // blocks that get their inner forces so
  int piece_count() const { return int(pieces_.size()); }
  double piece_work(int piece) const;
  std::span<const int32_t> blocks_of_piece(int piece) const { return blocks_of(pieces_[size_t(piece)]); }
  int block_count() const { return int(blocks_.size()); }
  const Assembly& assembly() const { return assembly_; }
  const std::vector<Contact>& contacts() const { return contacts_; }  // in the order of their pairs
  const PairPlace& place_of_pair(size_t contact) const { return pair_place_[contact]; }
  bool owns(const Contact& c) const { return owns(c.pair.a) || owns(c.pair.b); }
  // Of joints that begin at blocks [first, end), in their order. With ranks of own blocks, after
  // exchange_parted_blocks().
  std::vector<PartedPoint> parted_points(int first_block, int end_block) const;
  void exchange_parted_blocks();                               // by all ranks at the same moment
  bool has_replaced_points() const { return !kept_.empty(); }  // contact points, since the start
  // Pairs that have points in a chunk, and their blocks.
  template <class Visit>
  void each_contact_of_chunk(int chunk, Visit visit) const {
    const Chunk& c = chunks_[size_t(chunk)];
    const std::vector<uint32_t>& of_family = contacts_of_family_[size_t(c.family)];
    auto i = std::partition_point(of_family.begin(), of_family.end(),
                                  [&](uint32_t k) { return contacts_[k].first + contacts_[k].count <= c.first; });
    for (; i != of_family.end() && contacts_[*i].first < c.first + c.count; ++i) visit(size_t(*i));
  }
  template <class Visit>
  void each_block_of_chunk(int chunk, Visit visit) const {
    each_contact_of_chunk(chunk, [&](size_t i) { visit(contacts_[i].pair.a), visit(contacts_[i].pair.b); });
  }
  const std::vector<Family>& families() const { return families_; }
  Vector position(int block) const;  // centre of mass, m
  Vector start_position(int block) const;
  double moved(int block) const { return ranks_ ? block_sums_[size_t(block)].moved : moved_by_now(block); }     // m
  double turned(int block) const { return ranks_ ? block_sums_[size_t(block)].turned : turned_by_now(block); }  // rad
  std::span<const uint32_t> contacts_of_family(size_t family) const { return contacts_of_family_[family]; }
  Matrix orientation(int block) const;                                     // rotation since the start
  Vector velocity(int block) const;                                        // of the centre of mass, m/s
  Vector angular_velocity(int block) const;                                // rigid, rad/s
  Vector contact_force(int block) const;                                   // of all contacts of the last step, N
  Matrix frame_of(const Point& p) const;                                   // rows n, s, t in space, n from a to b
  Vector place_of(const Point& p) const { return locate(p, facets_).at; }  // m
  Vector corner(int block, int vertex) const;
  // Corners of each face as it stands, counter-clockwise seen from outside: faces of rigid blocks, triangles of the
  // surface of deformable ones, m.
  std::vector<std::vector<Vector>> faces(int block) const;
  LaneVector<Vector>& change_node_positions() {
    frames_are_old_ = true;
    return node_x_;
  }
  const LaneVector<Vector>& node_positions() const { return node_x_; }
  LaneVector<Vector>& node_velocities() { return node_v_; }
  const LaneVector<Vector>& node_reference() const { return node_reference_; }
  const LaneVector<double>& node_mass() const { return node_mass_; }
  const LaneVector<Zone>& zones() const { return zones_; }
  Matrix zone_stress(int zone) const;  // Cauchy, Pa, tension positive
  const ModelBlock& block(int i) const { return blocks_[i]; }
  const LaneVector<Body>& bodies() const { return bodies_; }
  Body& body(int block) { return bodies_[blocks_[block].body]; }
  // Holds gridpoints of deformable blocks: bits 0..2 of `held`.
  void hold_node(int node, uint8_t held) { node_held_[node] = held, held_changed_ = true; }
  void hold_velocity(int node, const Vector& v) { node_held_v_[node] = v, held_changed_ = true; }  // m/s
  const Energies& energies() const { return energies_; }
  double kinetic_energy() const;  // of the velocities half a step ago, J
  double kinetic_energy_of(int block) const;
  // On a block, of its free components, in the last step, without damping, N; of own blocks.
  Vector net_force_on(int block) const { return block_sums_[size_t(block)].net; }
  Vector net_force() const { return net_; }  // on all that is free to move, of the last step, N
  double strain_energy() const;
  Vector linear_momentum() const;
  Vector angular_momentum(const Vector& about = {}) const;
  double unbalanced_ratio() const;  // largest unbalanced force / mean contact force of the last step; inf: none
  Deepest deepest_of_chunk(int chunk) const {
    const Chunk& c = chunks_[size_t(chunk)];
    return ranks_ ? c.deepest : deepest_of(c);
  }
  // A chunk of points: of which family, the first one in it, how many.
  struct ChunkRange {
    int family;
    size_t first, count;
  };
  ChunkRange range_of_chunk(int chunk) const {
    const Chunk& c = chunks_[size_t(chunk)];
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
  void start_at(double time, long steps) { time_ = time, step_count_ = steps; }
  void set_pose(int block, const Vector& centre, const Quaternion& turn);  // rigid; turn: since the start
  void adopt_histories(const std::vector<PointHistory>& histories);

  // contact geometry checks, for tests
  void detect_now() { detect_contacts(true); }

 protected:
  friend struct WorldFields;
  bool moved_enough();
  void see(int block);
  bool check_block_motion(int block, long& step) const;
  // A block as a check finds it.
  struct CheckedMotion {
    Pose pose;
    double speed;  // twice that of its fastest corner, m/s
  };
  CheckedMotion checked_motion(int block) const;
  bool check_pair_motion(const Contact& c, const PairPlace& place, const CheckedMotion& now_a,
                         const CheckedMotion& now_b, PairCheck& check) const;
  long step_after(double way, double speed, double acceleration = 0.0) const;
  long step_of_gridpoints(double speed) const;
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
  std::span<const int32_t> blocks_of(const Piece& piece) const {
    return std::span(piece_blocks_).subspan(piece.first, piece.count);
  }
  std::span<const int32_t> blocks_of(const Piece& piece, size_t group) const {
    const size_t count = piece.count / piece.group_count();
    return blocks_of(piece).subspan(group * count, count);
  }
  std::span<const ZoneLanes> zones_in_lanes(const ModelBlock& b) const {
    return {zone_lanes_.data() + b.first_lanes, size_t(b.lanes_count())};
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
  Vector braking_ground() const { return solver_.damping == DampingKind::viscous ? ground_now_ : ground_then_; }
  enum class Halves : uint8_t { together, also_apart };
  Unit unit_of(int block, Halves of = Halves::together) const;
  Gridpoints gridpoints_of(int block) const;
  UnitInertia inertia_of(const Unit& unit) const;
  double rigid_kinetic_energy(const Unit& unit) const;
  void hold(uint8_t& held, uint8_t next, double mass, const Vector& v);
  void put_in_lanes(const ModelBlock& block);  // its zones
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
  int rank_of(const Contact& c) const { return rank_of_block_[size_t(c.pair.a)]; }
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
  double local_stiffness_bound(const std::function<bool(int block)>& is_wanted) const;
  double moved_by_now(int block) const { return norm(position(block) - start_position(block)); }
  double turned_by_now(int block) const;
  double force_sum_of(const Chunk& chunk) const;
  Deepest deepest_of(const Chunk& chunk) const;
  // Points of own blocks that can close before part_units looks again, in the order of all points: visit(family,
  // point). Of pairs with a block that is wanted: is_wanted(block).
  template <class Visit, class IsWanted>
  void each_own_point(Visit visit, IsWanted is_wanted) const;
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
  Before number_points(Detection& found);
  bool carries(const Contact& c) const;
  void name_family(Contact& c, const Vector& normal, std::span<const NewPoint> points) const;
  void place_points(Detection& found);
  void set_aside(const Contact& c, uint32_t& first, uint32_t& first_facet, uint32_t count, Before& before) const;
  template <class Array>
  void keep_items(Array& items, std::span<const KeptItems> kept, size_t count) const;
  void keep_points(Family& f, std::span<const KeptItems> kept, size_t count) const;
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
    return !by_zone_[size_t(block)] && (blocks_[size_t(block)].congruent >= 0 || !node_anchor_.empty());
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

  Assembly assembly_;
  SolverSettings solver_;
  // Of each shape, and zones of a few shapes.
  struct ShapeFacts {
    geometry::MassProperties mass;
    geometry::Eigen3 axes;
    double least_extent, area;  // m, m2 of the surface
  };
  // Of a rigid block, in the coordinates of its shape, without mass scaling.
  struct RigidMass {
    double mass;            // kg
    Vector centre;          // m
    geometry::Eigen3 axes;  // principal inertia, kg m2
  };
  RigidMass rigid_mass(const Block& block) const;
  double density_of(const Block& block) const;  // with the mass that is spread, kg/m3
  std::vector<ShapeFacts> shape_facts_;
  std::map<std::array<double, 6>, std::shared_ptr<const geometry::Zoning>> zonings_;
  Ranks* ranks_ = nullptr;          // null: one process alone
  std::vector<int> rank_of_block_;  // with ranks
  std::vector<bool> laid_out_;      // by block
  std::vector<Vector> rough_place_;
  Halo neighbours_;                       // motion of blocks that are close to those of other ranks
  std::vector<double> deviating_blocks_;  // by block, as received from neighbours

  std::vector<ModelBlock> blocks_;
  std::vector<double> block_mass_;  // that has weight, kg
  LaneVector<Body> bodies_;
  LaneVector<Vector> corner_;  // rigid: body frame; deformable: unused (corner gridpoints are used)
  LaneVector<Vector> placed_corner_, placed_normal_;
  LaneVector<Vector> body_normal_;  // rigid: face normals in the body frame
  LaneVector<Pose> start_, broad_;  // of every block's frame at the start, and at the last broad phase

  LaneVector<Vector> node_x_, node_reference_, node_v_;
  LaneVector<double> node_mass_, node_weight_mass_;
  LaneVector<uint8_t> node_held_, node_support_;  // bits 0..2; of held, what a plane of symmetry holds for good
  LaneVector<Vector> node_held_v_;
  LaneVector<Zone> zones_;
  LaneVector<ZoneLanes> zone_lanes_;
  std::vector<CongruentBlocks> congruent_;
  LaneVector<BlockFrame> frames_;    // by block, where it is deformable and in one
  bool frames_are_old_ = true;       // gridpoints have been moved from outside
  LaneVector<Vector> node_anchor_;   // b of blocks in frames of their own; empty: there are none
  std::vector<uint8_t> by_zone_;     // by block: it has deformed too much for a frame
  std::vector<int32_t> other_half_;  // by block: of its unit; -1: none
  std::vector<uint8_t> apart_;       // by block: nothing holds it and its other half together
  int unit_count_ = 0;               // of two halves

  std::vector<Family> families_;
  LaneVector<Facet> facets_;  // family after family, in the order of points
  std::vector<Contact> contacts_;
  std::vector<std::vector<uint32_t>> contacts_of_family_;  // those that have points
  LaneVector<PairPlace> pair_place_;                       // of each contact
  LaneVector<PairCheck> pair_check_;                       // the same
  LaneVector<long> block_check_;                           // step, by block
  std::vector<uint8_t> due_;                               // by block: for a look of now
  LaneVector<SeenMotion> seen_;                            // by body
  std::vector<StartJoint> start_joints_;
  LaneVector<StartPoint> start_point_;
  LaneVector<double> kept_;  // of the last contact point at each of these, kept_width() numbers; empty: nothing yet
  LaneVector<Vector> block_contact_force_;

  std::vector<Chunk> chunks_;            // with contents where this process evaluates them
  std::vector<int> own_chunks_;          // these
  std::vector<double> sides_;            // by block: of contact points, and of pairs of rigid blocks
  std::vector<Touch> touches_;           // block after block, of a block in the order of families and points
  std::vector<uint32_t> touch_end_;      // by block
  std::vector<PairTouch> pair_touches_;  // the same of pairs of rigid blocks
  std::vector<uint32_t> pair_touch_end_;
  ByBlock<OwnerTouch> owner_touches_;  // and of points between gridpoints
  ByBlock<CarrierTouch> carrier_touches_;
  ByBlock<GridpointTouch> gridpoint_touches_;        // of b
  ByBlock<GridpointTouch> owner_gridpoint_touches_;  // of a, points on gridpoints of both
  ByBlock<MomentTouch> moment_touches_;
  LaneVector<FacetRow> facet_rows_;  // of the step, of own chunks: one of a point on gridpoints, three on a triangle
  std::vector<BlockSums> block_sums_;
  std::vector<Piece> pieces_;
  std::vector<uint8_t> in_frame_;  // by block: of a piece in frames
  std::vector<int32_t> piece_blocks_;
  LaneVector<double> piece_columns_;
  std::vector<size_t> shared_columns_;  // of groups, by kind of congruent blocks and whether some gridpoint is held
  std::vector<int32_t> piece_of_block_;
  std::vector<int> held_blocks_changed_;  // deformable, since the last step
  bool held_changed_ = false;             // of any gridpoints
  long divisions_ = 0;                    // how often the work has been divided again
  std::function<void()> fetch_ = [] {};

  std::shared_ptr<members::Members> members_;  // null: none
  ExchangeNodes exchange_nodes_;
  double members_work_ = 0.0;  // of them, that energies_ has, J
  std::vector<Load> loads_;
  std::vector<Pressure> pressures_;
  std::vector<uint8_t> loaded_;  // by block: some load or pressure acts on it
  std::vector<Vector> applied_;  // by block, N
  Vector gravity_;
  TimeSeries gravity_factor_;
  Vector ground_then_, ground_now_;  // m/s

  double skin_ = 0.0, reach_ = 0.0, joint_tolerance_ = 0.0, size_ = 1.0;
  bool small_ = true, energy_ = false, settling_ = false;
  double time_ = 0.0, dt_ = 0.0, critical_dt_ = 0.0, stiffness_bound_ = 0.0;
  double springs_ = 0.0;  // eigenvalue, 1/s2
  // Damping of impacts: viscosity over stiffness, normal and along the joint, family by family, and of zones, s.
  std::vector<double> impact_beta_;
  double impact_zone_beta_ = 0.0;
  double impact_rate_ = 0.0;   // largest eigenvalue of this viscosity over inertia, 1/s
  double impact_share_ = 1.0;  // of what the settings ask for
  std::array<MaxwellElement, kMaxwellElements> maxwell_{};
  long step_count_ = 0, next_check_ = 0, detections_ = 0, narrow_calls_ = 0;
  double check_dt_ = 0.0;      // that checks reckon with, s; another one: all blocks are to be checked
  bool any_deviates_ = false;  // some block in the last step
  double unbalanced_ = 0.0;
  Vector net_;
  Energies energies_;
  HalfStep later_;
  double dissipated_in_step_ = 0.0;  // J
};

}  // namespace quoin::blocks
