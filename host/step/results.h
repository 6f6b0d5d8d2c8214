// Results of a simulation between steps, by block and by contact point. Not for inner loops.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "step/simulation.h"

namespace quoin {

struct BlockMesh {
  // Positions at the start, m; of rigid blocks the corners (bricks: x fastest, then y, z).
  std::vector<Vec3> gridpoint;
  std::vector<std::array<int, 4>> zone;  // tetrahedra; empty for rigid blocks
  std::vector<std::vector<int>> face;    // faces of the whole block, corner by corner, counter-clockwise from outside
  int unit = -1, course = -1;            // indices of the masonry unit and its course; -1: none
  bool fixed = false;                    // a support, or a beam beside the masonry
};
BlockMesh block_mesh(const Simulation::Impl& s, int block);
struct BlockSize {
  std::uint64_t gridpoints = 0, zones = 0, faces = 0, face_corners = 0;
};
BlockSize block_size(const Simulation::Impl& s, int block);                  // sizes of its mesh
std::vector<Vec3> block_displacement(const Simulation::Impl& s, int block);  // per gridpoint of block_mesh, m
std::vector<Vec3> block_velocity(const Simulation::Impl& s, int block);
// Per zone: xx yy zz xy yz zx, Pa, tension > 0.
std::vector<std::array<double, 6>> block_stress(const Simulation::Impl& s, int block);

// Condition of a contact point: the first that holds, in this order.
enum class Condition : std::uint8_t { crushed_out, crushing, open, slipping, softening, elastic };
inline constexpr int kConditionCount = 6;
const char* condition_name(Condition condition);
Condition condition_of(std::uint32_t flags);  // QUOIN_FLAG_...

struct ContactPoint {
  std::int32_t index;  // index of the point, as in PointRange
  Vec3 position;       // position at the start on the lattice, else current, m
  Vec3 normal, s, t;   // n from block a to block b
  double area;         // m2
  int joint, family;   // indices into the assembly; joint: -1 in large motion
  int block_a, block_b;
  // u_b - u_a along n, s, t at the time of the traction, m; n with the opening of damage. In large motion n alone.
  Vec3 jump;
  Vec3 traction;        // sigma, tau_s, tau_t, Pa
  std::uint32_t flags;  // QUOIN_FLAG_..., of the last step
  Condition condition;
};

// Consecutive contact points, [first, end).
struct PointRange {
  std::int32_t first = 0, end = 0;
};

PointRange all_points(const Simulation::Impl& s);
// Contact points of a range. Flags are those of the last step, or of a law call without motion. own_alone: only joints
// that begin at a block of this rank (owns_block).
std::vector<ContactPoint> contact_points(const Simulation::Impl& s, const PointRange& range, bool own_alone = false);
inline std::vector<ContactPoint> contact_points(const Simulation::Impl& s) { return contact_points(s, all_points(s)); }
// Displacements of the point on blocks a and b, m. Lattice.
std::pair<Vec3, Vec3> displacement_of_sides(const Simulation::Impl& s, std::int32_t point);
// Column of a law state, by id; NaN where the law of a point has no such state or does not keep it.
std::vector<double> law_state(const Simulation::Impl& s, const std::string& id, const PointRange& range);
inline std::vector<double> law_state(const Simulation::Impl& s, const std::string& id) {
  return law_state(s, id, all_points(s));
}
std::int32_t points_of_family(const Simulation::Impl& s, int family);
// State of the points of a family, which the run keeps (keeps_state), by its number in the law.
const double* state_column(const Simulation::Impl& s, int family, std::size_t state);
bool keeps_state(const Simulation::Impl& s, const quoin_law& law, std::size_t state);  // at points of this law
bool keeps_state(const Simulation::Impl& s, const std::string& id);                    // by the law of some point
// Damage by contact point: lost share of the tensile strength, cohesion and compressive strength that can be lost. NaN:
// the law of the point has no such damage.
using DamageColumns = std::array<std::vector<double>, QUOIN_DAMAGE_COUNT>;
DamageColumns damage_of_points(const Simulation::Impl& s, const PointRange& range);
inline DamageColumns damage_of_points(const Simulation::Impl& s) { return damage_of_points(s, all_points(s)); }
std::array<long, kConditionCount> condition_counts(const Simulation::Impl& s);

}  // namespace quoin
