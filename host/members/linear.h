// Floors and beams in small motion about the start, for modes. They are their own nodes, and each of their deformations
// as a linear function of the motion of nodes and blocks.
#pragma once

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "members/node.h"

namespace quoin::members {

class Members;

// A node that is a member's own. Directions without inertia and forces are no unknowns.
struct OwnNode {
  Vector at;                         // m
  double mass = 0.0, inertia = 0.0;  // kg, kg m2
  std::vector<Vector> ways, turns;   // unit: in which it moves, about which it turns
};

// A floor or beam: its nodes are in a row.
struct OwnBody {
  std::string label;  // "floor 'first'"
  int first = 0, end = 0;
  std::size_t first_deformation = 0, end_deformation = 0;
  std::vector<std::vector<int>> faces;  // faces to draw, by nodes from 0
};

// Deformation = sum of way . displacement + turn . rotation; a force F in it acts on each node with -F way, -F turn.
struct Deformation {
  struct Share {
    bool own = false;
    int node = 0;  // index among own ones, else a node on a block
    Vector way, turn;
  };
  std::vector<Share> shares;
  double stiffness = 0.0;  // N/m or N m
  double coupling = 0.0;   // stiffness between this deformation and the one before, N/m or N m
  // Strength: what F is bounded by. `what`: its quantity and unit, as in files. over: what results divide it by, m.
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  const char* what = "";  // empty: without a bound of its own
  double over = 1.0;
};

// A node of a beam that rests on a block: closed, and without slip.
struct Rest {
  int own = 0, node = 0;
  double stiffness = 0.0;  // N/m, in every direction
  Vector out;              // outward normal of the block, unit
  double friction = 0.0;
};

// Weight of a floor that a node on a block carries along the floor's normal.
struct Carried {
  int node = 0;
  double mass = 0.0;  // kg, loads too
  Vector normal;      // unit
};

struct LinearMembers {
  std::vector<OwnNode> nodes;
  std::vector<OwnBody> bodies;
  std::vector<Deformation> deformations;
  std::vector<Rest> rests;
  std::vector<Carried> carried;
};

// gravity: m/s2, whose weight presses connectors against their walls: friction. Throws Error(bad_input) with the file
// for a cable, which holds nothing on its straight line.
LinearMembers linear_of(const Members& members, const std::string& file, const Vector& gravity = {});

}  // namespace quoin::members
