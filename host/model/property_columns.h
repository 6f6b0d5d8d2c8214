// Properties that scatter from contact point to contact point: drawn once, when the points of a model are known. A
// value depends on the sample and on where in the masonry its point is, not on the order of points.
#pragma once

#include <span>
#include <vector>

#include "law/law_library.h"
#include "model/lanes.h"
#include "scene/masonry_place.h"
#include "scene/scene.h"

namespace quoin {

struct PlacedPoint {
  Vec3 position;         // place at the start, m
  double area;           // m2
  int block_a, block_b;  // indices of blocks
};

// The block of a joint that was laid with it: one of masonry, and the later of two.
int block_laid(int block_a, int block_b, std::span<const PlacedBlock> blocks);

// One property, by contact point, as batches of the law take it.
struct PropertyColumn {
  const char* id;  // the law's own
  double usual;    // value of the material, for points that are not there at the start
  double most;     // the largest one drawn
  LaneVector<double> values;
};

// Columns of the properties of the family that scatter, without values; none in the sample 0.
std::vector<PropertyColumn> scattered_columns(const JointFamily& family, const Material& material);

// The same with the values of these points. They are all of the family, or all in some of its joints; where a property
// is correlated along courses, all in some courses. Throws Error(bad_input) for values that the law does not allow,
// with the place and what to do.
std::vector<PropertyColumn> draw_properties(const JointFamily& family, const Material& material,
                                            std::span<const PlacedPoint> points, std::span<const PlacedBlock> blocks);

// What batches of `material` take of these columns, from point `first` on: those of its properties that may be given
// point by point.
std::vector<quoin_property_column> batch_columns(const std::vector<PropertyColumn>& columns, const Material& material,
                                                 std::size_t first);

// Stiffness bounds of the law where its stiffnesses scatter: those of the stiffest points.
quoin_stiffness_bounds stiffness_bounds_of(const JointFamily& family, const Material& material,
                                           const std::vector<PropertyColumn>& columns);

}  // namespace quoin
