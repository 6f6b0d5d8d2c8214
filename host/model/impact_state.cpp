#include "model/impact_state.h"

#include <algorithm>
#include <cmath>

#include "model/block_layout.h"
#include "model/impact_damping.h"
#include "model/world.h"
#include "model/world_results.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

using Landing = std::array<double, 2>;  // squared frequencies normal to the face and along it, 1/s2

// Squared frequencies of a block that lands on an edge of its face at this contact, 1/s2.
Landing landing_frequencies(const World& w, const Contact& c, int block) {
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
                         f.kn, f.ks);
}

// Squared frequencies of the lightest block at the joints of a family, 1/s2. For a family without joints, those of the
// lightest of all blocks on its largest face.
Landing landing_frequencies(const World& w, int family) {
  const Family& f = w.contacts.families[size_t(family)];
  Landing highest{};
  const auto add = [&](const Landing& squares) {
    for (size_t k = 0; k < 2; ++k) highest[k] = std::max(highest[k], squares[k]);
  };
  for (const uint32_t i : w.contacts.of_family[size_t(family)]) {
    const Contact& c = w.contacts.list[i];
    if (c.count == 0 || !w.part.owns(c.pair)) continue;
    add(landing_frequencies(w, c, c.pair.a)), add(landing_frequencies(w, c, c.pair.b));
  }
  highest = {w.part.largest(highest[0]), w.part.largest(highest[1])};
  const bool known = highest[0] > 0.0;
  for (const Block& block : w.assembly.blocks) {
    if (block.fixed || known) continue;
    const ShapeFacts& facts = w.shapes.facts[size_t(block.shape)];
    const double density = density_of(w, block) * w.solver.mass_scaling;
    const double half_over_mass = 0.5 / (density * facts.least_extent);  // A/2 over m, A = V/least extent
    add({4.0 * f.kn * half_over_mass, 4.0 * f.ks * half_over_mass});     // b^2/I and h^2/I are at most 3/m of a box
  }
  return highest;
}

}  // namespace

void choose_impact_damping(World& w) {
  w.impacts.beta.clear();
  w.impacts.zone_beta = 0.0, w.impacts.share = 1.0;
  if (!w.damping.impacts) return;
  // Joints between the halves of units are bonded from the start: nothing lands there. With the stiffness of units they
  // would reduce the step far too much.
  const auto within_units = [&](size_t f) {
    double any = 0.0, others = 0.0;
    for (const uint32_t i : w.contacts.of_family[f]) {
      const Contact& c = w.contacts.list[i];
      if (c.count == 0 || !w.part.owns(c.pair)) continue;
      any = 1.0;
      if (w.units.other_half[size_t(c.pair.a)] != c.pair.b) others = 1.0;
    }
    return w.part.largest(any) > 0.0 && w.part.largest(others) == 0.0;
  };
  for (size_t f = 0; f < w.contacts.families.size(); ++f) {
    if (within_units(f)) {
      w.impacts.beta.insert(w.impacts.beta.end(), {0.0, 0.0});
      continue;
    }
    const auto [normal, along] = impact_viscosity(landing_frequencies(w, int(f)), w.damping.impacts->share);
    w.impacts.beta.insert(w.impacts.beta.end(), {normal, along});
  }
  for (int i = 0; i < w.block_count(); ++i) {
    const Block& input = w.assembly.blocks[size_t(i)];
    if (input.rigid) continue;
    const BlockMaterial& m = w.assembly.materials[size_t(input.material)];
    const double speed = std::sqrt(m.young_modulus / (m.density * w.solver.mass_scaling));
    const double beta = zone_viscosity(2.0 * w.blocks[size_t(i)].radius, speed);
    w.impacts.zone_beta = w.impacts.zone_beta > 0.0 ? std::min(w.impacts.zone_beta, beta) : beta;
  }
}

double impact_damping_in_use(const World& w) {
  return w.damping.impacts ? w.impacts.share * w.damping.impacts->share : 0.0;
}

}  // namespace quoin::blocks
