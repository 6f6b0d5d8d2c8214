// Specifications of members in a scene: ties, springs to the ground, strips, floors, beams, dowels, fills. SI units (m,
// N, Pa).
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace quoin {

// An end of a member.
struct MemberEnd {
  std::string block;              // empty: the block that contains the point
  Vec3 point{};                   // place at the start, m
  std::array<double, 2> plate{};  // m, sides of an anchor plate across the tie, level and upright; 0: none
  Source source;
};

// A bar between two points: elastic, then plastic with linear kinematic hardening.
struct TieSpec {
  std::string name;
  MemberEnd from, to;
  std::vector<MemberEnd> through;  // points at which it slides through without friction, in order
  double area = 0.0;               // m2
  double young_modulus = 0.0;      // Pa
  double yield_stress = 0.0;       // Pa
  double pretension = 0.0;         // N; reached over the ramp of the first stage
  double hardening = 0.0;          // tangent modulus beyond yield over Young's modulus
  double rupture_strain = std::numeric_limits<double>::infinity();
  double slack = 0.0;        // m, by which its ends part before it carries force
  bool compression = false;  // whether it carries compression
  Source source;
  double yield_force() const { return area * yield_stress; }
};

// Springs and dashpots between a face and the ground below or beside it, by area.
struct SpringSpec {
  std::string name, block;
  Vec3 normal{0, -1, 0};                                 // outward normal of its face
  double normal_stiffness = 0.0, shear_stiffness = 0.0;  // Pa/m
  double normal_dashpot = 0.0, shear_dashpot = 0.0;      // Pa s/m
  double friction_angle = 90.0;                          // deg; 90: the shear spring has no limit
  bool tension = false;                                  // whether it carries tension; else the face lifts off
  int divisions = 4;                                     // parts along each edge of the triangles of the face
  Source source;
};

// Fibres along a line on faces, with a law as bond.
struct StripSpec {
  std::string name, joint;                                    // joint: family whose law is the bond
  std::vector<Vec3> points;                                   // points of its line, m
  double width = 0.0, thickness = 0.0;                        // m
  double young_modulus = 0.0;                                 // Pa
  double strength = std::numeric_limits<double>::infinity();  // Pa, of the fibres
  double spacing = 0.0;                                       // m, largest distance of its nodes
  bool compression = false;                                   // whether it carries compression; else it buckles
  Source source;
};

// A membrane in a rectangle, connected to the blocks at its edges.
struct FloorSpec {
  std::string name;
  Vec3 corner{}, along{}, across{};                              // m: one corner, and both edges as vectors from it
  double spacing = 0.0;                                          // m, largest distance of its nodes
  double stiffness_along = 0.0, stiffness_across = 0.0;          // N/m, modulus times thickness
  double shear_stiffness = 0.0;                                  // N/m
  double shear_yield = std::numeric_limits<double>::infinity();  // N/m
  double mass = 0.0;                                             // kg/m2
  double load = 0.0;                                             // Pa
  std::string span = "across";                                   // direction towards the edges that carry its weight
  // Properties per metre of edge:
  double axial_stiffness = 0.0, connector_stiffness = 0.0;              // N/m2, normal to the edge and along it
  double axial_strength = std::numeric_limits<double>::infinity();      // N/m, of anchors
  double connector_strength = std::numeric_limits<double>::infinity();  // N/m, along the edge
  double friction = 0.0;                                      // friction coefficient, on the weight carried by the edge
  double pull_out = std::numeric_limits<double>::infinity();  // m
  bool bearing = true;
  Source source;
};

// Support of a beam at a point of its line.
struct BeamSupportSpec {
  std::string block;              // empty: the block that contains the point
  Vec3 point{};                   // m
  std::string hold = "built_in";  // built_in, pinned, resting
  Source source;
};

// A bar that bends, or a cable, along a line.
struct BeamSpec {
  std::string name;
  std::vector<Vec3> points;  // m
  double spacing = 0.0;      // m, largest distance of its nodes
  Vec3 up{0, 1, 0};          // direction of bending with inertia[0], shear_area[0] and so on
  double area = 0.0;         // m2
  // For bending towards `up`, and to the side:
  std::array<double, 2> inertia{};  // m4
  std::array<double, 2> shear_area{std::numeric_limits<double>::infinity(),
                                   std::numeric_limits<double>::infinity()};  // m2
  std::array<double, 2> yield_moment{std::numeric_limits<double>::infinity(),
                                     std::numeric_limits<double>::infinity()};  // N m
  double torsion = 0.0;                                                         // m4; 0 of cables alone
  double young_modulus = 0.0, poisson_ratio = 0.3;                              // Pa
  double density = 0.0;                                                         // kg/m3
  double yield_force = std::numeric_limits<double>::infinity();                 // N
  bool compression = true;         // whether it carries compression; else it is a cable
  double support_stiffness = 0.0;  // N/m; 0: that of an element of the beam
  double friction = 0.6;           // friction coefficient where it rests
  std::string bedding = "none";    // support of nodes without one of their own
  std::vector<BeamSupportSpec> supports;
  Source source;
};

// A bar across a joint. It resists opening and slip of both blocks.
struct DowelSpec {
  std::string name;
  Vec3 point{};                                         // place on the joint, m
  Vec3 direction{0, 1, 0};                              // direction of the bar
  double axial_stiffness = 0.0, shear_stiffness = 0.0;  // N/m
  double yield_force = 0.0, yield_shear = 0.0;          // N
  Source source;
};

// Soil on faces: its weight, and horizontal pressure between the active and the passive limit.
struct FillSpec {
  std::string name, block;
  Vec3 towards{0, 1, 0};  // direction of the soil: it lies on faces whose outward normal has a component along it
  Vec3 surface{};         // m, a point of its top surface
  Vec3 up{0, 1, 0};
  double unit_weight = 0.0, surcharge = 0.0;          // N/m3, Pa
  double friction_angle = 0.0;                        // deg
  double at_rest = 0.0, active = 0.0, passive = 0.0;  // coefficients: horizontal over vertical stress
  double stiffness = 0.0;                             // Pa/m, horizontal pressure per displacement
  int divisions = 4;                                  // parts along each edge of the triangles of faces
  Source source;
};

// The first piece of the line that a direction is along, within 3 degrees; none: it is across all.
std::optional<std::size_t> piece_along(const BeamSpec& beam, const Vec3& direction);

struct MemberSpecs {
  std::vector<TieSpec> ties;
  std::vector<SpringSpec> springs;
  std::vector<StripSpec> strips;
  std::vector<FloorSpec> floors;
  std::vector<BeamSpec> beams;
  std::vector<DowelSpec> dowels;
  std::vector<FillSpec> fills;
};

}  // namespace quoin
