#include "step/monitor.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "model/world_results.h"
#include "scene/weight_axis.h"
#include "step/block_motion.h"
#include "step/gather.h"
#include "step/lattice_motion.h"

namespace quoin {

namespace {

// By block: 1: it is one of these.
std::vector<char> marked(const Simulation::Impl& s, const std::vector<int>& blocks) {
  std::vector<char> marks(at(block_count(s)), 0);
  for (const int block : blocks) marks[at(block)] = 1;
  return marks;
}

// Visits contact points at blocks of the monitor: visit(block, position).
template <class Visit>
void each_point_at(const Simulation::Impl& s, const std::vector<int>& blocks, const Visit& visit) {
  const std::vector<char> watched = marked(s, blocks);
  for (std::int32_t p = 0; !s.large_motion && p < s.model.point_count; ++p) {
    const Model::Sides sides = s.model.sides_of(p);
    for (const int block : {sides.a, sides.b})
      if (watched[at(block)]) visit(block, geometry::vector(s.model.point_position[at(p)]));
  }
  if (!s.large_motion) return;
  for (const blocks::Contact& c : s.large_motion->contacts.list) {
    if (c.count == 0) continue;  // a pair without points may have no family
    const blocks::Family& f = s.large_motion->contacts.families[at(c.family)];
    for (const int block : {c.pair.a, c.pair.b}) {
      for (std::size_t i = c.first; watched[at(block)] && i < c.first + c.count; ++i)
        visit(block, place_of(*s.large_motion, f.point[i]));
    }
  }
}

// Whether contact points lie above these blocks, as over a bottom beam. For blocks with joints above and below,
// rounding must not decide.
bool stand_below(const Simulation::Impl& s, const std::vector<int>& blocks) {
  constexpr double kMostly = 0.5;  // share of the sum of |arm|: joints beside the centre do not count
  const int upright = upright_axis(s.scene);
  const auto height_of = [&](int block) {
    if (s.large_motion) return position_of(*s.large_motion, block)[upright];
    const Brick& brick = s.model.assembly.bricks[at(block)];
    return brick.origin[at(upright)] + 0.5 * brick.size[at(upright)];
  };
  double sum = 0.0, whole = 0.0;
  each_point_at(s, blocks, [&](int block, const geometry::Vector& position) {
    const double arm = position[upright] - height_of(block);
    sum += arm, whole += std::abs(arm);
  });
  return sum > kMostly * whole;
}

bool is_deformable_brick(const Simulation::Impl& s, int block) { return !s.large_motion && !is_rigid(s, block); }

}  // namespace

std::vector<int> watched_by(const Simulation::Impl& s, const Stage& settings) {
  const std::string& name = settings.monitor.empty() ? s.scene.output.monitor : settings.monitor;
  if (name.empty() && settings.displacement)
    throw Error(Exit::bad_input, fmt::format("{}: stage '{}' ends by displacement but has no monitor; give "
                                             "stage.monitor or output.monitor, the name of a block",
                                             settings.source.text, settings.name));
  if (name.empty()) return {};
  std::vector<int> watched = blocks_named(s, name, settings.source.text + ": monitor");
  if (watched.empty())
    throw Error(Exit::bad_input, fmt::format("{}: stage '{}' watches '{}', but no block has that name",
                                             settings.source.text, settings.name, name));
  return watched;
}

void watch_blocks(Simulation::Impl& s, const Stage& settings) {
  s.monitor.blocks = watched_by(s, settings);
  s.monitor.stands_below = stand_below(s, s.monitor.blocks);
  s.monitor.points.clear();
  std::vector<int> deformable = s.monitor.blocks;
  std::erase_if(deformable, [&s](int block) { return !is_deformable_brick(s, block); });
  if (deformable.empty()) return;
  const std::vector<char> watched = marked(s, deformable);
  for (std::int32_t p = 0; p < s.model.point_count; ++p) {
    const Model::Sides sides = s.model.sides_of(p);
    const bool a = watched[at(sides.a)] != 0, b = watched[at(sides.b)] != 0;
    if (a != b) s.monitor.points.push_back({p, a ? 1.0 : -1.0});
  }
}

Vec3 joint_force_on_monitor(const Simulation::Impl& s) {
  Vec3 sum{};
  for (const int block : s.monitor.blocks) {
    if (s.large_motion)
      sum += geometry::array(s.large_motion->step_sums.contact_force[at(block)]);
    else if (!is_deformable_brick(s, block))
      sum += joint_wrench(s, block).force;
  }
  for (std::size_t c = 0; !s.monitor.points.empty() && c < s.contacts.calls.size(); ++c)
    sum += has_all(s) ? sum_on_monitor(s, static_cast<int>(c)) : s.contacts.sums[c].on_monitor;
  return sum;
}

Vec3 sum_on_monitor(const Simulation::Impl& s, int index) {
  const ContactChunk& chunk = s.model.chunks[at(index)];
  const auto n = static_cast<std::size_t>(chunk.axis);
  Vec3 sum{};
  const auto first = std::lower_bound(s.monitor.points.begin(), s.monitor.points.end(), chunk.first_point,
                                      [](const StageMonitor::Point& m, std::int32_t point) { return m.point < point; });
  for (auto m = first; m != s.monitor.points.end() && m->point < chunk.first_point + chunk.point_count; ++m) {
    const auto p = static_cast<std::size_t>(m->point);
    const Vec3 of_point = point_traction(s, p);
    for (std::size_t c = 0; c < 3; ++c) sum[(n + c) % 3] += m->sign * (s.model.area[p] * of_point[c]);
  }
  return sum;
}

}  // namespace quoin
