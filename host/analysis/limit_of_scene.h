// Limit analysis of a scene: rigid blocks, contact points as in a run, strengths from its laws.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "analysis/limit.h"
#include "analysis/stands.h"
#include "analysis/without_dilation.h"
#include "scene/scene.h"

namespace quoin {

class Simulation;

inline LimitSettings whole_cones() {
  LimitSettings settings;
  settings.facets = 0;
  return settings;
}

// The load that is multiplied: the weight along a direction, or loads of a stage. loads: forces, pressures, and forces
// on bodies. motion: a force of 1 N along the motion that the stage prescribes, or equal ones on the floors that it
// pushes.
enum class Multiplied { weight, forces, pressures, loads, motion };

const char* name_of(Multiplied multiplied);
// Throws Error(bad_input) for other names.
Multiplied multiplied_named(const std::string& name);

struct LimitOptions {
  std::vector<double> direction;  // direction of the multiplied weight; empty: that of the first collapse stage
  double given = 0.0;             // multiple of the multiplied load that acts as a constant load
  LimitSettings settings = whole_cones();
  bool associated = false;       // whether to skip the analysis without dilation
  bool friction = true;          // whether to compute the smallest factor on friction too
  bool moving = false;           // whether to multiply the first stage's moving load, at each of its positions
  const Stage* stage = nullptr;  // stage whose gravity and loads count; null: the first that fits what is multiplied
  Multiplied multiplied = Multiplied::weight;
  // Time for each of three parts, s: stability and the associated multiplier; the two sequences without dilation.
  double seconds = 300.0;
};

// Prints what is being solved, every two seconds. From several threads.
std::function<void(const std::string&)> notices_of_progress(const std::string& file);

// A mass that acts along given directions only, or along all.
struct LimitMass {
  int block = 0;
  double mass = 0.0;                   // kg
  geometry::Vector at;                 // m
  std::vector<geometry::Vector> ways;  // unit, perpendicular to each other; empty: all directions
};

// A force without mass.
struct LimitLoad {
  int block = 0;
  geometry::Vector at, force;  // m, N
  bool live = false;           // whether it is multiplied; else constant
};

// Forces of a member with one strength.
struct LimitMember {
  std::string label, what;       // "floor 'first'", "shear_N_per_m"
  std::vector<std::size_t> of;   // indices into LimitProblem::forces
  std::vector<double> over;      // divisor of each, m
  std::vector<double> strength;  // strength of each, over the same divisor; may be infinite
};

// A drawn floor or beam: its nodes are a range of blocks, its faces have node numbers from 0.
struct LimitBody {
  int first = 0, end = 0;
  std::vector<std::vector<int>> faces;
};

// A moving load at one of its positions.
struct MovingLimit {
  int block = 0;
  geometry::Vector position, at;     // point on its line; point of action, m
  std::optional<double> multiplier;  // none: no multiple makes a mechanism
};

struct SceneLimit {
  geometry::Vector gravity;                   // m/s2
  std::optional<geometry::Vector> direction;  // of the multiplied weight; none: no collapse stage, and none given
  std::string stage;                          // whose gravity and loads count
  geometry::Vector live_force{};              // sum of the multiplied forces and pressures, N
  bool halved = false;                        // half of the thickness is modelled: nothing leaves its plane of symmetry
  // Blocks of the scene, then nodes of floors and beams. dead: weight and constant loads; live: what is multiplied.
  LimitProblem problem;
  std::size_t block_count = 0, point_count = 0;  // sizes of the scene
  // Reaction along the prescribed motion, where that is multiplied: it holds what moves while stability is found.
  std::optional<LimitForce> reaction;
  std::vector<int> supports;               // blocks that the stage holds or moves
  std::size_t edge_count = 0;              // pairs of blocks that meet along edges, whose points are left out
  std::vector<std::string> names, labels;  // names of blocks in the scene, and in messages
  std::vector<std::string> families;       // names of joint families
  std::vector<LimitMass> masses;
  std::vector<LimitLoad> loads;
  std::vector<geometry::Vector> load_places;  // of the scene's blocks, where loads on a body act, m
  std::vector<std::string> tie_names;         // names of the ties, which are the first forces
  std::vector<LimitMember> members;
  std::vector<LimitBody> bodies;

  Stands stands;
  std::optional<LimitWithoutDilation> friction;  // smallest factors on friction without dilation
  std::optional<LimitResult> limit;              // if there is a direction and equilibrium
  std::optional<LimitWithoutDilation> without_dilation;
  // Multiplier left beyond `given`, of associated flow; without a direction the smallest of four horizontal ones (two
  // where halved).
  std::optional<double> margin;
  geometry::Vector margin_direction{};
  std::vector<MovingLimit> moving;  // by position; `limit` is then that of the worst position
  std::size_t worst = 0;            // index of the position with the smallest multiplier
  geometry::Vector moving_force{};  // N
};

// Relative motion of two blocks at their joint, in a mechanism.
struct JointMotion {
  int a = 0, b = 0, family = 0;
  // Largest rates of its points, over the largest of all joints. opening: beyond the dilation of sliding.
  double opening = 0.0, sliding = 0.0, crushing = 0.0;
  bool hinges = false;  // whether it opens at some points and stays closed at others
};

// Joints that move in the mechanism, the fastest first.
std::vector<JointMotion> joint_motions(const SceneLimit& limit);

// The scene for a simulation that limit_of() is to have. The lattice replaces forces and pressures by forces on bodies;
// so what multiplies them has blocks of any shape.
Scene for_limit(Scene scene, Multiplied multiplied);

// Throws Error(bad_input) where the scene has no gravity or no support. So it does where blocks touch nothing that is
// held, or laws have no limit. Throws Error(numerical) where no multiple of the load makes a mechanism, or the
// programme was not solved.
SceneLimit limit_of(const Simulation& simulation, const LimitOptions& options = {});

// Blocks of a mechanism under the constant loads alone, where the margin is 0.
std::vector<int> moving_without_load(const SceneLimit& limit);

// Largest force of a member in this solution (one of many that give the multiplier), its strength, and the number of
// its places at strength.
struct MemberForce {
  double largest = 0.0, strength = 0.0;
  int at_strength = 0;
};
MemberForce largest_force(const LimitMember& member, const LimitResult& result);

// Contents of limit.json.
nlohmann::ordered_json json_of(const std::string& scene, const SceneLimit& limit, const LimitOptions& options);

// "
//   block #3 'key' at (0, 1, 0) m", for at most five blocks.
std::string blocks_text(const SceneLimit& limit, const std::vector<int>& blocks);

}  // namespace quoin
