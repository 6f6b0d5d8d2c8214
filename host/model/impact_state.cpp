#include "model/impact_state.h"

#include <algorithm>
#include <cmath>

#include "model/block_layout.h"
#include "model/impact_damping.h"
#include "model/property_columns.h"
#include "model/world.h"
#include "model/world_results.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

using Landing = std::array<double, 2>;  // squared frequencies normal to the face and along it, 1/s2

// Squared frequencies of a block that lands on an edge of its face at this contact, 1/s2. stiffness: normal to the
// joint and along it, Pa/m.
Landing landing_frequencies(const World& w, const Contact& c, int block, const std::array<double, 2>& stiffness) {
  const Block& input = w.assembly.blocks[size_t(block)];
  if (input.fixed) return {};
  const RigidMass own_mass = rigid_mass(w, input);
  const ConvexPolyhedron& shape = w.assembly.shapes[size_t(input.shape)];
  const Family& f = w.contacts.families[size_t(c.family)];
  const Matrix turned = orientation_of(w, block) * matrix(input.orientation);
  const Vector towards = transposed_times(turned, frame_of(w, f.point[c.first]).row[0]);
  size_t face = 0;
  for (size_t i = 1; i < shape.faces.size(); ++i) {
    if (std::abs(dot(shape.normals[i], towards)) > std::abs(dot(shape.normals[face], towards))) face = i;
  }
  const Vector n = shape.normals[face];
  const std::vector<int>& corners = shape.faces[face];
  const Vector s = normalized(shape.vertices[size_t(corners[1])] - shape.vertices[size_t(corners[0])]), t = cross(n, s);
  double along_s = 0.0, along_t = 0.0;
  for (const int i : corners) {
    const Vector arm = shape.vertices[size_t(i)] - own_mass.centre;
    along_s = std::max(along_s, std::abs(dot(arm, s))), along_t = std::max(along_t, std::abs(dot(arm, t)));
  }
  const auto inertia_about = [&](const Vector& axis) {
    const Vector own = transposed_times(own_mass.axes.vectors, axis), &values = own_mass.axes.values;
    return w.solver.mass_scaling * (values.x * own.x * own.x + values.y * own.y * own.y + values.z * own.z * own.z);
  };
  const double height = dot(shape.vertices[size_t(corners[0])] - own_mass.centre, n);
  return landing_squares({w.solver.mass_scaling * own_mass.mass,
                          face_area(shape, int(face)),
                          {along_s, along_t},
                          {inertia_about(s), inertia_about(t)},
                          height},
                         stiffness[0], stiffness[1]);
}

// Mean stiffness of a pair's points by area, normal to the joint and along it, Pa/m.
std::array<double, 2> mean_stiffness(const Family& f, const Contact& c) {
  if (f.columns.empty()) return {f.kn, f.ks};
  double area = 0.0, normal = 0.0, shear = 0.0;
  for (uint32_t i = c.first; i < c.first + c.count; ++i) {
    const auto [kn, ks] = stiffness_of_point(f, i);
    area += f.point[i].area, normal += f.point[i].area * kn, shear += f.point[i].area * ks;
  }
  return {normal / area, shear / area};
}

}  // namespace

std::array<double, 2> stiffness_of_point(const Family& f, size_t point) {
  if (f.columns.empty()) return {f.kn, f.ks};
  const quoin_stiffness_bounds bounds = stiffness_bounds_at(*f.material, f.columns, point);
  return {bounds.normal, bounds.shear};
}

// The block with the higher frequency of landing sets the viscosity. Joints between the halves of units are bonded from
// the start, and nothing lands there. With the stiffness of units they would reduce the step far too much.
std::array<double, 2> viscosity_of_pair(const World& w, const Contact& c) {
  if (!w.damping.impacts || w.units.other_half[size_t(c.pair.a)] == c.pair.b) return {};
  const std::array<double, 2> k = mean_stiffness(w.contacts.families[size_t(c.family)], c);
  const Landing a = landing_frequencies(w, c, c.pair.a, k), b = landing_frequencies(w, c, c.pair.b, k);
  return impact_viscosity({std::max(a[0], b[0]), std::max(a[1], b[1])}, w.damping.impacts->share);
}

void choose_impact_damping(World& w) {
  w.impacts.zone_beta = 0.0, w.impacts.share = 1.0;
  for (size_t i = 0; i < w.contacts.list.size(); ++i) {
    const Contact& c = w.contacts.list[i];
    w.contacts.place[i].viscosity = c.count > 0 && w.part.owns(c.pair) ? viscosity_of_pair(w, c) : std::array{0.0, 0.0};
  }
  for (const int c : w.chunks.own) pack_viscosity(w, w.chunks.all[size_t(c)]);
  if (!w.damping.impacts) return;
  for (int i = 0; i < w.block_count(); ++i) {
    const Block& input = w.assembly.blocks[size_t(i)];
    if (input.rigid) continue;
    const BlockMaterial& m = w.assembly.materials[size_t(input.material)];
    const double speed = std::sqrt(m.young_modulus / (m.density * w.solver.mass_scaling));
    const double beta = zone_viscosity(2.0 * w.blocks[size_t(i)].radius, speed);
    w.impacts.zone_beta = w.impacts.zone_beta > 0.0 ? std::min(w.impacts.zone_beta, beta) : beta;
  }
}

std::vector<std::array<double, 2>> impact_viscosities(const World& w) {
  std::vector<std::array<double, 2>> viscosities;
  for (const auto& of_family : w.contacts.of_family) {
    for (const uint32_t i : of_family) {
      const auto [normal, along] = w.contacts.place[i].viscosity;
      viscosities.insert(viscosities.end(), w.contacts.list[i].count, {w.impacts.share * normal, w.impacts.share * along});
    }
  }
  return viscosities;
}

double impact_damping_in_use(const World& w) {
  return w.damping.impacts ? w.impacts.share * w.damping.impacts->share : 0.0;
}

}  // namespace quoin::blocks
