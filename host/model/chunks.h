// Chunks: runs of contact points for one call of their law, with the input of the kernels and the sums of a step.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/vector.h"
#include "law/bound_call.h"
#include "model/contact_points.h"
#include "model/lanes.h"

namespace quoin::blocks {

struct World;

using geometry::Vector;

// Consecutive contact points between two rigid blocks in one plane: their common axes, and the sums of a step.
struct RigidPair {
  int32_t a, b;           // bodies
  uint32_t first, count;  // points of the family
  Vector axis[3];         // n, s, t in a's body frame, unit
  // Results of the last step:
  double in_space[3][4];             // axes in space, one a row; the fourth number is padding
  Vector force, moment_a, moment_b;  // force on a, N; moments on a and on b about their centres, N m
};

// Consecutive contact points of one pair that lie on gridpoints of a deformable block a. Block b is rigid, or they lie
// on its gridpoints too. Axes turn with the frame of block a.
struct GridpointPair {
  int32_t a, b;           // blocks
  int32_t body_b;         // body of b; -1: b is deformable
  uint32_t first, count;  // points of the family
  uint32_t row;           // force of the first point in Chunks::rows, which has one row a point
  uint32_t sums;          // row of the moment on the frame of a; with body_b those of the force and moment on b follow
  Vector axis[3];         // n, s, t in the frame of block a, unit
  bool has_body() const { return body_b >= 0; }
};

// Axes of a pair in space: n, s, t; the fourth number is padding. A step computes them again, which is faster than
// reading them from memory.
struct PairAxes {
  double axis[3][4];
};

// Contact point with one deformable side that is in no GridpointPair. All but its index is of the last step.
struct OtherPoint {
  uint32_t index;           // of the family
  ShapeGradients gradient;  // of the shape functions of a's triangle; in small displacements at rest
  Vector force;             // force on a, in space, viscous part included, N
  double shear[2];          // traction along s and t, viscous part included, Pa
};

// Up to kCount consecutive contact points on triangles, one a lane; lanes from `count` on repeat the last point.
struct FacetLanes {
  static constexpr int kCount = 8;
  uint32_t first, count;  // points of the family
  uint32_t row;           // index into Chunks::rows of the first point's rows; each point has FacetRow::kCount rows
  bool on_gridpoints;     // whether all points lie on the first gridpoint of b's triangle
  int32_t node_a[3][kCount], node_b[3][kCount];
  int32_t facet_a[kCount];  // triangles on block a, to which weight_a is copied back
  alignas(64) double weight_b[3][kCount];
  double reference[kCount], area[kCount];  // m, m2
  double weight_a[3][kCount];              // weights of the point's foot on a's triangle, in the last step
};

// Current frames of the triangles on block a. In large motion a step computes them again, which is faster than reading
// them from memory.
struct FacetFrames {
  static constexpr int kCount = FacetLanes::kCount;
  alignas(64) double n[3][kCount];
  double s[3][kCount], t[3][kCount];
  double slope[3][kCount];  // gradients of shape functions, 1/m: of corner 1 along s, of corners 1 and 2 along t
};

// Force of a contact point on block a, N, in three rows. They are the whole force, and its shares at corners 1 and 2 of
// the triangle on a. Corner 0 has the rest. Block b has the opposite of the whole, by its weights. The fourth number of
// a row is padding.
struct FacetRow {
  static constexpr int kCount = 3;
  double force[4];
};

// Smallest opening of a set of contact points, m, and its place, m.
struct Deepest {
  double opening;
  Vector at;
};

// A run of at most kChunk contact points of one family: one call of its law, and one task of a thread.
struct Chunk {
  int family = 0;
  uint32_t first = 0, count = 0;
  BoundCall call;
  std::vector<RigidPair> pairs;                // pairs of rigid blocks with points in the chunk
  std::vector<GridpointPair> gridpoint_pairs;  // pairs whose points lie on gridpoints
  std::vector<PairAxes> pair_axes;             // axes of gridpoint_pairs; constant in small displacements
  std::vector<int32_t> node_a, node_b;         // gridpoints of these pairs, by point of the chunk
  std::vector<FacetLanes> facets;              // points on triangles
  std::vector<FacetFrames> frames;             // frames of their triangles; constant in small displacements
  std::vector<OtherPoint> others;              // points with one deformable side
  std::vector<double> viscosity[2];            // by point, that of its pair (PairPlace); empty: no impact damping
  uint32_t row_count = 0;                      // number of rows of its points in Chunks::rows
  // For rows of history.csv:
  double force_sum = 0.0;  // sum of the magnitudes of the points' forces, N
  Deepest deepest{};
};
inline constexpr uint32_t kChunk = 256;

// Chunks are divided again when contacts have changed. All ranks have the list.
struct Chunks {
  std::vector<Chunk> all;  // chunks; those that other ranks evaluate have no points bound
  std::vector<int> own;    // chunks that this process evaluates
  // Forces of a step in own chunks: one row for a point on gridpoints, three for a point on a triangle. Those of
  // GridpointPair::sums follow. The last row is zero.
  LaneVector<FacetRow> rows;
  long divisions = 0;  // number of divisions of the work so far
};

// Divides contact points and blocks into chunks and pieces, after contacts have changed. A single process then binds
// them too. Ranks call bind_work after they hold their parts.
void divide_work(World& w);
void bind_work(World& w);
void pack(World& w, Chunk& chunk);
void pack_viscosity(const World& w, Chunk& chunk);
void bind_columns(World& w);
void bind(const World& w, Family& f, Chunk& chunk);

}  // namespace quoin::blocks
