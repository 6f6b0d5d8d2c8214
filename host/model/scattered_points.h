// Properties that scatter over the contact points of the lattice, drawn where a model is laid out. A value depends only
// on the sample and on the place of its point or course.
#pragma once

#include <span>

#include "model/model.h"

namespace quoin {

// Allocates the columns of the families' points, without values.
void make_columns(Model& model);
// Draws the values of the points of these chunks. Throws as draw_properties does.
void draw_columns(Model& model, std::span<const int> chunks);
// Releases columns of the points [first, end) of the model, which are no longer laid out.
void release_columns(Model& model, std::size_t first, std::size_t end);
// Sets the stiffness bounds of families by the largest values drawn.
void bound_stiffness(Model& model);

}  // namespace quoin
