// Results of a model: of blocks, of contact points, of the whole.
#pragma once

#include "model/world.h"

namespace quoin::blocks {

Vector position_of(const World& w, int block);  // centre of mass, m
Vector start_position_of(const World& w, int block);
Vector velocity_of(const World& w, int block);     // velocity of the centre of mass, m/s
Vector spin_of(const World& w, int block);         // of a rigid block, rad/s
Matrix orientation_of(const World& w, int block);  // rotation since the start
Matrix turn_of_frame(const World& w, int block);   // rotation since the start that internal forces follow
Vector moved(const World& w, int block);           // displacement since the start, m
double turned(const World& w, int block);          // rotation angle since the start, rad
Vector moved_by_now(const World& w, int block);    // moved() of an own block, within a step
double turned_by_now(const World& w, int block);
Vector corner_of(const World& w, int block, int vertex);
Matrix zone_stress(const World& w, int block, int index);  // Cauchy, Pa, tension positive
double kinetic_energy_of(const World& w, int block);       // from the velocities half a step ago, J

Matrix frame_of(const World& w, const Point& p);                   // rows n, s, t in space, n from a to b
Vector force_on_a(const World& w, const Family& f, size_t point);  // on the point's block a, N
Vector place_of(const World& w, const Point& p);                   // m
std::vector<PlacedPoint> placed_points(const World& w, const Family& f);
Deepest deepest_of(const World& w, const Chunk& chunk);
Deepest deepest_of_chunk(const World& w, int chunk);
double force_sum_of(const World& w, const Chunk& chunk);  // sum of the magnitudes of forces, N

double kinetic_energy_of_all(const World& w);  // over all ranks, J
double strain_energy(const World& w);
double unbalanced_ratio(const World& w);  // largest unbalanced force / mean contact force of the last step; inf: none
double extent_of(const World& w);         // diagonal of the box around all blocks at the start, m
double whole_mass(const World& w);

}  // namespace quoin::blocks
