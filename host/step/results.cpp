// Results of a simulation between steps. Not for inner loops.
#include "step/results.h"

#include <algorithm>
#include <array>
#include <limits>

#include "step/collect.h"
#include "step/large_motion_results.h"
#include "step/lattice_motion.h"
#include "step/points_at_rest.h"
#include "step/state.h"

namespace quoin {

namespace {

// Corners of a brick: x fastest, then y, z.
std::array<Vec3, 8> corners_of(const Brick& brick) {
  std::array<Vec3, 8> corners;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    for (std::size_t c = 0; c < 3; ++c)
      corners[k][c] = brick.origin[c] + static_cast<double>(k >> c & 1) * brick.size[c];
  }
  return corners;
}

std::vector<Vec3> block_values(const Simulation::Impl& s, int block, const LaneVector<double>& values,
                               BodyLanes::Quantity BodyLanes::*translation, BodyLanes::Quantity BodyLanes::*rotation) {
  const Model::BlockPlace& place = s.model.place[at(block)];
  std::vector<Vec3> result;
  if (place.body >= 0) {
    for (const Vec3& p : corners_of(s.model.assembly.bricks[at(block)]))
      result.push_back(of_body_at(s, place.body, translation, rotation, p));
    return result;
  }
  s.model.for_each_gridpoint(block,
                             [&](std::size_t offset, double) { result.push_back(at_gridpoint(values, offset)); });
  return result;
}

}  // namespace

long Simulation::block_count() const { return quoin::block_count(*impl_); }

long Simulation::zone_count() const {
  return static_cast<long>(impl_->large_motion ? impl_->large_motion->zone_count() : impl_->model.zone_count());
}

BlockMesh block_mesh(const Simulation::Impl& s, int block) {
  if (s.large_motion) return mesh_in_large_motion(s, block);
  const Model& model = s.model;
  const Brick& brick = model.assembly.bricks[at(block)];
  const Model::BlockPlace& place = model.place[at(block)];
  BlockMesh mesh;
  mesh.unit = brick.unit, mesh.course = brick.course, mesh.fixed = brick.beam || brick.fixed;
  mesh.face = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  if (place.body >= 0) {
    const auto corners = corners_of(brick);
    mesh.gridpoint.assign(corners.begin(), corners.end());
    return mesh;
  }
  const BlockGroup& group = model.groups[at(place.group)];
  const BrickTemplate& shape = model.templates[at(group.brick_template)];
  for (int n = 0; n < shape.node_count; ++n) mesh.gridpoint.push_back(model.gridpoint_position(block, n));
  const auto& [nx, ny, nz] = shape.zones;
  for (std::vector<int>& face : mesh.face) {
    for (int& corner : face)
      corner = shape.node_index(corner & 1 ? nx : 0, corner >> 1 & 1 ? ny : 0, corner >> 2 ? nz : 0);
  }
  for (const Zone& zone : shape.zone) mesh.zone.push_back(zone.node);
  return mesh;
}

BlockSize block_size(const Simulation::Impl& s, int block) {
  if (s.large_motion) return size_in_large_motion(s, block);
  constexpr std::uint64_t kFaces = 6, kFaceCorners = 24, kCorners = 8;
  if (s.model.place[at(block)].body >= 0) return {kCorners, 0, kFaces, kFaceCorners};
  const BrickTemplate& shape = s.model.template_of(block);
  return {at(shape.node_count), shape.zone.size(), kFaces, kFaceCorners};
}

std::vector<Vec3> block_displacement(const Simulation::Impl& s, int block) {
  if (s.large_motion) return gridpoint_displacements(s, block);
  return block_values(s, block, s.lattice.displacement, &BodyLanes::displacement, &BodyLanes::rotation);
}

std::vector<Vec3> block_velocity(const Simulation::Impl& s, int block) {
  if (s.large_motion) return gridpoint_velocities(s, block);
  return block_values(s, block, s.lattice.velocity, &BodyLanes::velocity, &BodyLanes::spin);
}

std::vector<std::array<double, 6>> block_stress(const Simulation::Impl& s, int block) {
  if (s.large_motion) return zone_stresses(s, block);
  const Model& model = s.model;
  const Model::BlockPlace& place = model.place[at(block)];
  std::vector<std::array<double, 6>> result;
  if (place.group < 0) return result;
  const BrickTemplate& shape = model.templates[at(model.groups[at(place.group)].brick_template)];
  const auto u = block_displacement(s, block);
  for (const Zone& zone : shape.zone) {
    result.push_back(zone_stress(zone,
                                 {u[at(zone.node[0])], u[at(zone.node[1])], u[at(zone.node[2])], u[at(zone.node[3])]},
                                 shape.lambda, shape.shear_modulus));
  }
  return result;
}

std::vector<ContactPoint> contact_points(const Simulation::Impl& s, const PointRange& range, bool own_alone) {
  const auto wanted = [&](int block_a) { return !own_alone || owns_block(s, block_a); };
  if (s.large_motion) return points_in_large_motion(s, range, wanted);
  const Model& model = s.model;
  const std::vector<std::uint32_t> flags = current_flags(s, range);
  std::vector<ContactPoint> result;
  for (std::int32_t i = range.first; i < range.end; ++i) {
    const std::size_t p = at(i), n = model.point_axis[p];
    const Model::Sides sides = model.sides_of(i);
    if (!wanted(sides.a)) continue;
    ContactPoint point{};
    point.index = i;
    point.position = model.point_position[p];
    point.normal[n] = point.s[(n + 1) % 3] = point.t[(n + 2) % 3] = 1.0;
    point.area = model.area[p];
    point.joint = model.point_joint[p];
    point.family = model.assembly.joints[at(point.joint)].family;
    point.block_a = sides.a;
    point.block_b = sides.b;
    point.jump = jump_at_traction(s, i);
    point.jump[0] = opening_at_traction(s, i);
    point.traction = {s.lattice.traction[0][p], s.lattice.traction[1][p], s.lattice.traction[2][p]};
    point.flags = flags[at(i - range.first)];
    point.condition = condition_of(point.flags);
    result.push_back(point);
  }
  return result;
}

std::pair<Vec3, Vec3> displacement_of_sides(const Simulation::Impl& s, std::int32_t point) {
  return motion_of_sides(s, point, 1.0, 0.0);
}

std::vector<double> law_state(const Simulation::Impl& s, const std::string& id, const PointRange& range) {
  std::vector<double> result(at(range.end - range.first), std::numeric_limits<double>::quiet_NaN());
  std::int32_t before = 0;  // points of the families before
  for (std::size_t f = 0; f < s.model.families.size(); ++f) {
    const Material& material = *s.model.families[f].material;
    const int k = material.law().state_index(id);
    const std::int32_t count = points_of_family(s, static_cast<int>(f));
    const std::int32_t first = std::max(range.first, before), end = std::min(range.end, before + count);
    if (k >= 0 && first < end && keeps_state(s, material.api(), at(k)))
      std::copy_n(state_column(s, static_cast<int>(f), at(k)) + (first - before), end - first,
                  result.begin() + (first - range.first));
    before += count;
  }
  return result;
}

std::int32_t points_of_family(const Simulation::Impl& s, int family) {
  return s.large_motion ? static_cast<std::int32_t>(s.large_motion->contacts.families[at(family)].size())
                        : s.model.families[at(family)].point_count;
}

const double* state_column(const Simulation::Impl& s, int family, std::size_t state) {
  if (s.large_motion) return s.large_motion->contacts.families[at(family)].state[state].data();
  return s.lattice.law_state[at(family)].data() + state * at(s.model.families[at(family)].point_count);
}

bool keeps_state(const Simulation::Impl& s, const quoin_law& law, std::size_t state) {
  return s.large_motion || s.contacts.keep_diagnostics || law.states[state]->role != QUOIN_ROLE_DIAGNOSTIC;
}

bool keeps_state(const Simulation::Impl& s, const std::string& id) {
  const auto& families = s.model.families;
  for (std::size_t f = 0; f < families.size(); ++f) {
    const int k = families[f].material->law().state_index(id);
    const bool any = points_of_family(s, static_cast<int>(f)) > 0;
    if (k >= 0 && any && keeps_state(s, families[f].material->api(), at(k))) return true;
  }
  return false;
}

}  // namespace quoin
