#include "results/surface.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "step/results.h"

namespace quoin {

namespace {

// Reference positions agree to rounding; a micrometre grid separates gridpoints.
std::int64_t micrometres(double length) { return std::llround(length * 1e6); }

// Crack of a dry joint, which has no strength to lose: by its current state and its slip.
Crack classify_dry(const JointPoint& p, bool slip_known) {
  constexpr double kVisible = 1e-5;  // m; a hair is 5 times as wide, and creep of joints at rest is less
  if ((p.contact.flags & QUOIN_FLAG_OPEN) != 0 && p.opening > kVisible) return Crack::open;
  const bool slipped = slip_known ? p.slip > kVisible : (p.contact.flags & QUOIN_FLAG_SLIPPING) != 0;
  return slipped ? Crack::slipped : Crack::intact;
}

Crack classify(const JointPoint& p) {
  constexpr double kVisible = 0.02;  // damage below this is not visible as a crack
  const double damage = std::max(p.damage_tension, p.damage_shear);
  if (damage < kVisible) return Crack::intact;
  const bool opening = p.opening > p.slip;
  if (damage < 1.0) return opening ? Crack::opening_begun : Crack::sliding_begun;
  return opening ? Crack::open : Crack::slipped;
}

// The points of a joint form a grid over its two tangential axes.
class JointGrid {
 public:
  void clear() { points_.clear(), rows_.clear(), columns_.clear(); }
  void add(int point, int axis, const Vec3& position) {
    std::int64_t tangential[2];
    for (int k = 0, c = 0; c < 3; ++c) {
      if (c != axis) tangential[k++] = micrometres(position[static_cast<size_t>(c)]);
    }
    points_.push_back({tangential[0], tangential[1], point});
    rows_.push_back(tangential[0]), columns_.push_back(tangential[1]);
  }
  void append_quads(std::vector<Surfaces::Quad>& quads) {
    for (auto* places : {&rows_, &columns_}) {
      std::sort(places->begin(), places->end());
      places->erase(std::unique(places->begin(), places->end()), places->end());
    }
    const auto index_in = [](const std::vector<std::int64_t>& places, std::int64_t place) {
      return static_cast<size_t>(std::lower_bound(places.begin(), places.end(), place) - places.begin());
    };
    const size_t width = columns_.size();
    grid_.assign(rows_.size() * width, -1);
    for (const Point& p : points_) grid_[index_in(rows_, p.row) * width + index_in(columns_, p.column)] = p.index;
    for (size_t r = 0; r + 1 < rows_.size(); ++r) {
      for (size_t c = 0; c + 1 < width; ++c) {
        const int* const p = grid_.data() + r * width + c;
        if (p[0] >= 0 && p[1] >= 0 && p[width] >= 0 && p[width + 1] >= 0)
          quads.push_back({p[0], p[width], p[width + 1], p[1]});
      }
    }
  }

 private:
  struct Point {
    std::int64_t row, column;
    int index;
  };
  std::vector<Point> points_;
  std::vector<std::int64_t> rows_, columns_;
  std::vector<int> grid_;
};

}  // namespace

std::vector<std::int32_t> points_by_joint(const Simulation& simulation) {
  const Model& model = simulation.model();
  std::vector<std::int32_t> order;
  for (int c = 0; c < static_cast<int>(model.chunks.size()); ++c) {
    const ContactChunk& chunk = model.chunks[static_cast<size_t>(c)];
    for (int i = 0; model.has_laid_out(c) && i < chunk.point_count; ++i) order.push_back(chunk.first_point + i);
  }
  const auto joint_of = [&](std::int32_t point) { return model.point_joint[static_cast<size_t>(point)]; };
  std::stable_sort(order.begin(), order.end(),
                   [&](std::int32_t a, std::int32_t b) { return joint_of(a) < joint_of(b); });
  return order;
}

const std::vector<Surfaces::Quad>& Surfaces::quads(const Simulation& simulation) const {
  // Contact points of large motion have no fixed joints and thus no quads.
  const Model& model = simulation.model();
  if (simulation.large_motion() || of_layout_ == model.layouts()) return quads_;
  of_layout_ = model.layouts();
  quads_.clear();
  const std::vector<std::int32_t> order = points_by_joint(simulation);
  const auto joint_of = [&](std::int32_t point) { return model.point_joint[static_cast<size_t>(point)]; };
  JointGrid grid;
  for (auto first = order.begin(), last = first; first != order.end(); first = last) {
    grid.clear();
    for (; last != order.end() && joint_of(*last) == joint_of(*first); ++last) {
      const auto p = static_cast<size_t>(*last);
      grid.add(*last, model.point_axis[p], model.point_position[p]);
    }
    grid.append_quads(quads_);
  }
  return quads_;
}

std::span<const Surfaces::Quad> Surfaces::quads_of_joints(const Simulation& simulation, int first, int end) const {
  const std::vector<Quad>& all = quads(simulation);
  const auto from = [&](int joint) {
    return std::partition_point(all.begin(), all.end(), [&](const Quad& quad) {
      return simulation.model().point_joint[static_cast<size_t>(quad[0])] < joint;
    });
  };
  return {from(first), from(end)};
}

JointPoint joint_point(const Simulation& simulation, const ContactPoint& contact, const LawView& law) {
  JointPoint p{};
  p.contact = contact;
  if (!simulation.large_motion()) {
    std::tie(p.side_a, p.side_b) = displacement_of_sides(simulation, contact.index);
    for (size_t axis = 0; axis < 3; ++axis) p.displacement[axis] = (p.side_a[axis] + p.side_b[axis]) / 2;
  }
  p.opening = std::max(0.0, contact.jump[0]);
  p.slip = std::isfinite(law.slip) ? law.slip : std::hypot(contact.jump[1], contact.jump[2]);
  // Without damage, the flags of a law show whether damage has begun and whether it is complete.
  const auto damage = [&](std::size_t mode, std::uint32_t begun, std::uint32_t complete) {
    if (std::isfinite(law.damage[mode])) return law.damage[mode];
    return (contact.flags & complete) != 0 ? 1.0 : (contact.flags & begun) != 0 ? 0.5 : 0.0;
  };
  p.damage_tension = damage(QUOIN_DAMAGE_TENSION, QUOIN_FLAG_TENSION_DAMAGED, QUOIN_FLAG_TENSION_COMPLETE);
  p.damage_shear = damage(QUOIN_DAMAGE_COHESION, QUOIN_FLAG_SHEAR_DAMAGED, QUOIN_FLAG_SHEAR_COMPLETE);
  p.closure = std::isfinite(law.closure) ? law.closure : 0.0;
  // Contact points of large motion are placed again, so that only the law has their slip.
  const bool slip_known = std::isfinite(law.slip) || !simulation.large_motion();
  if (contact.condition == Condition::crushed_out || contact.condition == Condition::crushing)
    p.crack = Crack::crushed;
  else if (simulation.assembly().families[static_cast<size_t>(contact.family)].initial_state == "dry")
    p.crack = classify_dry(p, slip_known);
  else
    p.crack = classify(p);
  return p;
}

std::vector<JointPoint> Surfaces::joint_points(const Simulation& simulation, const PointRange& range,
                                               bool own_alone) const {
  const auto contacts = contact_points(simulation, range, own_alone);
  if (contacts.empty()) return {};
  const auto damage = damage_of_points(simulation, range);
  const auto slip = law_state(simulation, "slip", range), closure = law_state(simulation, "w", range);
  std::vector<JointPoint> points;
  points.reserve(contacts.size());
  for (const ContactPoint& c : contacts) {
    const auto i = static_cast<size_t>(c.index - range.first);
    LawView law{{}, slip[i], closure[i]};
    for (std::size_t mode = 0; mode < law.damage.size(); ++mode) law.damage[mode] = damage[mode][i];
    points.push_back(joint_point(simulation, c, law));
  }
  return points;
}

}  // namespace quoin
