// Blocks that vibrate about their state at the start: stiffness and mass of all that can move, undamaged.
//
// Every contact point that is closed has the stiffness that its law gives a little compression and a little shear;
// zones are linearly elastic. Rigid blocks have six degrees of freedom. Nothing is stressed: weight has no part in
// stiffness.
#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "geometry/vector.h"
#include "scene/blocks.h"
#include "scene/scene.h"
#include "sparse/sparse_cholesky.h"

namespace quoin {

// Everything that a scene holds, as blocks; walls and buildings, too.
struct SceneBlocks {
  blocks::Assembly assembly;
  double symmetry_factor = 1.0;  // 2 where half of the thickness is modelled
};
SceneBlocks blocks_of(const Scene& scene);

// Velocity with which a degree of freedom moves a block: of all of it, or of one gridpoint.
struct Unknown {
  int block = 0, gridpoint = -1;           // index of what is drawn; -1: a rigid block
  geometry::Vector translation{}, spin{};  // one of them a unit vector; spin about the centre of mass
  geometry::Vector centre{};               // m
  geometry::Vector at(const geometry::Vector& place) const { return translation + cross(spin, place - centre); }
};

// Where a block is drawn: gridpoints, of rigid blocks corners. Floors and beams follow the blocks, with their nodes.
struct DrawnBlock {
  std::vector<geometry::Vector> point;  // m
  std::vector<std::array<int, 4>> zone;
  std::vector<std::vector<int>> face;  // faces of its shape
  bool held = false;
};

struct Vibrating {
  Eigen::SparseMatrix<double> stiffness;  // lower triangle, N/m, N m
  std::vector<double> mass;               // diagonal, kg, kg m2
  std::vector<Unknown> unknown;
  UnknownGroups groups;
  std::vector<DrawnBlock> drawn;
  std::vector<std::string> label;  // names of blocks, as messages give them
  std::vector<std::string> held;   // "bottom_beam: x y z, no rotation"
  std::size_t members = 0;         // number of floors and beams that are drawn
  long points = 0, zones = 0;
  long open = 0;                    // number of points that carry nothing; of the undamaged scene not counted
  std::string state = "undamaged";  // or "weight", or the folder of a run
  double symmetry_factor = 1.0;
  double free_mass(int axis) const;  // mass that can move along the axis, kg
};

// Index of the stage of that name; empty: the first. Throws Error(bad_input): none has it.
int stage_named(const Scene& scene, const std::string& name);

// With the supports of a stage: fixed blocks, and what its controls give a velocity, whatever that is.
// Throws Error(bad_input) where nothing can move.
Vibrating vibrating(const Scene& scene, int stage = 0);

// Throws Error(bad_input) where nothing can move. file: name of the scene in the message.
void refuse_if_held(const Vibrating& v, const std::string& file);

}  // namespace quoin
