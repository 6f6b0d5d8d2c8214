#include "step/take_damage.h"

#include <fmt/core.h>

#include <algorithm>
#include <optional>

#include "base/error.h"
#include "model/contact_frames.h"
#include "model/placed_points.h"
#include "model/world_results.h"
#include "step/existing_damage.h"
#include "step/rank_agreement.h"
#include "step/state.h"
#include "step/work_division.h"

namespace quoin {

namespace {

void damage_large_motion(Simulation::Impl& s, std::size_t f, const std::vector<CrackedBlock>& blocks,
                         std::vector<double>& hit) {
  const blocks::Family& family = s.large_motion->contacts.families[f];
  const std::vector<PlacedPoint> points = blocks::placed_points(*s.large_motion, family);
  const DamagedFamily damaged =
      damage_family(s.scene.damage, s.large_motion->assembly.families[f], s.model.families[f].material, points, points,
                    blocks, family.columns, &hit);
  if (damaged.points == 0) return;
  s.large_motion->replace_law(static_cast<int>(f), s.model.families[f].material, damaged.state, damaged.opening_shift);
}

bool follows_cracks(const std::vector<Damage>& damage) {
  return std::any_of(damage.begin(), damage.end(), [](const Damage& d) { return !d.crack.empty(); });
}

void damage_lattice(Simulation::Impl& s, std::size_t f, const std::vector<CrackedBlock>& blocks,
                    std::vector<double>& hit) {
  const ContactFamily& family = s.model.families[f];
  std::vector<std::int32_t> own;
  for (const int c : chunks_here(s)) {
    const ContactChunk& chunk = s.model.chunks[at(c)];
    for (std::int32_t i = 0; at(chunk.family) == f && i < chunk.point_count; ++i) own.push_back(chunk.first_point + i);
  }
  const std::vector<PlacedPoint> points = placed_points(s.model, own);
  // A crack depends on the place of a whole joint, of which neighbouring ranks may hold parts.
  std::vector<PlacedPoint> of_joints;
  if (follows_cracks(s.scene.damage) && own.size() < at(family.point_count))
    of_joints = placed_points(s.model, points_of_same_joints(s.model, family, own));
  std::vector<PropertyColumn> columns;
  for (const PropertyColumn& whole : family.columns) {
    columns.push_back({whole.id, whole.is_drawn, whole.usual, whole.most, {}});
    for (const std::int32_t p : own) columns.back().values.push_back(whole.values[at(p - family.first_point)]);
  }
  const DamagedFamily damaged = damage_family(s.scene.damage, s.model.assembly.families[f], family.material, points,
                                              of_joints.empty() ? points : of_joints, blocks, columns, &hit);
  if (damaged.points == 0) return;
  s.lattice.normal_shift.resize(at(s.model.point_count));
  for (std::size_t i = 0; i < own.size(); ++i) {
    const auto p = at(own[i] - family.first_point);
    for (std::size_t k = 0; k < family.material->api().state_count; ++k)
      s.lattice.law_state[f][k * at(family.point_count) + p] = damaged.state[k * own.size() + i];
    s.lattice.normal_shift[at(own[i])] = damaged.opening_shift[i];
  }
}

}  // namespace

void take_damage(Simulation::Impl& s) {
  if (s.scene.damage.empty()) return;
  std::vector<CrackedBlock> blocks;
  for (const Brick& b : s.model.assembly.bricks) blocks.push_back({centre_of(b), b.unit});
  for (int b = 0; s.large_motion && b < s.large_motion->block_count(); ++b)
    blocks.push_back({geometry::array(position_of(*s.large_motion, b)), s.large_motion->assembly.blocks[at(b)].unit});
  std::vector<double> hit(s.scene.damage.size(), 0.0);  // contact points by entry of Scene::damage
  std::optional<Error> fault;
  for (std::size_t f = 0; f < s.model.families.size(); ++f) {
    try {
      s.large_motion ? damage_large_motion(s, f, blocks, hit) : damage_lattice(s, f, blocks, hit);
    } catch (const Error& error) {
      if (!fault) fault = error;
    }
  }
  throw_together(s, fault);
  if (s.ranks && !s.large_motion) {
    s.ranks->largest(hit);
    if (any_rank(s, !s.lattice.normal_shift.empty())) s.lattice.normal_shift.resize(at(s.model.point_count));
  }
  for (std::size_t d = 0; d < hit.size(); ++d) {
    if (hit[d] == 0.0)
      throw Error(Exit::bad_input, fmt::format("{}: no contact point of its joints lies there; check from, to, crack "
                                               "(m) and joints",
                                               s.scene.damage[d].source.text));
  }
}

}  // namespace quoin
