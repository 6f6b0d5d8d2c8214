// Floors and beams linearised about the start, for modes: their own nodes, and deformations as linear functions of the
// motion of nodes and blocks.
#pragma once

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "members/node.h"

namespace quoin::members {

class Members;

// Own node of a member. Directions without inertia and forces are no unknowns.
struct OwnNode {
  Vector at;                         // m
  double mass = 0.0, inertia = 0.0;  // kg, kg m2
  std::vector<Vector> ways, turns;   // unit vectors: directions in which it moves, axes about which it turns
  Vector load;                       // constant force, N
};

// A floor or beam; its nodes and deformations are consecutive.
struct OwnBody {
  std::string label;  // "floor 'first'"
  int first = 0, end = 0;
  std::size_t first_deformation = 0, end_deformation = 0;
  std::vector<std::vector<int>> faces;  // faces to draw, by node numbers from 0
};

// Deformation = sum of way . displacement + turn . rotation; a force F in it acts on each node with -F way, -F turn.
struct Deformation {
  struct Share {
    bool own = false;
    int node = 0;  // index of an own node, or of a node on a block
    Vector way, turn;
  };
  std::vector<Share> shares;
  double stiffness = 0.0;  // N/m or N m
  double coupling = 0.0;   // stiffness between this deformation and the previous one, N/m or N m
  // Bounds of F. what: its quantity and unit, as in files. over: divisor of F in results, m.
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  const char* what = "";  // empty: no bounds of its own
  double over = 1.0;
};

// A node of a beam that rests on a block; it is closed and does not slip.
struct Rest {
  int own = 0, node = 0;
  double stiffness = 0.0;  // N/m, in every direction
  Vector out;              // outward normal of the block, unit
  double friction = 0.0;
};

// Node on a block that carries the weight of a floor along the floor's normal.
struct Carried {
  int node = 0;
  double mass = 0.0;  // kg
  Vector normal;      // unit
  Vector load;        // constant force, N
};

struct LinearMembers {
  std::vector<OwnNode> nodes;
  std::vector<OwnBody> bodies;
  std::vector<Deformation> deformations;
  std::vector<Rest> rests;
  std::vector<Carried> carried;
};

// gravity: m/s2; weight presses connectors against their walls, which gives friction. Throws Error(bad_input) with the
// file for a cable, which has no stiffness across its straight line.
LinearMembers linear_of(const Members& members, const std::string& file, const Vector& gravity = {});

}  // namespace quoin::members
