// Properties that scatter from contact point to contact point: drawn once, when the points of a model are known. A
// value depends on the sample and on where in the masonry its point is, not on the order of points.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "law/law_library.h"
#include "scene/masonry_place.h"
#include "scene/scene.h"

namespace quoin {

struct PlacedPoint {
  Vec3 position;         // of the start, m
  double area;           // m2
  int block_a, block_b;  // indices of blocks
};

// One property, by contact point, as batches of the law take it.
struct PropertyColumn {
  const char* id;  // the law's own
  double usual;    // of the material: of points that are not there at the start
  double most;     // the largest one drawn
  std::vector<double> values;
};

// Columns of the properties of the family that scatter, for its points; none in the sample 0. Throws Error(bad_input)
// for values that the law does not allow, with the place and what to do.
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
