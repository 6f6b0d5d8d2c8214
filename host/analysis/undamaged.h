// Vibration of blocks about their state at the start: stiffness and mass of all free components, undamaged.
//
// Every closed contact point has the stiffness of its law for a small compression and a small shear. Zones are linearly
// elastic. Rigid blocks have six degrees of freedom. Stresses are zero: weight does not change stiffness.
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

// Blocks of a scene of any kind, walls and buildings included.
struct SceneBlocks {
  blocks::Assembly assembly;
  double symmetry_factor = 1.0;  // 2 where half of the thickness is modelled
};
SceneBlocks blocks_of(const Scene& scene);

// Velocity of a block for a unit of one degree of freedom: of the whole block, or of one gridpoint.
struct Unknown {
  int block = 0, gridpoint = -1;           // index into Vibrating::drawn; gridpoint -1: a rigid block
  geometry::Vector translation{}, spin{};  // one of them is a unit vector; spin about the centre of mass
  geometry::Vector centre{};               // m
  geometry::Vector at(const geometry::Vector& place) const { return translation + cross(spin, place - centre); }
};

// Points of a block in drawings: gridpoints, or corners of a rigid block. Floors and beams follow the blocks, with
// their nodes.
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
  std::vector<std::string> label;  // names of blocks in messages
  std::vector<std::string> held;   // "bottom_beam: x y z, no rotation"
  std::size_t members = 0;         // number of floors and beams that are drawn
  long points = 0, zones = 0;
  long open = 0;                    // number of points without stiffness; not counted if undamaged
  std::string state = "undamaged";  // or "weight", or the folder of a run
  double symmetry_factor = 1.0;
  double free_mass(int axis) const;  // mass that can move along the axis, kg
};

// Vibration with the supports of a stage: fixed blocks, and components whose velocity its controls prescribe, whatever
// its value. Throws Error(bad_input) where all is held.
Vibrating vibrating(const Scene& scene, int stage = 0);

// Throws Error(bad_input) where nothing can move. file: name of the scene in the message.
void refuse_if_held(const Vibrating& v, const std::string& file);

}  // namespace quoin
