// Results of a simulation between steps. Not for inner loops.
#include "step/results.h"

#include <algorithm>
#include <array>
#include <limits>

#include "model/world_results.h"
#include "step/collect.h"
#include "step/lattice_motion.h"
#include "step/points_at_rest.h"
#include "step/state.h"
#include "step/work_division.h"

namespace quoin {

using geometry::Vector;

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

// ---- Blocks in large motion ----------------------------------------------------------------------------------------

BlockMesh mesh_in_large_motion(const Simulation::Impl& s, int block) {
  const blocks::ModelBlock& b = s.large_motion->blocks[block];
  const blocks::Block& input = s.large_motion->assembly.blocks[at(block)];
  BlockMesh mesh;
  mesh.unit = input.unit, mesh.course = input.course, mesh.fixed = input.fixed;
  mesh.face = b.shape->faces;  // the first gridpoints of deformable blocks are the vertices of their shapes
  if (b.body >= 0) {
    const geometry::Matrix turned = matrix(input.orientation);
    for (const Vector& p : b.shape->vertices) mesh.gridpoint.push_back(geometry::array(input.position + turned * p));
    return mesh;
  }
  for (int i = b.first_node; i < b.first_node + b.node_count; ++i)
    mesh.gridpoint.push_back(geometry::array(s.large_motion->nodes.reference[at(i)]));
  for (int z = 0; z < b.zone_count; ++z)
    std::ranges::copy(zone_of(*s.large_motion, block, z).node, mesh.zone.emplace_back().begin());
  return mesh;
}

BlockSize size_in_large_motion(const Simulation::Impl& s, int block) {
  const blocks::ModelBlock& b = s.large_motion->blocks[block];
  BlockSize size;
  size.gridpoints = b.body >= 0 ? b.shape->vertices.size() : static_cast<std::uint64_t>(b.node_count);
  size.zones = static_cast<std::uint64_t>(b.zone_count);
  size.faces = b.shape->faces.size();
  for (const auto& face : b.shape->faces) size.face_corners += face.size();
  return size;
}

std::vector<Vec3> gridpoint_displacements(const Simulation::Impl& s, int block) {
  const blocks::ModelBlock& b = s.large_motion->blocks[block];
  std::vector<Vec3> result;
  const BlockMesh mesh = mesh_in_large_motion(s, block);
  for (std::size_t i = 0; i < mesh.gridpoint.size(); ++i) {
    const Vector now = b.body >= 0 ? corner_of(*s.large_motion, block, static_cast<int>(i))
                                   : s.large_motion->nodes.x[at(b.first_node) + i];
    result.push_back(geometry::array(now - geometry::vector(mesh.gridpoint[i])));
  }
  return result;
}

std::vector<Vec3> gridpoint_velocities(const Simulation::Impl& s, int block) {
  const blocks::ModelBlock& b = s.large_motion->blocks[block];
  std::vector<Vec3> result;
  for (int i = 0; b.body < 0 && i < b.node_count; ++i)
    result.push_back(geometry::array(gridpoint_velocity(*s.large_motion, block, i)));
  for (std::size_t i = 0; b.body >= 0 && i < b.shape->vertices.size(); ++i)
    result.push_back(
        geometry::array(velocity_of(*s.large_motion, block) +
                        cross(spin_of(*s.large_motion, block), corner_of(*s.large_motion, block, static_cast<int>(i)) -
                                                                   position_of(*s.large_motion, block))));
  return result;
}

std::vector<std::array<double, 6>> zone_stresses(const Simulation::Impl& s, int block) {
  std::vector<std::array<double, 6>> result;
  for (int z = 0; z < s.large_motion->blocks[block].zone_count; ++z) {
    const geometry::Matrix stress = zone_stress(*s.large_motion, block, z);
    result.push_back(
        {stress.row[0].x, stress.row[1].y, stress.row[2].z, stress.row[0].y, stress.row[1].z, stress.row[2].x});
  }
  return result;
}

std::vector<ContactPoint> points_in_large_motion(const Simulation::Impl& s, const PointRange& range,
                                                 const std::function<bool(int block)>& wanted) {
  const std::vector<std::uint32_t> flags_there = current_flags(s, range);
  std::vector<ContactPoint> points;
  each_chunk_in(s, range, [&](int index, const PointRange& of_chunk) {
    const blocks::Chunk& chunk = s.large_motion->chunks.all[at(index)];
    const blocks::Family& f = s.large_motion->contacts.families[at(chunk.family)];
    for (std::size_t i = chunk.first; i < chunk.first + chunk.count; ++i) {
      const blocks::Point& p = f.point[i];
      if (!wanted(p.a)) continue;
      const geometry::Matrix r = frame_of(*s.large_motion, p);
      ContactPoint point{};
      point.index = of_chunk.first + static_cast<std::int32_t>(i - chunk.first);
      point.position = geometry::array(place_of(*s.large_motion, p));
      point.normal = geometry::array(r.row[0]);
      point.s = geometry::array(r.row[1]);
      point.t = geometry::array(r.row[2]);
      point.area = p.area;
      point.joint = -1;
      point.family = chunk.family;
      point.block_a = p.a;
      point.block_b = p.b;
      point.jump = {f.normal_jump[i], 0.0, 0.0};  // total slip is a state of laws alone: detection moves points
      point.traction = {f.traction[0][i], f.traction[1][i], f.traction[2][i]};
      point.flags = flags_there[at(point.index - range.first)];
      point.condition = condition_of(point.flags);
      points.push_back(point);
    }
  });
  return points;
}

}  // namespace

// ---- Both kinds of motion ------------------------------------------------------------------------------------------

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
