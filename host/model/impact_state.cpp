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

// A block that is free, with its face at this contact.
LandingBlock landing_on_face(const World& w, const Contact& c, int block) {
  const Block& input = w.assembly.blocks[size_t(block)];
  const RigidMass own_mass = rigid_mass(w, input);
  const ConvexPolyhedron& shape = w.assembly.shapes[size_t(input.shape)];
  const Family& f = w.contacts.families[size_t(c.family)];
  const Matrix turned = orientation_of(w, block) * matrix(input.orientation);
  const Point& p = f.point[c.first];
  const Vector outwards = (p.a == block ? 1.0 : -1.0) * transposed_times(turned, frame_of(w, p).row[0]);
  size_t face = 0;
  for (size_t i = 1; i < shape.faces.size(); ++i)
    if (dot(shape.normals[i], outwards) > dot(shape.normals[face], outwards)) face = i;
  const Vector n = shape.normals[face];
  const std::vector<int>& corners = shape.faces[face];
  const auto arm = [&](size_t corner) {
    return shape.vertices[size_t(corners[corner % corners.size()])] - own_mass.centre;
  };
  double tipping = 0.0, least = HUGE_VAL;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Vector edge = normalized(arm(i + 1) - arm(i));
    const Vector own = transposed_times(own_mass.axes.vectors, edge), &values = own_mass.axes.values;
    const double about =
        w.solver.mass_scaling * (values.x * own.x * own.x + values.y * own.y * own.y + values.z * own.z * own.z);
    const double reach = dot(arm(i), cross(edge, n));
    tipping = std::max(tipping, reach * reach / about);
    least = std::min(least, about);
  }
  return {w.solver.mass_scaling * own_mass.mass, face_area(shape, int(face)), tipping, least, dot(arm(0), n)};
}

void raise(Landing& highest, const Landing& squares) {
  for (size_t k = 0; k < 2; ++k) highest[k] = std::max(highest[k], squares[k]);
}

bool joins_halves(const World& w, const Contact& c) { return w.units.other_half[size_t(c.pair.a)] == c.pair.b; }

// Area of a pair's points, m2, and their mean stiffness by area, normal to the joint and along it, Pa/m.
std::array<double, 3> mean_stiffness(const Family& f, const Contact& c) {
  double area = 0.0, normal = 0.0, shear = 0.0;
  for (uint32_t i = c.first; i < c.first + c.count; ++i) {
    const auto [kn, ks] = stiffness_of_point(f, i);
    area += f.point[i].area, normal += f.point[i].area * kn, shear += f.point[i].area * ks;
  }
  if (f.columns.empty() || !(area > 0.0)) return {area, f.kn, f.ks};
  return {area, normal / area, shear / area};
}

// Squared frequencies of blocks at their joints of a family, 1/s2: the highest, so that a block has one viscosity at
// its beds and heads. Joints that cover little of a face are left out: what touches a block is no face that lands. A
// block without joints of the family has those on its largest face.
std::vector<Landing> landing_of_blocks(const World& w, size_t family) {
  constexpr double kCovers = 0.25;
  const Family& f = w.contacts.families[family];
  std::vector<Landing> highest(w.blocks.size());
  std::vector<char> joined(w.blocks.size(), 0);
  for (const uint32_t i : w.contacts.of_family[family]) {
    const Contact& c = w.contacts.list[i];
    if (c.count == 0 || !w.part.owns(c.pair) || joins_halves(w, c)) continue;
    const auto [area, kn, ks] = mean_stiffness(f, c);
    for (const int block : {c.pair.a, c.pair.b}) {
      joined[size_t(block)] = 1;
      if (w.assembly.blocks[size_t(block)].is_support()) continue;
      const LandingBlock landing = landing_on_face(w, c, block);
      if (area >= kCovers * landing.area) raise(highest[size_t(block)], landing_squares(landing, kn, ks));
    }
  }
  for (size_t i = 0; i < w.blocks.size(); ++i) {
    const Block& block = w.assembly.blocks[i];
    if (block.is_support() || joined[i]) continue;
    const double density = density_of(w, block) * w.solver.mass_scaling;
    // A/2 over m, with A = V/least extent. b^2/I and h^2/I are at most 3/m of a box.
    const double half_over_mass = 0.5 / (density * w.shapes.facts[size_t(block.shape)].least_extent);
    highest[i] = {4.0 * f.kn * half_over_mass, 4.0 * f.ks * half_over_mass};
  }
  w.part.gather_by_block(highest);
  return highest;
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
  if (!w.damping.impacts || joins_halves(w, c)) return {};
  const auto [area, kn, ks] = mean_stiffness(w.contacts.families[size_t(c.family)], c);
  Landing highest{};
  for (const int block : {c.pair.a, c.pair.b}) {
    if (w.assembly.blocks[size_t(block)].is_support()) continue;
    raise(highest, landing_squares(landing_on_face(w, c, block), kn, ks));
    raise(highest, w.impacts.landing[size_t(c.family) * w.blocks.size() + size_t(block)]);
  }
  return impact_viscosity(highest, w.damping.impacts->share);
}

void choose_impact_damping(World& w) {
  w.impacts.landing.clear();
  w.impacts.zone_beta = 0.0, w.impacts.share = 1.0;
  for (size_t f = 0; f < w.contacts.families.size() && w.damping.impacts; ++f) {
    const std::vector<Landing> of_family = landing_of_blocks(w, f);
    w.impacts.landing.insert(w.impacts.landing.end(), of_family.begin(), of_family.end());
  }
  for (size_t i = 0; i < w.contacts.list.size(); ++i) {
    const Contact& c = w.contacts.list[i];
    w.contacts.place[i].viscosity = c.count > 0 && w.part.owns(c.pair) ? viscosity_of_pair(w, c) : std::array{0.0, 0.0};
  }
  for (const int c : w.chunks.own) pack_viscosity(w, w.chunks.all[size_t(c)]);
  if (!w.damping.impacts) return;
  for (int i = 0; i < w.block_count(); ++i) {
    const Block& input = w.assembly.blocks[size_t(i)];
    if (input.rigid) continue;
    lower_zone_viscosity(w.impacts.zone_beta, 2.0 * w.blocks[size_t(i)].radius,
                         w.assembly.materials[size_t(input.material)], w.solver.mass_scaling);
  }
}

std::vector<std::array<double, 2>> impact_viscosities(const World& w) {
  std::vector<std::array<double, 2>> viscosities;
  for (const auto& of_family : w.contacts.of_family) {
    for (const uint32_t i : of_family) {
      const auto [normal, along] = w.contacts.place[i].viscosity;
      viscosities.insert(viscosities.end(), w.contacts.list[i].count,
                         {w.impacts.share * normal, w.impacts.share * along});
    }
  }
  return viscosities;
}

double impact_damping_in_use(const World& w) {
  return w.damping.impacts ? w.impacts.share * w.damping.impacts->share : 0.0;
}

}  // namespace quoin::blocks
