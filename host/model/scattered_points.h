// Properties that scatter over the contact points of the lattice, drawn where a model is laid out. A value depends on
// the sample and the place of its point, or of its course, alone.
#pragma once

#include <span>

#include "model/model.h"

namespace quoin {

// Columns of the families' points, with their addresses and no values yet.
void make_columns(Model& model);
// The values of the points of these chunks. Throws as draw_properties.
void draw_columns(Model& model, std::span<const int> chunks);
// Releases columns of the points [first, end) of the model, which are laid out no more.
void forget_columns(Model& model, std::size_t first, std::size_t end);
// Stiffnesses by the largest values drawn.
void bound_stiffness(Model& model);

}  // namespace quoin
