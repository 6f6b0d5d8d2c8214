// Scenes of the general path: blocks of any convex shape. A scene file with [[block]], [[dry_wall]], [[arch]] or
// [[mesh]] is one of these; a file with [wall] is a scene of conforming bricks (scene.h). Plain structs in SI units;
// host/scenes/BLOCKS.md lists every key.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace quoin {

struct BlockSpec {
  std::string name, material;
  bool rigid = true, fixed = false;
  double zone_edge = 0.0;                 // m, deformable
  std::array<int, 3> divisions{0, 0, 0};  // deformable bricks, instead of zone_edge
  Vec3 position{0, 0, 0};                 // of the shape's origin, m
  Vec3 rotation{0, 0, 0};                 // vector whose length is the angle, deg
  std::vector<Vec3> vertices;             // own coordinates, m
  std::vector<std::vector<int>> faces;    // empty: the hull of the vertices
  std::optional<Vec3> box_lower, box_size;
  std::string mesh;    // file; every object becomes a block
  double scale = 1.0;  // of the mesh file's lengths
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
  double direction = 0.0;         // of the wall in plan, deg from x towards z
  // Ends of even (0, 2, ...) and odd courses are shortened by these, m: a corner where two walls interlock
  std::array<double, 2> trim_start{0, 0}, trim_end{0, 0};
  bool rigid = true;
  double zone_edge = 0.0;
  struct Opening {  // m along the wall and above its foot
    double from, to, sill, head;
    double bearing;  // of the lintel each side, m; 0: no lintel
  };
  std::vector<Opening> openings;
  Source source;
};

struct ArchSpec {
  std::string name, material;
  Vec3 centre{0, 0, 0};  // of the near face, m; the arch lies in a plane x-y, its depth along z
  double radius = 0.0;   // mean, m
  double thickness = 0.0, depth = 0.0;
  int voussoirs = 0;
  std::array<double, 2> angles{0, 180};  // deg from x
  bool abutments = true;                 // a fixed voussoir beyond either end
  bool rigid = true;
  double zone_edge = 0.0;
  Source source;
};

// First match decides the family of two blocks that meet.
struct JointRule {
  std::string family;                          // "none": the blocks pass through each other
  std::string normal = "any";                  // vertical (bed joints), horizontal (head joints), any
  std::array<std::string, 2> between{"", ""};  // names begin so; empty: any
};

struct SeriesSpec {
  std::vector<double> time, value;
};

struct BlockStage {
  std::string name;
  std::optional<double> duration;           // s
  std::optional<double> equilibrium_ratio;  // largest unbalanced / mean contact force
  long max_steps = std::numeric_limits<long>::max();
  Vec3 gravity{0, 0, 0};   // m/s2
  double ramp_time = 0.0;  // s, of gravity, forces and pressures from those of the stage before
  struct Velocity {
    std::string block;
    Vec3 velocity, omega;  // m/s, rad/s
    std::array<bool, 3> held{true, true, true};
    bool rotation_held = true;
  };
  struct Force {
    std::string block;
    Vec3 point, force;  // m (at the start), N
  };
  struct Pressure {
    std::string block;
    Vec3 normal;      // of the face that is meant
    double pressure;  // Pa, pushes on the block
  };
  struct Ground {
    Vec3 direction;
    SeriesSpec acceleration;  // s, m/s2; moves all fixed blocks
  };
  std::vector<Velocity> velocities;
  std::vector<Force> forces;
  std::vector<Pressure> pressures;
  std::optional<Ground> ground;
  // Body force alpha * |gravity| along `direction`, alpha growing until some block has moved by `displacement`:
  // collapse_multiplier
  struct Collapse {
    Vec3 direction{1, 0, 0};
    double start = 0.0, rate = 0.01;  // alpha is `start` at once, then grows by `rate` 1/s
    double displacement = 0.01;       // m
    double limit = 2.0;               // of alpha: gives up
  };
  std::optional<Collapse> collapse;
  std::optional<SolverSettings> solver;  // damping of this stage
  Source source;
};

struct BlockScene {
  std::string title, file;
  SolverSettings solver;
  std::map<std::string, BlockMaterial> materials;
  std::map<std::string, JointFamily> joints;
  std::vector<BlockSpec> blocks;
  std::vector<DryWallSpec> walls;
  std::vector<ArchSpec> arches;
  std::vector<JointRule> rules;
  std::string default_joint;
  struct Contact {
    double skin = 0.0, joint_tolerance = 0.0, point_spacing = 0.0, small_displacement = 0.005;
    bool cubic_points = false;
  } contact;
  std::vector<BlockStage> stages;
  std::string monitor;  // block whose path the history shows
  int frames = 20;
  double record_interval = 0.0;  // s; 0: 500 rows a stage
  bool energy = true, picture = true;
};

// Whether the file describes blocks of the general path. Throws as read_scene for files that are no TOML.
bool is_block_scene(const std::string& path);
BlockScene read_block_scene(const std::string& path, const std::vector<std::string>& overrides = {});

}  // namespace quoin
