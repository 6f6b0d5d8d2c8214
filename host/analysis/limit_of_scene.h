// Limit analysis of a scene: its blocks rigid, its contact points as a run places them, strengths from its laws.
#pragma once

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

struct LimitOptions {
  std::vector<double> direction;  // direction of the load that is multiplied; empty: that of the first collapse stage
  double given = 0.0;             // multiple of the weight along it that acts beside the weight
  LimitSettings settings = whole_cones();
  bool associated = false;  // no search for answers without dilation
  bool friction = true;     // the smallest scale of friction, too
  bool moving = false;      // the moving load of the first stage that has one is multiplied, at each of its positions
};

// A mass that is pulled along given directions alone, or along all.
struct LimitMass {
  int block = 0;
  double mass = 0.0;                   // kg
  geometry::Vector at;                 // m
  std::vector<geometry::Vector> ways;  // unit, square to each other; none: all
};

// A force that acts always, without mass.
struct LimitLoad {
  int block = 0;
  geometry::Vector at, force;  // m, N
};

// Forces of a member that one strength bounds.
struct LimitMember {
  std::string label, what;       // "floor 'first'", "shear_N_per_m"
  std::vector<std::size_t> of;   // indices into LimitProblem::forces
  std::vector<double> over;      // by which each is divided, m
  std::vector<double> strength;  // strength of each, divided by the same; may be infinite
};

// A floor or beam as it is drawn: its nodes among the blocks, its faces by nodes from 0.
struct LimitBody {
  int first = 0, end = 0;
  std::vector<std::vector<int>> faces;
};

// A moving load at one of its positions.
struct MovingLimit {
  int block = 0;
  geometry::Vector position, at;     // on its line; where it acts, m
  std::optional<double> multiplier;  // none: no multiple moves anything
};

struct SceneLimit {
  geometry::Vector gravity;                   // m/s2
  std::optional<geometry::Vector> direction;  // none: no collapse stage, and none was given
  // Blocks of the scene, then nodes of floors and beams. dead: weight and what is given; live: the weight along the
  // direction.
  LimitProblem problem;
  std::size_t block_count = 0, point_count = 0;  // sizes of the scene
  std::vector<std::string> names, labels;        // blocks' names in the scene, and as messages give them
  std::vector<LimitMass> masses;
  std::vector<LimitLoad> loads;
  std::vector<std::string> tie_names;  // names of the ties, which are the first forces
  std::vector<LimitMember> members;
  std::vector<LimitBody> bodies;

  Stands stands;
  std::optional<LimitWithoutDilation> friction;  // smallest factors without dilation
  std::optional<LimitResult> limit;              // where there is a direction and equilibrium
  std::optional<LimitWithoutDilation> without_dilation;
  // Multiplier left beyond what is given, of associated flow; without a direction the least of four horizontal ones.
  std::optional<double> margin;
  geometry::Vector margin_direction{};
  std::vector<MovingLimit> moving;  // by position; `limit` is then that of the worst one
  std::size_t worst = 0;            // index of the one nearest to its strength
  geometry::Vector moving_force{};  // N
};

// Throws Error(bad_input) where the scene has no gravity, no support, blocks that touch nothing that is held, or laws
// without a limit. Throws Error(numerical) where no multiple of the load moves anything, or the programme was not
// solved.
SceneLimit limit_of(const Simulation& simulation, const LimitOptions& options = {});

// Blocks of a mechanism that needs no load beyond what is given: where the margin is 0.
std::vector<int> moving_without_load(const SceneLimit& limit);

// The largest of what a member carries in these forces (of many that give the multiplier), its strength, and how many
// places are at theirs.
struct MemberForce {
  double largest = 0.0, strength = 0.0;
  int at_strength = 0;
};
MemberForce largest_force(const LimitMember& member, const LimitResult& result);

// What limit.json holds.
nlohmann::ordered_json json_of(const std::string& scene, const SceneLimit& limit, const LimitOptions& options);

// "\n  block #3 'key' at (0, 1, 0) m", of five at most.
std::string blocks_text(const SceneLimit& limit, const std::vector<int>& blocks);

}  // namespace quoin
