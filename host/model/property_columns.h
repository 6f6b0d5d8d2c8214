// Properties that scatter from contact point to contact point, drawn once for the points of a model. A value depends on
// the sample and on the place of its point in the masonry, not on the order of points.
#pragma once

#include <span>
#include <string_view>
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
  Vec3 axis[3] = {};     // n, from a to b, s and t, in space at the start
};

// The block of a joint that was laid with it: the masonry block, of two masonry blocks the later one.
int block_laid(int block_a, int block_b, std::span<const PlacedBlock> blocks);

// Values of one property by contact point, as input of the law's batches.
struct PropertyColumn {
  const char* id;  // the law's id
  bool is_drawn;   // false: values of another property, which is the default of this one
  double usual;    // value of the material, for points that are not of the start
  double most;     // largest value drawn
  LaneVector<double> values;
};

// Columns of the properties of the family that scatter, without values; empty for sample 0. Then those of properties
// that the family does not give, and whose default is the value of one of these (default_from).
std::vector<PropertyColumn> scattered_columns(const JointFamily& family, const Material& material);

// The same columns with the values of these points. These are all points of the family, or all points of some joints.
// Where a property is correlated along courses, they are all points of some courses. Throws Error(bad_input) for values
// that the law does not allow, with the place and a remedy.
std::vector<PropertyColumn> draw_properties(const JointFamily& family, const Material& material,
                                            std::span<const PlacedPoint> points, std::span<const PlacedBlock> blocks);

// Batch columns of `material`, from point `first` on: those of these columns that the law accepts point by point.
std::vector<quoin_property_column> batch_columns(const std::vector<PropertyColumn>& columns, const Material& material,
                                                 std::size_t first);

// Column of a property; null: it does not scatter.
const PropertyColumn* find_column(const std::vector<PropertyColumn>& columns, std::string_view id);

// Value of a property at a point over that of the material; 1 where it does not scatter, and at points without a value.
double scatter_factor(const std::vector<PropertyColumn>& columns, std::string_view id, std::size_t point);

// Stiffness bounds of the law at a point, from the stiffnesses drawn for it.
quoin_stiffness_bounds stiffness_bounds_at(const Material& material, const std::vector<PropertyColumn>& columns,
                                           std::size_t point);

// Stiffness bounds of the law: where its stiffnesses scatter, those of the stiffest points.
quoin_stiffness_bounds stiffness_bounds_of(const JointFamily& family, const Material& material,
                                           const std::vector<PropertyColumn>& columns);

}  // namespace quoin
