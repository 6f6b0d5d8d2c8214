// A scene: all input of a run, as plain structs in SI units (m, kg, s, Pa). read_scene.h reads it from TOML. Generators
// turn its walls and blocks into an Assembly (assembly.h), from which host/model makes the arrays of a run.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/time_series.h"
#include "base/vec3.h"
#include "properties/from_tests.h"
#include "random/distribution.h"
#include "scene/cyclic_motion.h"
#include "scene/damping.h"

namespace quoin {

// Place of a value: "scene.toml:12: joints.mortar.cohesion". Empty: a default. Values of --set have "--set".
struct Source {
  std::string text;
};

// Extent over which a random property has one value. unit includes the joints below and beside it.
enum class ScatterLevel { point, joint, unit, course, wall };

// Random distribution of a property over places of the masonry.
struct Scatter {
  random::Distribution distribution;
  ScatterLevel level = ScatterLevel::joint;
  double correlation_length = 0.0;  // m along the wall, between places of one course; 0: independent
  bool of_joint_mean = false;       // whether the distribution, at level point, is that of the mean over a joint
};

struct PropertySetting {
  std::string id;
  std::vector<double> numbers;  // a number has one (the mean, if random), a table has pairs, a choice has none
  std::string text;             // choices
  Source source;
  std::optional<Scatter> scatter{};
};

// Correlation of two random properties, between the normal variables from which they are computed.
struct PropertyCorrelation {
  std::string first, second;
  double value = 0.0;
};

// Number of a random sample of the wall.
struct RandomSample {
  std::uint64_t seed = 1;
  std::uint64_t sample = 1;  // 0: the mean of everything
};

// Contact points in joints of rigid blocks. corners: corners alone, about which a dry block turns. cubic: points that
// integrate cubic stresses, and so bending, exactly. cubic_at_start: cubic in joints of the start, corners in later
// contacts, which are dry.
enum class RigidPoints { corners, cubic_at_start, cubic };

// A joint family: all contact points that share one law and one set of properties.
struct JointFamily {
  std::string name;  // "mortar", "unit"
  std::string law;   // name of a shipped law or path of a library
  std::string initial_state = "bonded";
  std::vector<PropertySetting> properties;
  Source source, initial_state_source;

  std::vector<PropertyCorrelation> correlation{};
  double missing_mortar = 0.0;                      // share of joints without mortar, at random
  RigidPoints rigid_points = RigidPoints::corners;  // choice of choose_rigid_points() (model/motion.h)
  RandomSample random{};
  bool scatters() const {
    return std::any_of(properties.begin(), properties.end(), [](const auto& p) { return p.scatter.has_value(); });
  }
  bool is_random() const { return missing_mortar > 0.0 || scatters(); }
};

struct BlockMaterial {
  std::string name;
  double young_modulus = 0.0;  // Pa
  double poisson_ratio = 0.0;
  double density = 0.0;  // kg/m3
};

// Computation of internal forces of deformable blocks. assembled: the assembled stiffness of a shape, for 8 congruent
// blocks at a time. zones: zone by zone and block by block, as for blocks without congruent ones. automatic: zones
// where a group has few blocks.
enum class InternalForces { automatic, assembled, zones };

// Reference of the fraction of the time step. assembled: 2/omega_max, the true limit. nodal: eq. 3 read literally, 2
// sqrt(m/k) with the diagonal stiffness of a gridpoint; unstable for blocks of several zones.
enum class CriticalTimeStep { assembled, nodal };

// Choice between small displacements and large motion. automatic: on the lattice, small displacements and promotion to
// large motion beyond the bound; large motion of other blocks. never: small displacements, and beyond the bound a stop
// or a warning. always: large motion from the start.
enum class LargeMotion { automatic, never, always };

// Choice of the kernels that move blocks. lattice: vectorised ones, for conforming bricks in small displacements.
// general: for blocks of any shape. automatic: the lattice for walls and buildings, else the choice of model/motion.h.
enum class Kernels { automatic, lattice, general };

// Bound up to which small displacements give curves within 1 % of those of large motion (benchmarks/README.md).
struct MotionBound {
  double rotation = 0.013;  // of a block, rad
  double sliding = 0.03;    // of two blocks on each other, over the length of their joint
  bool stop = true;         // whether a run with LargeMotion::never stops beyond it; else it warns
};

struct SolverSettings : DampingSettings {
  double time_step_fraction = 0.6;  // share of the critical time step of the undamaged assembled system
  CriticalTimeStep critical_time_step = CriticalTimeStep::assembled;
  double mass_scaling = 1.0;         // factor on inertia (not on weight); 1: none
  double selective_time_step = 0.0;  // s; > 0: nodal inertia is increased only where this time step requires it
  double deformation_inertia = 1.0;  // factor on the inertia against deformation of blocks (model/rigid_motion.h)
  double unit_inertia = 1.0;         // factor on the inertia against motion of the two halves of a unit on each other
  InternalForces internal_forces = InternalForces::automatic;
  bool skip_resting_bodies = true;  // whether rigid blocks that controls hold at rest are left out of the step
  LargeMotion large_motion = LargeMotion::automatic;
  MotionBound motion_bound;
  Kernels kernels = Kernels::automatic;
};

enum class DofKind { free, velocity };

// Control of the bodies of one name (a beam, a row of rigid units, a block) during a stage, component by component.
// Deformable blocks of walls and buildings can be loaded but not held. Their gridpoints share the force by mass.
struct BodyControl {
  std::string body;  // "top_beam", "top_course"
  std::array<DofKind, 3> kind{DofKind::velocity, DofKind::velocity, DofKind::velocity};
  Vec3 velocity{0.0, 0.0, 0.0};  // m/s, for components of kind velocity
  Vec3 force{0.0, 0.0, 0.0};     // N, for free components
  bool may_turn = false;         // whether rotations are free; else held
  Vec3 omega{0.0, 0.0, 0.0};     // rad/s, of held rotations; blocks of any shape only
  int in_cycles = -1;            // component that follows Stage::cycles; -1: none
  bool operator==(const BodyControl&) const = default;
};

// A force that moves with a point of a block; its direction is constant.
struct PointForce {
  std::string block;
  Vec3 point, force;  // m, where it acts at the start; N
  bool operator==(const PointForce&) const = default;
};

// A force that moves along a line. At each position it acts on the first face on its line of action.
struct MovingLoad {
  Vec3 from{}, to{}, force{};  // m, m, N
  int positions = 41;          // number of places from one end to the other
};

// Pressure on the face of a block whose outward normal is closest to `normal`; it moves with the face.
struct FacePressure {
  std::string block;
  Vec3 normal;
  double pressure;  // Pa, > 0 pushes on the block
  bool operator==(const FacePressure&) const = default;
};

// Motion of all fixed blocks, along one direction or several. Accelerations are integrated exactly. Displacements are
// converted to the accelerations of the spline through them.
struct GroundMotion {
  struct Component {
    Vec3 direction;           // vector of any length
    TimeSeries acceleration;  // s since the start of the stage, m/s2
    RunningIntegral velocity;
  };
  std::vector<Component> components;
  std::vector<std::string> notes;  // assumptions where files do not state something, and scale factors
  // Groups of fixed blocks with another motion.
  std::vector<std::string> blocks;     // fixed blocks of this group
  std::vector<GroundMotion> supports;  // groups, without groups of their own
};

// Body force alpha |gravity| along `direction`. alpha grows until some block has moved by `displacement`; it is then
// the collapse multiplier.
struct Collapse {
  Vec3 direction{1, 0, 0};
  // alpha grows to `start` over the ramp, then by `rate` 1/s. No start: limit analysis finds it before the run
  // (analysis/collapse_start.h). No rate: alpha grows in increments, between which blocks come to rest
  // (collapse_load.h).
  std::optional<double> start = 0.0, rate = 0.01;
  double displacement = 0.01;  // m
  // Alpha at which the stage ends without collapse; none: limit analysis finds it before the run.
  std::optional<double> limit = 2.0;
};

// A virtual whiffletree: equal forces along x on all floors, F = stiffness (u - mean of the floors' displacements). u
// has the given velocity, or follows the cycles of the stage. The bodies of a floor share its force equally. So a
// displacement is imposed, floors have equal forces, and softening is stable. The displacement of a floor is the mean
// of its bodies. The last floor is the roof. The history has its displacement and the shear force at the bottom beam.
struct Whiffletree {
  std::vector<std::vector<std::string>> floors;  // bodies of each floor
  double stiffness = 0.0;                        // N/m
  double velocity = 0.0;                         // m/s
};

// A stage ends when its first criterion is met. read_scene refuses stages that could never end.
struct Stage {
  std::string name;
  std::string kind;  // kind as read: pressure, shear, weight, push, cycles, rest, custom
  std::vector<BodyControl> controls;
  bool has_no_control = false;  // custom stage without [[stage.control]]: the bottom beam is held
  Vec3 gravity{0.0, 0.0, 0.0};  // m/s2
  double ramp_time = 0.0;       // s; velocities and forces change smoothly from those of the stage before

  // Largest unbalanced force of a gridpoint or body, over the mean contact force, at which the stage ends. Several
  // checks in a row must find it (step/stages.cpp).
  std::optional<double> equilibrium_ratio;
  // Displacement of `monitor` along `direction`, since the start of the stage, at which it ends, m.
  std::optional<double> displacement;
  std::optional<double> duration;                     // s; for cycles: their duration
  long max_steps = std::numeric_limits<long>::max();  // without equilibrium by then: numerical failure

  // History rows of this stage: mean displacement and sum of forces of the bodies named `monitor`, along direction 0,
  // 1, 2.
  std::string monitor;
  int direction = 0;
  long record_interval = 0;   // steps; 0: chosen for about 1000 rows in the stage
  std::optional<int> frames;  // number of frames, in place of OutputSettings::frames; 0: none

  std::vector<std::string> roof;  // bodies whose mean displacement rows have, in place of the monitor's; empty: none
  std::optional<Whiffletree> whiffletree;  // `displacement` is then that of the roof
  std::optional<Cycles> cycles;            // cycles of the whiffletree, or of controls
  std::vector<PointForce> forces;
  std::optional<MovingLoad> moving_load;
  std::vector<FacePressure> pressures;
  std::optional<GroundMotion> ground;
  std::optional<Collapse> collapse;
  // Settings from this stage on. Keys that its solver table leaves out stay as in the stage before. None: no solver
  // table.
  std::optional<SolverSettings> solver;

  std::map<std::string, std::string> law_swaps;  // joint family -> law that replaces its law at the start of the stage
  Source source;
};

// beyond_lattice: first action of a stage that the lattice does not support, as messages have it: "moves the ground".
// Empty: none. action_texts: all actions of the stage with their main numbers (scene/actions).
std::string beyond_lattice(const Stage& stage);
std::vector<std::string> action_texts(const Stage& stage);

// Wall of rectangular units, generated in the plane z = 0 .. thickness, lower left corner at the origin.
struct WallSpec {
  std::string bond = "running";        // running, stack
  std::string first_course = "whole";  // the bottom course starts with a whole or a half unit
  int courses = 0;
  double units_per_course = 0.0;      // multiples of one half
  Vec3 unit{0.0, 0.0, 0.0};           // expanded unit: length x, height y, thickness z, m
  std::array<int, 3> zones{4, 2, 2};  // hexahedra of 5 zones per half unit along x, y, z
  bool mid_unit_joints = true;        // half units joined by the family unit_joint; false: whole units
  bool rigid_units = false;           // rigid units; bodies of the outer courses: "bottom_course", "top_course"
  std::string unit_material;
  std::string bed_joint, head_joint, unit_joint, beam_joint;  // joint families
  struct Opening {                                            // place in half units and courses, from the lower left
    int first_half_unit = 0, half_units = 0, first_course = 0, courses = 0;
    // Bearing of the lintel beyond either side of the opening, in half units. The lintel is a block of its own in the
    // course above the opening. 0: none.
    int bearing = 0;
    std::string lintel_material;  // empty: that of the units
    bool covers(int course, int half_unit) const {
      return course >= first_course && course < first_course + courses && half_unit >= first_half_unit &&
             half_unit < first_half_unit + half_units;
    }
    int lintel_course() const { return first_course + courses; }
    int lintel_first() const { return first_half_unit - bearing; }
    int lintel_length() const { return half_units + 2 * bearing; }
    bool lintel_covers(int course, int half_unit) const {
      return bearing > 0 && course == lintel_course() && half_unit >= lintel_first() &&
             half_unit < lintel_first() + lintel_length();
    }
  };
  std::vector<Opening> openings;
  // A unit that is missing or of another material, by its course and any of its half units.
  struct Changed {
    int course = 0, half_unit = 0;
    std::string material;  // empty: missing
  };
  std::vector<Changed> changed;
  double beam_height = 0.1, beam_density = 7850.0;  // rigid beams below and above
  // Height above the foot of the wall at which loads and motions act on the top beam, m. It is that of an actuator on a
  // stiff frame. None: the middle of the beam.
  std::optional<double> load_height;
  bool bottom_beam = true, top_beam = true;
  std::vector<int> bottom_beam_cuts;  // half units from the left, growing: cuts into independent parts
  // Bodies "bottom_beam", or "bottom_beam_1", "bottom_beam_2", ... of its parts.
  std::vector<std::string> bottom_beams() const;
  bool half_thickness = false;  // model z >= mid-plane only, u_z = 0 there; forces reported for the whole wall
};

// Walls at right angles with interlocked corners, openings, and bodies that carry floor beams. All walls share courses
// and thickness. Half units of a wall form columns; units are in running bond.
struct BuildingSpec {
  int courses = 0;
  double course_height = 0.0, thickness = 0.0;  // m
  std::array<int, 3> zones{4, 2, 2};            // hexahedra per half unit: along the wall, up, through the thickness
  std::string unit_material, bed_joint, head_joint, unit_joint, beam_joint;
  double beam_height = 0.1, beam_density = 7850.0;  // one rigid beam below everything: "bottom_beam"
  struct Wall {
    std::string name;
    int axis = 0;                   // 0 along x, 2 along z
    std::array<double, 2> start{};  // x and z of the lowest corner, m
    int half_units = 0;
    double half_unit = 0.0;              // m
    std::string first_course = "whole";  // first unit of the bottom course: whole, half
    std::vector<WallSpec::Opening> openings;
    Source source;
  };
  std::vector<Wall> walls;
  // A square of the wall's thickness between the ends of two walls. In the bottom course and every other one it is part
  // of a unit of the wall `first`. In the other courses it is part of a unit of the wall `second`.
  struct Corner {
    std::array<double, 2> at{};  // x and z of its lowest corner, m
    int first = 0, second = 0;   // indices of walls
    Source source;
  };
  std::vector<Corner> corners;
  // Beams of a floor: bodies NAME_1, NAME_2, ... in place of half units of one course, which share `load`. They are
  // those half units, whose gridpoints share the force, or rigid beams in mortar.
  struct Floor {
    std::string name;
    int wall = 0, course = 0;
    std::vector<int> half_units;
    double load = 0.0;  // N
    double mass = 0.0;  // kg; its weight is additional to the load
    Source source;
    bool rigid = true;
    std::vector<std::string> bodies() const;
  };
  std::vector<Floor> floors;
};

// Whether walls touch without a corner between them. The lattice has no joint there.
bool has_walls_that_touch(const BuildingSpec& building);
// Bodies of the building's floor of this name; else the name alone.
std::vector<std::string> bodies_called(const std::string& name, const BuildingSpec& building);

// One convex block, or all objects of a mesh file.
struct BlockSpec {
  std::string name, material;
  bool rigid = true, fixed = false;
  double zone_edge = 0.0;                      // m, deformable
  std::array<int, 3> divisions{0, 0, 0};       // deformable bricks, instead of zone_edge
  Vec3 position{0, 0, 0};                      // place of the shape's origin, m
  Vec3 rotation{0, 0, 0};                      // vector whose length is the angle, deg
  std::vector<Vec3> vertices;                  // own coordinates, m
  std::vector<std::vector<int>> faces;         // empty: the hull of the vertices
  std::vector<std::array<int, 4>> tetrahedra;  // tetrahedra of the vertices that are the zones; empty: own zones
  std::optional<Vec3> box_lower, box_size;
  std::string mesh;  // name of a file; each object in it is a block
  // Names of fixed blocks of the mesh, with or without the prefix of this table's name.
  std::vector<std::string> fixed_names;
  double scale = 1.0;  // factor on the mesh file's lengths
  std::string unit;    // blocks with equal text are parts of one masonry unit
  Source source;
};

// Wall of rectangular units in a vertical plane. Several of them with toothed ends make interlocked corners.
struct DryWallSpec {
  std::string name, material;
  std::string bond = "running";        // running (half-lap), third, stack
  std::string first_course = "whole";  // whole, half
  int courses = 0;
  double units_per_course = 0.0;  // multiples of one half
  Vec3 unit{0, 0, 0};             // length, height, thickness, m
  Vec3 origin{0, 0, 0};           // lower corner, m
  double direction = 0.0;         // direction of the wall in plan, deg from x towards z
  // Lengths cut from the ends of even (0, 2, ...) and odd courses, m, at a corner where two walls interlock.
  std::array<double, 2> trim_start{0, 0}, trim_end{0, 0};
  bool rigid = true;
  double zone_edge = 0.0;
  std::array<int, 3> zones{0, 0, 0};  // deformable: hexahedra of 5 zones per half unit, instead of zone_edge
  bool mid_unit_joints = false;       // whether units are halved: two blocks of one masonry unit
  struct Opening {                    // m along the wall and above its foot
    double from, to, sill, head;
    double bearing;  // bearing of the lintel on each side, m; 0: no lintel
  };
  std::vector<Opening> openings;
  Source source;
};

struct ArchSpec {
  std::string name, material;
  Vec3 centre{0, 0, 0};  // centre of the near face, m; the arch lies in a plane x-y, its depth along z
  double radius = 0.0;   // mean, m
  double thickness = 0.0, depth = 0.0;
  int voussoirs = 0;
  std::array<double, 2> angles{0, 180};  // deg from x
  bool abutments = true;                 // whether a fixed voussoir lies beyond either end
  bool rigid = true;
  double zone_edge = 0.0;
  Source source;
};

// Rule for the joint family of two blocks in contact. The first that fits applies.
struct JointRule {
  std::string family;                          // name of the family; "none": the blocks pass through each other
  std::string normal = "any";                  // vertical (bed joints), horizontal (head joints), any
  std::array<std::string, 2> between{"", ""};  // prefixes of the names of the two blocks; empty: any
  bool inside_units = false;                   // whether the rule is for parts of one masonry unit alone
};

// Blocks of any convex shape.
struct BlocksSpec {
  std::vector<BlockSpec> blocks;
  std::vector<DryWallSpec> walls;
  std::vector<ArchSpec> arches;
  std::vector<JointRule> rules;
  std::string default_joint;  // family of pairs that no rule fits, or "none"
  struct Contact {
    double skin = 0.0, joint_tolerance = 0.0, point_spacing = 0.0, small_displacement = 0.005;
  } contact;
};

// Damage of joints before the first stage. Later damage is added to earlier damage.
struct Damage {
  std::vector<std::string> joints;                             // families; empty: all
  Vec3 from{-1e300, -1e300, -1e300}, to{1e300, 1e300, 1e300};  // m; box of the contact points
  // m, along the wall and up: a line that the crack follows, along joints between units with centres on its two sides.
  // Empty: all joints in the box.
  std::vector<std::array<double, 2>> crack;
  int crack_along = 0;                  // 0: the wall runs along x, 2: along z
  bool through_units = false;           // whether the crack cuts units too; else it passes between them
  std::string initial_state;            // initial state of the law; empty: that of the joint
  std::optional<double> xi;             // value of all internal softening variables of the law
  std::map<std::string, double> state;  // state variables of the law, by the law's names
  double slip = 0.0;                    // m; slip without pressure
  std::optional<double> opening;        // m; initial opening of the joint; none: that of an earlier entry, or 0
  Source source;
};

struct OutputSettings {
  int frames = 20;                // VTU frames over a stage; 0: none
  bool all_stages = true;         // whether all stages have frames; else only the last one
  double frames_at_damage = 0.0;  // growth of joint_damage from which on another frame is due; 0: none for that
  bool plots = true;
  bool energy = false;           // energies by mode in history.csv
  std::string monitor;           // block of the history; empty: the stages' own monitors
  double record_interval = 0.0;  // s between rows of the history; 0: that of the stages
  bool pieces = false;           // whether each rank writes its own blocks of a frame
  bool end_state = false;        // whether the run writes end_state.bin, from which other scenes can begin
};

// Mass of a block in addition to that of its volume: floors, roofs, machines. Blocks with the same name share it.
struct AddedMass {
  std::string block;
  double mass = 0.0;          // kg
  std::optional<Vec3> point;  // m, at the start; it moves with the block; none: mass distributed over the block
  Source source;
};

// A monitor of a run, [[monitor]] of a scene, in addition to those of its stages.
struct Monitor {
  std::string name;           // name of its columns
  std::string block;          // name of a block, of a body, or of a floor
  std::optional<Vec3> point;  // m; nearest corner or gridpoint at the start; none: mean of all
  std::string below;          // monitor against which its drift is measured; empty: none
  Source source;
};

struct MemberSpecs;  // members.h

struct Scene {
  // Number of frames of a stage, without the one at its begin.
  int frames_in(std::size_t stage) const {
    if (stages[stage].frames) return *stages[stage].frames;
    return output.all_stages || stage + 1 == stages.size() ? output.frames : 0;
  }
  // Whether a stage has frames where damage grows, in addition.
  bool frames_follow_damage_in(std::size_t stage) const {
    const bool usual = output.all_stages || stage + 1 == stages.size();
    return output.frames_at_damage > 0.0 && stages[stage].frames.value_or(usual) > 0;
  }
  bool has_frames() const {
    for (std::size_t i = 0; i < stages.size(); ++i)
      if (frames_in(i) > 0 || frames_follow_damage_in(i)) return true;
    return false;
  }
  std::string title, file;
  std::string text;                 // text of the file, as read
  std::vector<std::string> inputs;  // other files that it reads: meshes, series
  std::string quality;              // quality whose settings are the defaults; empty: none
  bool quality_as_is = true;        // whether no setting of the quality is changed, so that its errors apply
  SolverSettings solver;
  std::map<std::string, BlockMaterial> materials;
  std::map<std::string, JointFamily> joints;
  RandomSample random{};
  std::optional<WallSpec> wall;  // or a building; blocks of any shape may stand beside either, or alone
  std::optional<BuildingSpec> building;
  std::optional<BlocksSpec> blocks;
  std::optional<bool> cubic_points;  // key for rigid blocks; none: cubic where joints carry tension at the start
  std::shared_ptr<const MemberSpecs> members;  // null: none
  std::vector<AddedMass> masses;               // added masses, those of floors included
  std::vector<Damage> damage;
  std::string start;  // folder of the run whose end state is the initial state; empty: at rest
  // Text of the tables of joints, contacts and members, by name; a scene that starts from a run has the same.
  std::map<std::string, std::string> arrangement;
  std::vector<Stage> stages;
  bool had_ground = false;  // whether stages that at_rest() has left out stand on the ground
  OutputSettings output;
  std::vector<Monitor> monitors;       // they serve results alone
  std::vector<Derivation> derivation;  // how properties follow from tests, to be shown; empty: no [tests]

  // Settings of a stage; for an index past the last stage, those of the last one.
  const SolverSettings& solver_in(std::size_t stage) const {
    for (std::size_t i = std::min(stage + 1, stages.size()); i > 0; --i) {
      if (stages[i - 1].solver) return *stages[i - 1].solver;
    }
    return solver;
  }
};

}  // namespace quoin
