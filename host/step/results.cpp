// What can be read from a simulation between steps. Cold.
#include <fmt/core.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/fnv_hash.h"
#include "base/rank_rows.h"
#include "step/lattice_fields.h"

namespace quoin {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

Vec3 read_line(const LaneVector<double>& values, std::size_t offset) {
  return {values[offset], values[offset + kLanes], values[offset + 2 * kLanes]};
}

// x fastest, then y, z.
std::array<Vec3, 8> corners_of(const Brick& brick) {
  std::array<Vec3, 8> corners;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    for (std::size_t c = 0; c < 3; ++c)
      corners[k][c] = brick.origin[c] + static_cast<double>(k >> c & 1) * brick.size[c];
  }
  return corners;
}

}  // namespace

Condition condition_of(std::uint32_t flags) {
  if (flags & QUOIN_FLAG_CRUSHING_COMPLETE) return Condition::crushed_out;
  if (flags & QUOIN_FLAG_CRUSHED) return Condition::crushing;
  if ((flags & QUOIN_FLAG_OPEN) && (flags & QUOIN_FLAG_TENSION_COMPLETE)) return Condition::open;
  if (flags & QUOIN_FLAG_SLIPPING) return Condition::slipping;
  if (flags & (QUOIN_FLAG_TENSION_DAMAGED | QUOIN_FLAG_SHEAR_DAMAGED)) return Condition::softening;
  return Condition::elastic;
}

std::vector<HotArray> Simulation::hot_arrays() const {
  const Impl& s = *impl_;
  const Model& model = s.model;
  const std::size_t lanes = at(model.block_line_count) * kLine * sizeof(double), points = at(model.point_count);
  std::size_t own_inertia = 0, state_columns = 0;
  for (std::size_t g = 0; g < model.groups.size(); ++g) {
    const auto t = at(model.groups[g].brick_template);
    if (!s.shared_dt_over_mass[g]) own_inertia += at(model.templates[t].node_count) * kLine * sizeof(double);
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
  for (const BodyLanes& body : s.body_lanes) driven_groups += body.any_prescribed ? 1 : 0;
  for (const LawCall& call : s.calls) {
    for (const quoin_out& column : call.state_new) state_columns += column.data ? call.batch.count : 0;
  }
  const std::size_t quantity = sizeof(BodyLanes::Quantity), body_records = s.body_lanes.size();
  return {
      {"displacement of gridpoints", HotOf::block, lanes},
      {"velocity of gridpoints", HotOf::block, lanes},
      {"inertia, where blocks of a group differ", HotOf::block, own_inertia},
      {"where slots find their points in a row", HotOf::block, of_blocks.all * sizeof(std::int32_t)},
      {"where other slots find their points", HotOf::block, of_blocks.scattered * kLanes * sizeof(std::int32_t)},
      {"displacement, rotation, velocity, spin", HotOf::rigid_body, 4 * quantity * body_records},
      {"applied force", HotOf::rigid_body, quantity * body_records},
      {"prescribed velocity, where bodies are driven", HotOf::rigid_body, 3 * quantity * driven_groups},
      {"mass, dt over inertia", HotOf::rigid_body, 7 * kLanes * sizeof(double) * s.group_inertia.size()},
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
std::size_t Simulation::Impl::contact_point_count() const {
  return large_motion ? static_cast<std::size_t>(large_motion->point_count()) : at(model.point_count);
}
long Simulation::point_count() const { return static_cast<long>(impl_->contact_point_count()); }

const char* condition_name(Condition condition) {
  constexpr const char* names[kConditionCount] = {"crushed_out", "crushing",  "open",
                                                  "slipping",    "softening", "elastic"};
  return names[static_cast<std::size_t>(condition)];
}

Simulation::BlockMesh Simulation::block_mesh(int block) const {
  if (impl_->large_motion) return impl_->mesh_in_large_motion(block);
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
  if (impl_->large_motion) return impl_->size_in_large_motion(block);
  constexpr std::uint64_t kFaces = 6, kFaceCorners = 24, kCorners = 8;
  if (impl_->model.place[at(block)].body >= 0) return {kCorners, 0, kFaces, kFaceCorners};
  const BrickTemplate& shape = impl_->model.template_of(block);
  return {at(shape.node_count), shape.zone.size(), kFaces, kFaceCorners};
}

namespace {

std::vector<Vec3> block_values(const Simulation::Impl& s, int block, const LaneVector<double>& values,
                               BodyLanes::Quantity BodyLanes::*translation, BodyLanes::Quantity BodyLanes::*rotation) {
  const Model::BlockPlace& place = s.model.place[at(block)];
  std::vector<Vec3> result;
  if (place.body >= 0) {
    for (const Vec3& p : corners_of(s.model.assembly.bricks[at(block)]))
      result.push_back(s.of_body_at(place.body, translation, rotation, p));
    return result;
  }
  s.model.for_each_gridpoint(block, [&](std::size_t offset, double) { result.push_back(read_line(values, offset)); });
  return result;
}

}  // namespace

std::vector<Vec3> Simulation::block_displacement(int block) const {
  if (impl_->large_motion) return impl_->gridpoint_displacements(block);
  return block_values(*impl_, block, impl_->displacement, &BodyLanes::displacement, &BodyLanes::rotation);
}

std::vector<Vec3> Simulation::block_velocity(int block) const {
  if (impl_->large_motion) return impl_->gridpoint_velocities(block);
  return block_values(*impl_, block, impl_->velocity, &BodyLanes::velocity, &BodyLanes::spin);
}

std::vector<std::array<double, 6>> Simulation::block_stress(int block) const {
  if (impl_->large_motion) return impl_->zone_stresses(block);
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

void Simulation::Impl::ask_at_rest(std::uint64_t capability, const PointRange& range,
                                   const PointOutputs& outputs) const {
  if (large_motion) return ask_large_motion_at_rest(capability, range, outputs);
  std::vector<double> zero(kChunk, 0.0), normal(kChunk), scratch_columns;
  const auto begin = std::partition_point(model.chunks.begin(), model.chunks.end(),
                                          [&](const ContactChunk& c) { return c.first_point < range.first; });
  for (auto there = begin; there != model.chunks.end() && there->first_point < range.end; ++there) {
    const ContactChunk& chunk = *there;
    const auto index = static_cast<int>(there - model.chunks.begin());
    const auto c = at(index);
    // Points of other ranks that were not gathered have no state to evaluate a law with.
    if (!has_all() && !std::binary_search(share.chunks.begin(), share.chunks.end(), index)) continue;
    const Material& material = *model.families[at(chunk.family)].material;
    if (!(material.api().capabilities & capability)) continue;
    for (int i = 0; i < chunk.point_count; ++i) normal[at(i)] = opening_at_traction(chunk.first_point + i);
    const LawCall& call = calls[c];
    scratch_columns.assign((3 + call.state_new.size()) * kChunk, 0.0);
    quoin_batch batch = call.batch;
    batch.normal_jump = {normal.data(), 1};
    batch.slip_increment[0] = batch.slip_increment[1] = {zero.data(), 1};
    batch.energy_stored = {};
    for (auto& column : batch.dissipated) column = {};
    std::vector<quoin_out> states = call.state_new;
    for (std::size_t k = 0; k < 3; ++k) batch.traction_new[k] = {scratch_columns.data() + k * kChunk, 1};
    for (std::size_t k = 0; k < states.size(); ++k) {
      if (states[k].data) states[k] = {scratch_columns.data() + (3 + k) * kChunk, 1};
    }
    batch.state_new = states.data();
    batch.flags = {};
    outputs(batch, at(chunk.first_point));
    material.evaluate(&batch);
  }
}

// Flags of the last step when it reported them, otherwise those of a step that moves nothing.
std::vector<std::uint32_t> Simulation::Impl::current_flags(const PointRange& range) const {
  if (!large_motion && flags_step == step_count - 1) return {flags.begin() + range.first, flags.begin() + range.end};
  std::vector<std::uint32_t> result(at(range.end - range.first), 0);
  ask_at_rest(QUOIN_CAN_FLAGS, range, [&](quoin_batch& batch, std::size_t first) {
    batch.flags = {result.data() + first - at(range.first), 1};
  });
  return result;
}

PointRange Simulation::all_points() const { return impl_->all_points(); }

Simulation::DamageColumns Simulation::damage(const PointRange& range) const {
  DamageColumns result;
  for (auto& column : result) column.assign(at(range.end - range.first), std::numeric_limits<double>::quiet_NaN());
  impl_->ask_at_rest(QUOIN_CAN_DAMAGE, range, [&](quoin_batch& batch, std::size_t first) {
    for (std::size_t k = 0; k < result.size(); ++k) batch.damage[k] = {result[k].data() + first - at(range.first), 1};
  });
  return result;
}

std::vector<ContactPoint> Simulation::contact_points(const PointRange& range, bool own_alone) const {
  const auto wanted = [&](int block_a) { return !own_alone || owns_block(block_a); };
  if (impl_->large_motion) return impl_->points_in_large_motion(range, wanted);
  const Model& model = impl_->model;
  const std::vector<std::uint32_t> flags = impl_->current_flags(range);
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
    point.jump = impl_->jump_at_traction(i);
    point.traction = {impl_->traction[0][p], impl_->traction[1][p], impl_->traction[2][p]};
    point.flags = flags[at(i - range.first)];
    point.condition = condition_of(point.flags);
    result.push_back(point);
  }
  return result;
}

std::pair<Vec3, Vec3> Simulation::displacement_of_sides(std::int32_t point) const {
  return impl_->motion_of_sides(point, 1.0, 0.0);
}

std::vector<double> Simulation::state(const std::string& id, const PointRange& range) const {
  if (impl_->large_motion) return impl_->state_in_large_motion(id, range);
  std::vector<double> result(at(range.end - range.first), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t f = 0; f < impl_->model.families.size(); ++f) {
    const ContactFamily& family = impl_->model.families[f];
    const quoin_law& law = family.material->api();
    const int k = family.material->law().state_index(id);
    if (k < 0 || (law.states[k]->role == QUOIN_ROLE_DIAGNOSTIC && !impl_->keep_diagnostics)) continue;
    const std::int32_t first = std::max(range.first, family.first_point);
    const std::int32_t end = std::min(range.end, family.first_point + family.point_count);
    if (first < end)
      std::copy_n(impl_->law_state[f].begin() + k * family.point_count + (first - family.first_point), end - first,
                  result.begin() + (first - range.first));
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
                            : families[f].point_count > 0 && (!diagnostic || impl_->keep_diagnostics))
      return true;
  }
  return false;
}

std::array<long, kConditionCount> Simulation::condition_counts() const {
  if (impl_->end_conditions && !impl_->has_all()) return *impl_->end_conditions;
  return impl_->conditions_here();
}

std::array<long, kConditionCount> Simulation::Impl::conditions_here() const {
  std::array<long, kConditionCount> counts{};
  for (const std::uint32_t f : current_flags(all_points())) ++counts[static_cast<std::size_t>(condition_of(f))];
  return counts;
}

namespace {

template <class Values>
void add_to_hash(const Values& values, FnvHash* hash) {
  for (const double value : values) hash->add(std::bit_cast<std::uint64_t>(value));
}
void add_to_hash(const std::vector<BodyLanes>& bodies, FnvHash* hash) {
  for (const BodyLanes& lanes : bodies) {
    for (const auto* quantity : {&lanes.displacement, &lanes.rotation, &lanes.velocity, &lanes.spin}) {
      for (const auto& component : *quantity) add_to_hash(component, hash);
    }
  }
}

}  // namespace

std::array<long, kConditionCount> Simulation::Impl::own_conditions() {
  const std::vector<std::uint32_t> now = current_flags(all_points());
  std::vector<std::size_t> first_of_family{0};
  for (std::size_t f = 0; large_motion && f < large_motion->families().size(); ++f)
    first_of_family.push_back(first_of_family.back() + large_motion->families()[f].size());
  std::array<long, kConditionCount> counts{};
  for (const int c : share.chunks) {
    if (!share.owns_chunk(c, ranks->rank())) continue;
    std::size_t first, count;
    if (large_motion) {
      const auto range = large_motion->range_of_chunk(c);
      first = first_of_family[at(range.family)] + range.first, count = range.count;
    } else {
      first = at(model.chunks[at(c)].first_point), count = at(model.chunks[at(c)].point_count);
    }
    for (std::size_t i = first; i < first + count; ++i) ++counts[static_cast<std::size_t>(condition_of(now[i]))];
  }
  return counts;
}

std::array<long, kConditionCount> Simulation::Impl::conditions_of_all() {
  std::array<long, kConditionCount> sum{};
  for (const auto& counts : of_all_ranks(*ranks, own_conditions())) {
    for (std::size_t k = 0; k < counts.size(); ++k) sum[k] += counts[k];
  }
  return sum;
}

// What results are made of that rank 0 writes afterwards; all of it only where it is not in parts.
void Simulation::Impl::end_run() {
  if (!in_parts) return gather(Part::all);
  if (large_motion)
    large_motion->exchange_parted_blocks();
  else
    receive_whole_borders();
  end_conditions = conditions_of_all();
  gather(Part::row);
  end_hash = hash_by_parts(false);
}

void Simulation::Impl::note_start() {
  start_hash.reset();
  if (!in_parts || (scene.damage.empty() && !large_motion)) return;
  prepare_row();
  start_hash = hash_by_parts(true);
}

// at_rest: all but states of laws is zero.
std::uint64_t Simulation::Impl::hash_by_parts(bool at_rest) {
  const auto give = [&](const void* first, std::size_t bytes, const TakeBytes& take) {
    give_array(first, bytes, take);
  };
  if (large_motion) return large_motion->hash(give);
  FnvHash hash;
  each_lattice_field(*this, [&](const Field& field, const auto& array, int family) {
    if (field.hashed == 0) return;
    if (field.known_to_all || (at_rest && family < 0)) return add_to_hash(array, &hash);
    give(array.data(), array.size() * sizeof array[0], [&](std::span<const std::uint8_t> bytes) {
      add_to_hash(std::span(reinterpret_cast<const double*>(bytes.data()), bytes.size() / sizeof(double)), &hash);
    });
  });
  return hash.value();
}

std::uint64_t Simulation::hash() const {
  if (impl_->end_conditions && !impl_->has_all()) return impl_->end_hash;
  if (impl_->start_hash && impl_->step_count == 0 && !impl_->has_all()) return *impl_->start_hash;
  if (impl_->large_motion) return impl_->large_motion->hash();
  FnvHash hash;
  each_lattice_field(*impl_, [&](const Field& field, const auto& array, int f) {
    if (field.hashed == 0) return;
    if (f < 0 || impl_->holds_all) return add_to_hash(array, &hash);
    // Before the first step: as they begin, for this rank has those of its own points alone.
    const ContactFamily& family = impl_->model.families[at(f)];
    for (const double value : family.material->initial_state(impl_->model.assembly.families[at(f)].initial_state))
      add_to_hash(std::vector<double>(at(family.point_count), value), &hash);
  });
  return hash.value();
}

}  // namespace quoin
