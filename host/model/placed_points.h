// Where contact points of the lattice are, whether they are laid out or not. What is drawn or damaged by place needs
// points of whole joints, of which a rank may hold a part.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "model/model.h"

namespace quoin {

// In their order. points: numbers, ascending.
std::vector<PlacedPoint> placed_points(const Model& model, std::span<const std::int32_t> points);

// Numbers of all points of a family between pairs of blocks that some of these points lie between, ascending.
std::vector<std::int32_t> points_of_same_joints(const Model& model, const ContactFamily& family,
                                                std::span<const std::int32_t> points);

}  // namespace quoin
