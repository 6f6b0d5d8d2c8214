#include "results/surface.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

namespace quoin {

namespace {

// Reference positions agree to rounding; a micrometre grid tells gridpoints apart.
std::int64_t micrometres(double length) { return std::llround(length * 1e6); }

std::uint64_t key_of(const Vec3& p, const Vec3& origin) {
  std::uint64_t key = 0;
  for (size_t i = 0; i < 3; ++i)
    key = key << 21 | (static_cast<std::uint64_t>(micrometres(p[i] - origin[i])) & 0x1fffff);
  return key;
}

// A dry joint has no strength to lose: what has come of it is what it does now and how far it has slid.
Crack classify_dry(const JointPoint& p, bool slip_known) {
  constexpr double kVisible = 1e-5;  // m: a hair is 5 times as wide, and what stands still creeps less as it settles
  if ((p.contact.flags & QUOIN_FLAG_OPEN) != 0 && p.opening > kVisible) return Crack::open;
  const bool slipped = slip_known ? p.slip > kVisible : (p.contact.flags & QUOIN_FLAG_SLIPPING) != 0;
  return slipped ? Crack::slipped : Crack::intact;
}

Crack classify(const JointPoint& p) {
  constexpr double kVisible = 0.02;  // less damage than this is no crack that one could see
  const double damage = std::max(p.damage_tension, p.damage_shear);
  if (damage < kVisible) return Crack::intact;
  const bool opening = p.opening > p.slip;
  if (damage < 1.0) return opening ? Crack::opening_begun : Crack::sliding_begun;
  return opening ? Crack::open : Crack::slipped;
}

}  // namespace

Surfaces::Surfaces(const Simulation& simulation) : bricks_(simulation.assembly().bricks) {
  for (int b = 0; b < simulation.block_count(); ++b) meshes_.push_back(simulation.block_mesh(b));
  if (simulation.riding()) return;  // its contact points come and go: they know their place themselves
  for (size_t b = 0; b < bricks_.size(); ++b) {
    auto& index = gridpoint_.emplace_back();
    if (bricks_[b].rigid) continue;
    for (size_t i = 0; i < meshes_[b].gridpoint.size(); ++i)
      index[key_of(meshes_[b].gridpoint[i], bricks_[b].origin)] = static_cast<int>(i);
  }

  // The points of a joint form a grid over its two tangential axes. Joint by joint, for the grids of all of them take
  // more memory than their points.
  const Model& model = simulation.model();
  std::vector<int> order(static_cast<size_t>(model.point_count));
  std::iota(order.begin(), order.end(), 0);
  const auto joint_of = [&](int point) { return model.point_joint[static_cast<size_t>(point)]; };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return joint_of(a) < joint_of(b); });
  for (auto first = order.begin(), last = first; first != order.end(); first = last) {
    std::map<std::pair<std::int64_t, std::int64_t>, int> grid;
    std::set<std::int64_t> rows, columns;
    for (; last != order.end() && joint_of(*last) == joint_of(*first); ++last) {
      const auto p = static_cast<size_t>(*last);
      std::array<std::int64_t, 2> tangential{};
      for (size_t axis = 0, k = 0; axis < 3; ++axis) {
        if (axis != model.point_axis[p]) tangential[k++] = micrometres(model.point_position[p][axis]);
      }
      grid[{tangential[0], tangential[1]}] = *last;
      rows.insert(tangential[0]), columns.insert(tangential[1]);
    }
    for (auto r = rows.begin(); r != rows.end() && std::next(r) != rows.end(); ++r) {
      for (auto c = columns.begin(); c != columns.end() && std::next(c) != columns.end(); ++c) {
        const auto p00 = grid.find({*r, *c}), p10 = grid.find({*std::next(r), *c});
        const auto p11 = grid.find({*std::next(r), *std::next(c)}), p01 = grid.find({*r, *std::next(c)});
        if (p00 == grid.end() || p10 == grid.end() || p11 == grid.end() || p01 == grid.end()) continue;
        quads_.push_back({p00->second, p10->second, p11->second, p01->second});
      }
    }
  }
}

Vec3 Surfaces::displacement_at(int block, const Vec3& position, const std::vector<Vec3>& displacement) const {
  const size_t b = static_cast<size_t>(block);
  const Brick& brick = bricks_[b];
  if (!brick.rigid) {
    const auto found = gridpoint_[b].find(key_of(position, brick.origin));
    return found == gridpoint_[b].end() ? Vec3{} : displacement[static_cast<size_t>(found->second)];
  }
  // Rigid: 8 corners, x fastest; interpolation between them is exact.
  Vec3 u{};
  for (size_t corner = 0; corner < 8; ++corner) {
    double weight = 1.0;
    for (size_t axis = 0; axis < 3; ++axis) {
      const double f = (position[axis] - brick.origin[axis]) / brick.size[axis];
      weight *= (corner >> axis & 1) != 0 ? f : 1.0 - f;
    }
    for (size_t axis = 0; axis < 3; ++axis) u[axis] += weight * displacement[corner][axis];
  }
  return u;
}

std::vector<JointPoint> Surfaces::joint_points(const Simulation& simulation, bool own_alone) const {
  std::vector<std::vector<Vec3>> displacement;
  for (size_t b = 0; b < bricks_.size(); ++b)
    displacement.push_back(simulation.block_displacement(static_cast<int>(b)));
  const auto contacts = simulation.contact_points(own_alone);
  const auto told = simulation.damage();
  const auto slip = simulation.state("slip"), closure = simulation.state("w");
  auto or_zero = [](double v) { return std::isfinite(v) ? v : 0.0; };

  std::vector<JointPoint> points;
  points.reserve(contacts.size());
  for (const ContactPoint& c : contacts) {
    const size_t i = static_cast<size_t>(c.index);
    JointPoint p{};
    p.contact = c;
    if (!simulation.riding()) {
      p.side_a = displacement_at(c.block_a, c.position, displacement[static_cast<size_t>(c.block_a)]);
      p.side_b = displacement_at(c.block_b, c.position, displacement[static_cast<size_t>(c.block_b)]);
      for (size_t axis = 0; axis < 3; ++axis) p.displacement[axis] = (p.side_a[axis] + p.side_b[axis]) / 2;
    }
    p.opening = std::max(0.0, c.jump[0]);
    p.slip = std::isfinite(slip[i]) ? slip[i] : std::hypot(c.jump[1], c.jump[2]);
    // Where the law does not tell, its flags say whether damage has begun and whether it is complete.
    auto damage = [&](std::size_t mode, std::uint32_t begun, std::uint32_t complete) {
      if (std::isfinite(told[mode][i])) return told[mode][i];
      return (c.flags & complete) != 0 ? 1.0 : (c.flags & begun) != 0 ? 0.5 : 0.0;
    };
    p.damage_tension = damage(QUOIN_DAMAGE_TENSION, QUOIN_FLAG_TENSION_DAMAGED, QUOIN_FLAG_TENSION_COMPLETE);
    p.damage_shear = damage(QUOIN_DAMAGE_COHESION, QUOIN_FLAG_SHEAR_DAMAGED, QUOIN_FLAG_SHEAR_COMPLETE);
    p.closure = or_zero(closure[i]);
    // Points of blocks in large motion are placed anew: how far they have slid only their law can know.
    const bool slip_known = std::isfinite(slip[i]) || !simulation.riding();
    if (c.condition == Condition::crushed_out || c.condition == Condition::crushing)
      p.crack = Crack::crushed;
    else if (simulation.assembly().families[static_cast<size_t>(c.family)].initial_state == "dry")
      p.crack = classify_dry(p, slip_known);
    else
      p.crack = classify(p);
    points.push_back(p);
  }
  return points;
}

}  // namespace quoin
