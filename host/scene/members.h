// What holds blocks beside their joints, as scenes say it: ties, springs to the ground, strips. SI units (m, N, Pa).
#pragma once

#include <string>
#include <vector>

#include "scene/scene.h"

namespace quoin {

// Where a member is fixed.
struct MemberEnd {
  std::string block;  // empty: the one that has the point
  Vec3 point{};       // at the start, m
  Source source;
};

// A bar between two points: elastic, then plastic with linear kinematic hardening.
struct TieSpec {
  std::string name;
  MemberEnd from, to;
  double area = 0.0;           // m2
  double young_modulus = 0.0;  // Pa
  double yield_stress = 0.0;   // Pa
  double pretension = 0.0;     // N: grows over the ramp of the first stage
  double hardening = 0.0;      // tangent modulus beyond yield over the elastic one
  double rupture_strain = std::numeric_limits<double>::infinity();
  double slack = 0.0;        // m, that its ends move apart before it bears
  bool compression = false;  // else it slackens
  Source source;
  double yield_force() const { return area * yield_stress; }
};

// Springs and dashpots between a face and the ground below or beside it, over its area.
struct SpringSpec {
  std::string name, block;
  Vec3 normal{0, -1, 0};                                 // outward, of the face that is meant
  double normal_stiffness = 0.0, shear_stiffness = 0.0;  // Pa/m
  double normal_dashpot = 0.0, shear_dashpot = 0.0;      // Pa s/m
  double friction_angle = 90.0;                          // deg; 90: the shear spring has no limit
  bool tension = false;                                  // else the face lifts off
  int divisions = 4;                                     // of each edge of the triangles that the face is cut into
  Source source;
};

// Fibres along a line on faces, bonded by a law.
struct StripSpec {
  std::string name, joint;                                    // joint: family whose law is the bond
  std::vector<Vec3> points;                                   // its line, m
  double width = 0.0, thickness = 0.0;                        // m
  double young_modulus = 0.0;                                 // Pa
  double strength = std::numeric_limits<double>::infinity();  // Pa, of the fibres
  double spacing = 0.0;                                       // m, largest between its nodes
  bool compression = false;                                   // else it buckles
  Source source;
};

struct MemberSpecs {
  std::vector<TieSpec> ties;
  std::vector<SpringSpec> springs;
  std::vector<StripSpec> strips;
};

}  // namespace quoin
