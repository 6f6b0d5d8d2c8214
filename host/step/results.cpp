// What can be read from a simulation between steps. Cold.
#include <algorithm>
#include <array>
#include <limits>

#include "step/large_motion_results.h"
#include "step/lattice_motion.h"
#include "step/points_at_rest.h"
#include "step/state.h"

namespace quoin {

namespace {

// x fastest, then y, z.
std::array<Vec3, 8> corners_of(const Brick& brick) {
  std::array<Vec3, 8> corners;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    for (std::size_t c = 0; c < 3; ++c)
      corners[k][c] = brick.origin[c] + static_cast<double>(k >> c & 1) * brick.size[c];
  }
  return corners;
}

Vec3 read_line(const LaneVector<double>& values, std::size_t offset) {
  return {values[offset], values[offset + kLanes], values[offset + 2 * kLanes]};
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
  s.model.for_each_gridpoint(block, [&](std::size_t offset, double) { result.push_back(read_line(values, offset)); });
  return result;
}

}  // namespace

std::vector<HotArray> Simulation::hot_arrays() const {
  const Impl& s = *impl_;
  const Model& model = s.model;
  const std::size_t lanes = at(model.block_line_count) * kLine * sizeof(double), points = at(model.point_count);
  std::size_t own_inertia = 0, state_columns = 0;
  for (std::size_t g = 0; g < model.groups.size(); ++g) {
    const auto t = at(model.groups[g].brick_template);
    if (!s.inertia.shared_dt_over_mass[g]) own_inertia += at(model.templates[t].node_count) * kLine * sizeof(double);
  }
  struct Slots {
    std::size_t all = 0, scattered = 0;
  } of_blocks, of_bodies;
  const auto count_slots = [&](int first, int count, Slots* slots) {
    for (int i = first; i < first + count; ++i) {
      const std::int32_t run = model.slot_run[at(i)];
      ++slots->all;
      if (run == -1) ++slots->scattered;
    }
  };
  for (const BlockGroup& group : model.groups)
    count_slots(group.first_slot, model.slots[at(group.brick_template)].slot_count(), &of_blocks);
  for (const BodyGroup& group : model.body_groups)
    count_slots(group.first_slot, model.body_slots[at(group.slots)].slot_count(), &of_bodies);
  std::size_t driven_groups = 0;
  for (const BodyLanes& body : s.lattice.bodies) driven_groups += body.any_prescribed ? 1 : 0;
  for (const LawCall& call : s.contacts.calls) {
    for (const quoin_out& column : call.state_new) state_columns += column.data ? call.batch.count : 0;
  }
  const std::size_t quantity = sizeof(BodyLanes::Quantity), body_records = s.lattice.bodies.size();
  return {
      {"displacement of gridpoints", HotOf::block, lanes},
      {"velocity of gridpoints", HotOf::block, lanes},
      {"inertia, where blocks of a group differ", HotOf::block, own_inertia},
      {"where slots find their points in a row", HotOf::block, of_blocks.all * sizeof(std::int32_t)},
      {"where other slots find their points", HotOf::block, of_blocks.scattered * kLanes * sizeof(std::int32_t)},
      {"displacement, rotation, velocity, spin", HotOf::rigid_body, 4 * quantity * body_records},
      {"applied force", HotOf::rigid_body, quantity * body_records},
      {"prescribed velocity, where bodies are driven", HotOf::rigid_body, 3 * quantity * driven_groups},
      {"mass, dt over inertia", HotOf::rigid_body, 7 * kLanes * sizeof(double) * s.inertia.of_body_group.size()},
      {"gridpoints: displacement along the normal, velocity across", HotOf::rigid_body,
       of_bodies.all * kLine * sizeof(double)},
      {"where slots find their points in a row", HotOf::rigid_body, of_bodies.all * sizeof(std::int32_t)},
      {"where other slots find their points", HotOf::rigid_body, of_bodies.scattered * kLanes * sizeof(std::int32_t)},
      {"offsets of the two gridpoints", HotOf::contact_point, 2 * points * sizeof(std::int32_t)},
      {"gridpoints in a row from here on", HotOf::contact_point, points * sizeof(std::uint8_t)},
      {"area", HotOf::contact_point, points * sizeof(double)},
      {"traction", HotOf::contact_point, 3 * points * sizeof(double)},
      {"force", HotOf::contact_point, 3 * points * sizeof(double)},
      {"state of the law", HotOf::contact_point, state_columns * sizeof(double)}};
}

long Simulation::block_count() const {
  if (impl_->large_motion) return impl_->large_motion->block_count();
  return static_cast<long>(impl_->model.assembly.bricks.size());
}

long Simulation::zone_count() const {
  return static_cast<long>(impl_->large_motion ? impl_->large_motion->zone_count() : impl_->model.zone_count());
}

Simulation::BlockMesh Simulation::block_mesh(int block) const {
  if (impl_->large_motion) return mesh_in_large_motion(*impl_, block);
  const Model& model = impl_->model;
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

Simulation::BlockSize Simulation::block_size(int block) const {
  if (impl_->large_motion) return size_in_large_motion(*impl_, block);
  constexpr std::uint64_t kFaces = 6, kFaceCorners = 24, kCorners = 8;
  if (impl_->model.place[at(block)].body >= 0) return {kCorners, 0, kFaces, kFaceCorners};
  const BrickTemplate& shape = impl_->model.template_of(block);
  return {at(shape.node_count), shape.zone.size(), kFaces, kFaceCorners};
}

std::vector<Vec3> Simulation::block_displacement(int block) const {
  if (impl_->large_motion) return gridpoint_displacements(*impl_, block);
  return block_values(*impl_, block, impl_->lattice.displacement, &BodyLanes::displacement, &BodyLanes::rotation);
}

std::vector<Vec3> Simulation::block_velocity(int block) const {
  if (impl_->large_motion) return gridpoint_velocities(*impl_, block);
  return block_values(*impl_, block, impl_->lattice.velocity, &BodyLanes::velocity, &BodyLanes::spin);
}

std::vector<std::array<double, 6>> Simulation::block_stress(int block) const {
  if (impl_->large_motion) return zone_stresses(*impl_, block);
  const Model& model = impl_->model;
  const Model::BlockPlace& place = model.place[at(block)];
  std::vector<std::array<double, 6>> result;
  if (place.group < 0) return result;
  const BrickTemplate& shape = model.templates[at(model.groups[at(place.group)].brick_template)];
  const BlockMaterial& material = model.assembly.materials[at(shape.material)];
  const auto u = block_displacement(block);
  for (const Zone& zone : shape.zone) {
    result.push_back(zone_stress(zone,
                                 {u[at(zone.node[0])], u[at(zone.node[1])], u[at(zone.node[2])], u[at(zone.node[3])]},
                                 material.young_modulus, material.poisson_ratio));
  }
  return result;
}

std::vector<ContactPoint> Simulation::contact_points(const PointRange& range, bool own_alone) const {
  const auto wanted = [&](int block_a) { return !own_alone || owns_block(block_a); };
  if (impl_->large_motion) return points_in_large_motion(*impl_, range, wanted);
  const Model& model = impl_->model;
  const std::vector<std::uint32_t> flags = current_flags(*impl_, range);
  std::vector<ContactPoint> result;
  for (std::int32_t i = range.first; i < range.end; ++i) {
    const std::size_t p = at(i), n = model.point_axis[p], s = (n + 1) % 3, t = (n + 2) % 3;
    const Model::Sides sides = model.sides_of(i);
    if (!wanted(sides.a)) continue;
    ContactPoint point{};
    point.index = i;
    point.position = model.point_position[p];
    point.normal[n] = point.s[s] = point.t[t] = 1.0;
    point.area = model.area[p];
    point.joint = model.point_joint[p];
    point.family = model.assembly.joints[at(point.joint)].family;
    point.block_a = sides.a;
    point.block_b = sides.b;
    point.jump = jump_at_traction(*impl_, i);
    point.traction = {impl_->lattice.traction[0][p], impl_->lattice.traction[1][p], impl_->lattice.traction[2][p]};
    point.flags = flags[at(i - range.first)];
    point.condition = condition_of(point.flags);
    result.push_back(point);
  }
  return result;
}

std::pair<Vec3, Vec3> Simulation::displacement_of_sides(std::int32_t point) const {
  return motion_of_sides(*impl_, point, 1.0, 0.0);
}

std::vector<double> Simulation::state(const std::string& id, const PointRange& range) const {
  if (impl_->large_motion) return state_in_large_motion(*impl_, id, range);
  std::vector<double> result(at(range.end - range.first), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t f = 0; f < impl_->model.families.size(); ++f) {
    const ContactFamily& family = impl_->model.families[f];
    const quoin_law& law = family.material->api();
    const int k = family.material->law().state_index(id);
    if (k < 0 || (law.states[k]->role == QUOIN_ROLE_DIAGNOSTIC && !impl_->contacts.keep_diagnostics)) continue;
    const std::int32_t first = std::max(range.first, family.first_point);
    const std::int32_t end = std::min(range.end, family.first_point + family.point_count);
    if (first < end)
      std::copy_n(impl_->lattice.law_state[f].begin() + k * family.point_count + (first - family.first_point),
                  end - first, result.begin() + (first - range.first));
  }
  return result;
}

bool Simulation::keeps_state(const std::string& id) const {
  const auto& families = impl_->model.families;
  for (std::size_t f = 0; f < families.size(); ++f) {
    const int k = families[f].material->law().state_index(id);
    if (k < 0) continue;
    const bool diagnostic = families[f].material->api().states[k]->role == QUOIN_ROLE_DIAGNOSTIC;
    if (impl_->large_motion ? impl_->large_motion->families()[f].size() > 0
                            : families[f].point_count > 0 && (!diagnostic || impl_->contacts.keep_diagnostics))
      return true;
  }
  return false;
}

}  // namespace quoin
