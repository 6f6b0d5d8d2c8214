// Contact points between blocks of any shape.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "geometry/vector.h"
#include "law/law_library.h"
#include "model/lanes.h"
#include "model/maxwell.h"
#include "model/property_columns.h"

namespace quoin::blocks {

using geometry::Vector;

// A contact point. Its data are in the frame of block a: the body frame of a rigid block. For a deformable block it is
// the BlockFrame where the point is on gridpoints, else the frame of a triangle.
struct Point {
  int32_t a, b;                        // blocks
  int32_t facet_a = -1, facet_b = -1;  // index into Contacts::facets for a deformable side
  // 1: on the first gridpoints of facet_a and facet_b, if any; n, s, t are in a's frame.
  std::uint64_t on_gridpoints = 0;
  // Unit vectors, n from a to b. For a triangle's frame they are in space, from the last step or detection (see
  // frame_of).
  Vector n, s, t;
  double offset = 0.0;     // d_n = n . position in a's frame - offset, m (rigid a); reference gap (deformable a)
  Vector arm;              // position of the point in b's body frame (rigid b), m
  double area = 0.0;       // m2
  double reference = 0.0;  // gap at which d_n = 0, m
  Vector at;               // position in space when placed; in Chunk::others that of the last step, m
};

// Position of a contact point on a triangle of a deformable block.
struct Facet {
  double weight[3];
  int32_t node[3];
  int32_t unused = 0;  // see base/archive.h
};

// Gradients of the shape functions of a triangle along its s and t, 1/m.
using ShapeGradients = std::array<std::array<double, 2>, 3>;

// Whether the position is the triangle's first gridpoint.
inline bool sits_on_gridpoint(const Facet& f) { return f.weight[0] == 1.0 && f.weight[1] == 0.0 && f.weight[2] == 0.0; }

// Contact points of one joint family, with the columns of the law as a structure of arrays.
struct Family {
  std::shared_ptr<const Material> material;
  std::vector<double> initial, dry;  // state values of a bonded and of a dry point
  double kn = 0.0, ks = 0.0;         // stiffness bounds, Pa/m
  LaneVector<Point> point;
  LaneVector<double> slid[2];  // position along s, t in a's frame at the last step, m
  LaneVector<double> normal_jump, slip[2], traction[3];
  std::vector<LaneVector<double>> state;
  std::vector<PropertyColumn> columns;  // properties that scatter
  LaneVector<double> old_traction[3];   // traction of the last step, for stiffness damping and contact inspection
  LaneVector<double> stored, dissipated[QUOIN_DISSIPATED_COUNT];  // energies, if they are booked, J/m2
  LaneVector<double> old_jump;
  LaneVector<double> viscous[3];                     // traction of damping in the last step, Pa
  LaneVector<double> maxwell[3 * kMaxwellElements];  // tractions of the Maxwell elements, element after element, Pa
  LaneVector<double> arm[3], offset, area;           // copies of Point's numbers, component by component, for the step
  size_t size() const { return point.size(); }
};

}  // namespace quoin::blocks
