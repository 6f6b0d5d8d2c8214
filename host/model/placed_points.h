// Places of contact points on the lattice, laid out or not. Output and initial damage by place need the points of whole
// joints, of which a rank may have only a part.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "model/model.h"

namespace quoin {

// Places of these points. points: numbers, ascending. Places have the same order.
std::vector<PlacedPoint> placed_points(const Model& model, std::span<const std::int32_t> points);

// Numbers of all points of a family whose pair of blocks has one of these points, ascending.
std::vector<std::int32_t> points_of_same_joints(const Model& model, const ContactFamily& family,
                                                std::span<const std::int32_t> points);

}  // namespace quoin
