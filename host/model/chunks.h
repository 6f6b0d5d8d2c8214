// Contact points in runs for one call of their law: what kernels read of them, and what a step adds up.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/vector.h"
#include "law/law_library.h"
#include "model/contact_points.h"
#include "model/lanes.h"

namespace quoin::blocks {

struct World;

using geometry::Vector;

// Points in a row between two rigid blocks, in one plane: what they share, and what they add up to.
struct RigidPair {
  int32_t a, b;           // bodies
  uint32_t first, count;  // points of the family
  Vector axis[3];         // n, s, t in a's body frame, unit
  // Numbers of the last step:
  double in_space[3][4];             // the axes; the fourth has no meaning
  Vector force, moment_a, moment_b;  // force on a, N; moments about the centre of a, on a, and of b, on b, N m
};

// Points in a row of one pair of deformable blocks, which sit on gridpoints of both. Axes turn with the frame of block
// a.
struct GridpointPair {
  int32_t a, b;           // blocks
  uint32_t first, count;  // points of the family
  uint32_t row;           // force of the first point in Chunks::rows, which has one row a point
  Vector axis[3];         // n, s, t in the frame of block a, unit
  Vector moment;          // moment of the last step on the frame of block a, which turns the axes, N m
};

// The axes of a pair in space: n, s, t; the fourth number has no meaning. A step forms them again: they never leave the
// cache.
struct PairAxes {
  double axis[3][4];
};

// A point with one deformable side. Of the last step but for its index:
struct OtherPoint {
  uint32_t index;           // of the family
  ShapeGradients gradient;  // of the triangle of a; in small displacements of its shape at rest
  Vector force;             // force on a, in space, viscous part included, N
  double shear[2];          // traction along s and t that goes with it, Pa
};

// Up to kCount points in a row on triangles, lane by lane; those beyond `count` repeat the last one.
struct FacetLanes {
  static constexpr int kCount = 8;
  uint32_t first, count;  // points of the family
  uint32_t row;           // index into Chunks::rows of the first point's rows; a point has FacetRow::kCount of them
  bool on_gridpoints;     // all points sit on the first gridpoint of b's triangle
  int32_t node_a[3][kCount], node_b[3][kCount];
  int32_t facet_a[kCount];  // triangles of block a, which take the weights back
  alignas(64) double weight_b[3][kCount];
  double reference[kCount], area[kCount];  // m, m2
  double weight_a[3][kCount];  // weights of the point's foot on the triangle that owns the plane, in the last step
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
  std::vector<quoin_property_column> properties;  // properties that scatter
  std::vector<RigidPair> pairs;                   // pairs of rigid blocks with points in the chunk
  std::vector<GridpointPair> gridpoint_pairs;     // pairs whose points lie on gridpoints of both blocks
  std::vector<PairAxes> pair_axes;                // axes of gridpoint_pairs; constant in small displacements
  std::vector<int32_t> node_a, node_b;            // gridpoints of these pairs, by point of the chunk
  std::vector<FacetLanes> facets;                 // points on triangles
  std::vector<FacetFrames> frames;                // axes of gridpoint_pairs; constant in small displacements
  std::vector<OtherPoint> others;                 // points with one deformable side
  // of the last step
  quoin_status status = QUOIN_OK;
  bool failed = false;
  double stored = 0.0, dissipated[QUOIN_DISSIPATED_COUNT] = {}, damping = 0.0;  // J
  // for rows of the history
  double force_sum = 0.0;  // sum of the magnitudes of the points' forces, N
  Deepest deepest{};
};
inline constexpr uint32_t kChunk = 256;

// Divided again when contacts have changed. All ranks have the list.
struct Chunks {
  std::vector<Chunk> all;  // chunks; those of other processes are empty
  std::vector<int> own;    // chunks that this process evaluates
  // Forces of a step in own chunks: a row a point on gridpoints, three a point on a triangle.
  LaneVector<FacetRow> rows;
  long divisions = 0;  // number of divisions of the work so far
};

// After contacts have changed. One process alone has then all that steps read; ranks are to hold their parts first.
void divide_work(World& w);
void bind_work(World& w);
void pack(World& w, const Chunk& chunk);
void bind_columns(World& w);
void bind(const World& w, Family& f, Chunk& chunk);

}  // namespace quoin::blocks
