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

// A contact point. Everything is in the frame of block a. Rigid blocks have the body frame; deformable ones BlockFrame
// where both sides are gridpoints, else that of a triangle.
struct Point {
  int32_t a, b;                        // blocks
  int32_t facet_a = -1, facet_b = -1;  // index into Contacts::facets for a deformable side
  bool on_gridpoints = false;          // the first ones of both facets; n, s, t are in the frame of block a
  // Unit, n from a to b. In space where a triangle is the frame: of the last step, or the last detection (see
  // frame_of).
  Vector n, s, t;
  double offset = 0.0;     // d_n = n . position in a's frame - offset, m (rigid a); reference gap (deformable a)
  Vector arm;              // place of the point in b's body frame (rigid b), m
  double area = 0.0;       // m2
  double reference = 0.0;  // gap at which d_n = 0, m
  Vector at;               // in space where it was placed; of the last step if one side is deformable, m
};

// Where a point sits on a triangle of a deformable block.
struct Facet {
  int32_t node[3];
  double weight[3];
};

// Of the shape functions of a triangle, along its s and t, 1/m.
using ShapeGradients = std::array<std::array<double, 2>, 3>;

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
  std::vector<PropertyColumn> columns;  // properties that scatter
  LaneVector<double> old_traction[3];   // traction of the last step, for stiffness damping and contact inspection
  LaneVector<double> stored, dissipated[QUOIN_DISSIPATED_COUNT];  // energies, where requested, J/m2
  LaneVector<double> old_jump;
  LaneVector<double> viscous[3];                     // traction of damping in the last step, Pa
  LaneVector<double> maxwell[3 * kMaxwellElements];  // tractions of its Maxwell elements, one after the other, Pa
  LaneVector<double> arm[3], offset, area;           // numbers of all points, component by component, for the step
  size_t size() const { return point.size(); }
};

}  // namespace quoin::blocks
