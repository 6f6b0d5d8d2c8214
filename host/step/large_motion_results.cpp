#include "step/large_motion_results.h"

#include <algorithm>
#include <array>
#include <functional>

#include "law/at_rest.h"
#include "model/world_results.h"
#include "step/points_at_rest.h"
#include "step/results.h"
#include "step/state.h"
#include "step/work_division.h"

namespace quoin {

using geometry::Vector;

void evaluate_large_motion_at_rest(const Simulation::Impl& s, std::uint64_t capability, const PointRange& range,
                                   const PointOutputs& outputs) {
  each_chunk_in(s, range, [&](int index, const PointRange& of_chunk) {
    const blocks::Chunk& chunk = s.large_motion->chunks.all[at(index)];
    const blocks::Family& f = s.large_motion->contacts.families[at(chunk.family)];
    if (!(f.material->api().capabilities & capability)) return;
    const std::size_t first = chunk.first;
    RestingPoints points{
        chunk.count, f.normal_jump.data() + first, {}, {}, batch_columns(f.columns, *f.material, first)};
    for (std::size_t k = 0; k < 3; ++k) points.traction[k] = f.traction[k].data() + first;
    for (const auto& column : f.state) points.state.push_back(column.data() + first);
    quoin_out_u32 flags{};
    evaluate_at_rest(*f.material, points, [&](quoin_batch& batch) {
      outputs(batch, at(of_chunk.first));
      flags = batch.flags;
    });
    if (!flags.data) return;
    // Nothing slips at rest: that is asked with the slip of the last step, which steps keep.
    std::vector<std::uint32_t> in_motion(chunk.count, 0);
    evaluate_at_rest(*f.material, points, [&](quoin_batch& batch) {
      for (std::size_t k = 0; k < 2; ++k) batch.slip_increment[k] = {f.slip[k].data() + first, 1};
      batch.flags = {in_motion.data(), 1};
    });
    for (std::size_t i = 0; i < in_motion.size(); ++i)
      flags.data[static_cast<std::ptrdiff_t>(i) * flags.stride] |= in_motion[i] & QUOIN_FLAG_SLIPPING;
  });
}

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

void each_point_in_large_motion(const Simulation::Impl& s, const std::function<void(std::int32_t, int)>& visit) {
  each_chunk_in(s, all_points(s), [&](int index, const PointRange& of_chunk) {
    const blocks::Chunk& chunk = s.large_motion->chunks.all[at(index)];
    const blocks::Point* const point = &s.large_motion->contacts.families[at(chunk.family)].point[chunk.first];
    for (std::int32_t i = of_chunk.first; i < of_chunk.end; ++i) visit(i, point[i - of_chunk.first].a);
  });
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

}  // namespace quoin
