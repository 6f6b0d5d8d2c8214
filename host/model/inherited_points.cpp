#include "model/inherited_points.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <tuple>

#include "law/property_text.h"
#include "model/contact_frames.h"
#include "model/fields.h"
#include "model/world.h"

namespace quoin::blocks {

using namespace geometry;

void move_facets(Point& p, uint32_t now, uint32_t before) {
  for (int32_t* facet : {&p.facet_a, &p.facet_b}) {
    if (*facet >= 0) *facet += int32_t(now) - int32_t(before);
  }
}

namespace {

constexpr size_t kPointsAPart = 512;  // of the work of one thread at a time

Family without_points(const Family& f) {
  Family without;
  without.material = f.material, without.initial = f.initial, without.dry = f.dry, without.kn = f.kn, without.ks = f.ks;
  without.state.resize(f.state.size());
  for (const PropertyColumn& c : f.columns) without.columns.push_back({c.id, c.is_drawn, c.usual, c.most, {}});
  return without;
}

template <class Array>
void copy_items(const Array& from, std::span<const KeptItems> items, Array& to) {
  for (const KeptItems& k : items) std::copy_n(from.begin() + k.from, k.count, to.begin() + k.to);
}

double normal_stiffness(const Family& f, size_t i) { return stiffness_bounds_at(*f.material, f.columns, i).normal; }

// Plastic closure of a closed point by crushing or dilation since it was placed, m: the law's sigma = kn (d_n +
// closure).
double plastic_closure(const Family& f, size_t i) {
  return f.traction[0][i] < 0 ? f.traction[0][i] / normal_stiffness(f, i) - f.normal_jump[i]
                              : std::max(0.0, -f.normal_jump[i]);
}

}  // namespace

Family copied_points(const Family& f, std::span<const KeptItems> points) {
  Family copies = without_points(f);
  const size_t count = points.empty() ? 0 : points.back().to + points.back().count;
  WorldFields::of_points(
      [&](const Field&, const auto& from, auto& to) {
        if (from.empty()) return;
        to.resize(count);
        copy_items(from, points, to);
      },
      f, copies);
  return copies;
}

std::vector<Location> locations_of(const World& w, const Family& f, const LaneVector<Facet>& facets) {
  std::vector<Location> locations(f.size());
  each_part(w.pool, f.size(), kPointsAPart, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) locations[i] = locate(w, f.point[i], facets);
  });
  return locations;
}

PointsBefore set_aside(const World& w, std::span<const CopiedContact> contacts) {
  PointsBefore before;
  std::vector<std::vector<KeptItems>> points(w.contacts.families.size());
  std::vector<KeptItems> facets;
  for (const CopiedContact& c : contacts) points[size_t(c.family)].push_back(c.points), facets.push_back(c.facets);
  if (!facets.empty()) before.facets.resize(facets.back().to + facets.back().count);
  copy_items(w.contacts.facets, facets, before.facets);
  for (size_t k = 0; k < points.size(); ++k)
    before.families.push_back(copied_points(w.contacts.families[k], points[k]));
  for (const CopiedContact& c : contacts) {
    LaneVector<Point>& copies = before.families[size_t(c.family)].point;
    for (uint32_t i = c.points.to; i < c.points.to + c.points.count; ++i)
      move_facets(copies[i], c.facets.to, c.facets.from);
  }
  for (const Family& f : before.families) {
    before.location.push_back(locations_of(w, f, before.facets));
    std::vector<double>& closure = before.closure.emplace_back(f.size());
    each_part(w.pool, f.size(), kPointsAPart, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) closure[i] = plastic_closure(f, i);
    });
  }
  return before;
}

namespace {

bool has_columns(const World& w, When when) {
  return when == When::with_stiffness_damping ? w.damping.of_contacts()
         : when == When::with_maxwell         ? w.damping.has_maxwell()
         : when == When::with_energies        ? w.books_energy
                                              : true;
}

// Resizes an array and keeps items. With ranks it is allocated again, so that items of other ranks take no memory.
template <class Array>
void keep_items(const World& w, Array& items, std::span<const KeptItems> kept, size_t count) {
  if (!w.part.ranks && !items.empty() && count > 0) return keep_in_place(items, kept, count);
  const Array before = std::exchange(items, Array(count));
  if (!before.empty() && count > 0) copy_items(before, kept, items);
}

}  // namespace

void keep_points(const World& w, Family& f, std::span<const KeptItems> kept, size_t count) {
  // Columns of damping are empty without it, as a stage may have switched it off.
  WorldFields::of_points(
      [&](const Field& field, auto& column) { keep_items(w, column, kept, has_columns(w, field.when) ? count : 0); },
      f);
  for (PropertyColumn& c : f.columns) fill_others(c.values, kept, c.usual);
}

void keep_facets(World& w, std::span<const KeptItems> kept, size_t count) {
  keep_items(w, w.contacts.facets, kept, count);
}

void keep_pairs(World& w, std::span<const KeptItems> kept, size_t count) {
  WorldFields::of_pairs(w, [&](const Field&, auto& items) { keep_items(w, items, kept, count); });
}

namespace {

// Difference of closures below which they count as the same, over the smallest block: far above rounding, far below any
// overlap.
constexpr double kSlightlyApart = 1e-9;

// History of a new point from its nearest old point, and its jump, m.
struct Heir {
  double jump = 0.0;
  double closure = 0.0;           // plastic, m
  double opening = std::nan("");  // change since the last step, m; not a number for a point without history
};

void inherit(const World& w, const Family& old, size_t from, const Contact& c, Family& f, size_t to) {
  for (size_t s = 0; s < f.state.size(); ++s) f.state[s][to] = old.state[s][from];
  for (size_t k = 0; k < f.columns.size(); ++k) f.columns[k].values[to] = old.columns[k].values[from];
  f.normal_jump[to] = old.normal_jump[from];
  if (!old.stored.empty()) f.stored[to] = old.stored[from];
  const Point& q = old.point[from];
  Point& p = f.point[to];
  const bool open = old.traction[0][from] == 0.0 && old.traction[1][from] == 0.0 && old.traction[2][from] == 0.0;
  p.reference = c.initial || !open ? q.reference : 0.0;  // an open dry contact starts from the true gap
  // Joint vectors keep their direction in space: they are turned from the old axes into the new ones. A change of the
  // reference face may swap blocks a and b. Sigma and the traction on the former block a keep their values.
  const double sign = q.a == p.a ? 1.0 : -1.0;
  const Vector s = in_space(w, p, p.s), t = in_space(w, p, p.t);
  const auto turn = [&](const auto& then_s, const auto& then_t, auto& now_s, auto& now_t) {
    const Vector v = sign * (then_s[from] * in_space(w, q, q.s) + then_t[from] * in_space(w, q, q.t));
    std::tie(now_s[to], now_t[to]) = turned_into(s, t, v);
  };
  f.traction[0][to] = old.traction[0][from];
  if (!old.viscous[0].empty() && !f.viscous[0].empty()) f.viscous[0][to] = old.viscous[0][from];
  for (size_t k = 0; k < std::size(f.maxwell) && !old.maxwell[k].empty() && !f.maxwell[k].empty(); k += 3)
    f.maxwell[k][to] = old.maxwell[k][from];
  turn_joint_vectors(old, f, turn);
}

// Plastic closure at a place between old points, m: linear in the smallest triangle of near ones around it. Where there
// is none, as beyond all points, that of the nearest point.
double closure_at(const Vector& place, std::span<const Location> points, std::span<const double> closure,
                  size_t nearest) {
  constexpr size_t kNear = 8;      // points that may be corners
  constexpr double kBeside = 0.1;  // share of a corner, < 0, up to which a place beside a triangle is taken to its edge
  constexpr double kFlat = 1e-6;   // squared sine of an angle below which a triangle is a line
  const auto squared = [&](size_t i) { return dot(points[i].at - place, points[i].at - place); };
  std::vector<size_t> near(points.size());
  std::iota(near.begin(), near.end(), size_t(0));
  std::ranges::stable_sort(near, {}, squared);
  near.resize(std::min(kNear, near.size()));
  double found = closure[nearest], least = HUGE_VAL;
  const auto take = [&](size_t i, size_t j, size_t k) {
    const double size = squared(i) + squared(j) + squared(k);
    const Vector y = points[j].at - points[i].at, z = points[k].at - points[i].at, m = cross(y, z);
    if (size >= least || dot(m, m) <= kFlat * dot(y, y) * dot(z, z)) return;
    auto share = corner_shares(y, z, place - points[i].at);
    if (std::ranges::min(share) < -kBeside) return;
    for (double& of : share) of = std::max(0.0, of);
    found = (share[0] * closure[i] + share[1] * closure[j] + share[2] * closure[k]) / (share[0] + share[1] + share[2]);
    least = size;
  };
  for (size_t i = 0; i < near.size(); ++i) {
    for (size_t j = i + 1; j < near.size(); ++j)
      for (size_t k = j + 1; k < near.size(); ++k) take(near[i], near[j], near[k]);
  }
  return found;
}

// Largest tan of the friction angle of a family's points; 0: its law has none, and strength in shear does not depend on
// pressure.
double friction_of(const Family& f) {
  constexpr const char* kAngle = "friction_angle";
  if (!find_property(f.material->api(), kAngle)) return 0.0;
  double degrees = f.material->number(kAngle);
  for (const PropertyColumn& c : f.columns) {
    if (c.id == kAngle) degrees = std::max(degrees, c.most);
  }
  return std::tan(degrees * std::numbers::pi / 180.0);
}

// Gives new points the elastic energy of those that they replace: the reference gap shifts, and shear traction is
// scaled. Fewer points, or less area, store it at a deeper overlap. The overlap grows by no more than the lost area
// explains.
void keep_energy(World& w, const PointsBefore& before, const Finding& finding, const Contact& c,
                 std::span<const Heir> heirs) {
  struct Sums {
    // m2; sums of area * overlap^2 * stiffness and of area * tau^2 / stiffness, with stiffnesses over those of the mean
    double area = 0.0, normal = 0.0, shear = 0.0;
    double deepest = 0.0, largest = 0.0;  // overlap^2, tau^2
    void add(const Family& f, size_t i, double overlap) {
      const double d2 = std::min(0.0, overlap) * std::min(0.0, overlap),
                   tau2 = f.traction[1][i] * f.traction[1][i] + f.traction[2][i] * f.traction[2][i];
      area += f.point[i].area;
      normal += f.point[i].area * d2 * scatter_factor(f.columns, "normal_stiffness", i);
      if (tau2 > 0.0) shear += f.point[i].area * tau2 / scatter_factor(f.columns, "shear_stiffness", i);
      deepest = std::max(deepest, d2), largest = std::max(largest, tau2);
    }
  };
  Family& f = w.contacts.families[c.family];
  const Family& old = before.families[c.family];
  Sums then, now;
  for (uint32_t i = finding.first; i < finding.first + finding.count; ++i)
    then.add(old, i, before.location[size_t(c.family)][i].jump + before.closure[size_t(c.family)][i]);
  for (uint32_t k = 0; k < c.count; ++k) now.add(f, c.first + k, heirs[k].jump + heirs[k].closure);
  const auto scale = [&](double sum_then, double sum_now, double most_then, double most_now) {
    if (sum_now == 0) return 1.0;
    const double most = std::max(1.0, then.area / now.area) * most_then / most_now;
    return std::sqrt(std::min(sum_then / sum_now, most));
  };
  const double deeper = scale(then.normal, now.normal, then.deepest, now.deepest);
  const double stronger = scale(then.shear, now.shear, then.largest, now.largest);
  std::optional<double> friction;
  constexpr double kSlightly = 1e-9;  // relative; far above the rounding of a traction at its strength
  for (uint32_t k = 0; k < c.count; ++k) {
    const uint32_t i = c.first + k;
    Point& p = f.point[i];
    double jump = heirs[k].jump;
    const double overlap = jump + heirs[k].closure;
    if (overlap < 0) {
      p.reference += (1 - deeper) * overlap;
      if (p.facet_a < 0) p.offset += (1 - deeper) * overlap;
      jump = locate(w, p, w.contacts.facets).jump;
    }
    if (std::isnan(heirs[k].opening)) continue;
    const double pressed = f.traction[0][i];
    // Opening that the point would have had a step ago, so that stiffness damping depends on motion alone.
    f.normal_jump[i] = jump - heirs[k].opening;
    if (f.traction[0][i] <= 0)
      f.traction[0][i] = std::min(0.0, normal_stiffness(f, i) * (f.normal_jump[i] + heirs[k].closure));
    if (!f.old_jump.empty()) f.old_jump[i] = f.normal_jump[i];
    // A traction within the strength c + mu |sigma| stays within it, as it falls by mu times the pressure that is lost.
    // So bonded and elastic joints keep what friction does not carry. Where friction carries all, it falls in
    // proportion.
    const double shear = std::hypot(f.traction[1][i], f.traction[2][i]), lost = f.traction[0][i] - pressed;
    double most = pressed < 0.0 ? f.traction[0][i] / pressed : 1.0;
    if (pressed < 0.0 && lost > 0.0) {
      if (!friction) friction = friction_of(f);
      if (shear > (1.0 + kSlightly) * *friction * -pressed) most = 1.0 - *friction * lost / shear;
    }
    const double share = std::min(stronger, most);
    f.traction[1][i] *= share, f.traction[2][i] *= share;
  }
}

}  // namespace

// New points inherit the history of the nearest old point of their contact. Old points have moved along with their
// blocks. A new point's state has the closure of the nearest one. Its reference gap takes up how closure varies between
// points. Without that a point that moves into a crushed toe would be pressed by all that the toe has yielded.
void hand_over(World& w, const PointsBefore& before, const Finding& finding, const Contact& c,
               std::span<const NewPoint> points, bool at_start) {
  Family& f = w.contacts.families[c.family];
  const Family& old = before.families[c.family];
  double old_area = 0.0;
  for (uint32_t j = finding.first; j < finding.first + finding.count; ++j) old_area += old.point[j].area;
  const double radius2 =
      finding.count > 0 ? std::max(2.0 * old_area / finding.count, 1e-4 * w.detection.size * w.detection.size) : 0.0;
  const auto then = std::span(before.location[size_t(c.family)]).subspan(finding.first, finding.count);
  const auto closure = std::span(before.closure[size_t(c.family)]).subspan(finding.first, finding.count);
  thread_local std::vector<double> of_gap;  // plastic closure against the gaps of the points, m
  of_gap.clear();
  for (size_t j = 0; j < closure.size(); ++j) of_gap.push_back(closure[j] - old.point[finding.first + j].reference);
  const auto [least, most] = std::ranges::minmax_element(of_gap);
  const bool varies = !of_gap.empty() && *most - *least > kSlightlyApart * w.detection.size;
  thread_local std::vector<Heir> heirs;
  heirs.assign(points.size(), {});
  uint32_t next_facet = c.first_facet;
  const auto put = [&](const Facet& facet) {
    w.contacts.facets[next_facet] = facet;
    return int32_t(next_facet++);
  };
  for (size_t k = 0; k < points.size(); ++k) {
    const uint32_t to = c.first + uint32_t(k);
    Point& p = f.point[to];
    p = points[k].point;
    if (p.facet_a >= 0) p.facet_a = put(points[k].facet_a);
    if (p.facet_b >= 0) p.facet_b = put(points[k].facet_b);
    if (!f.old_jump.empty()) f.old_jump[to] = std::nan("");  // no rate, so no viscous traction, in the first step
    long nearest = -1;
    double best = radius2;
    for (uint32_t j = finding.first; j < finding.first + finding.count; ++j) {
      const Vector d = then[j - finding.first].at - p.at;
      if (dot(d, d) < best) best = dot(d, d), nearest = long(j);
    }
    if (nearest >= 0) {
      inherit(w, old, size_t(nearest), c, f, to);
      const size_t heir_of = size_t(nearest) - finding.first;
      const bool is_open = f.traction[0][to] == 0.0 && closure[heir_of] == 0.0;  // the true gap counts
      if (varies && !is_open) p.reference += of_gap[heir_of] - closure_at(p.at, then, of_gap, heir_of);
    } else {
      const bool bonded = at_start && points[k].joint;
      const auto& values = bonded ? f.initial : f.dry;
      for (size_t s = 0; s < f.state.size(); ++s) f.state[s][to] = values[s];
      if (!bonded) p.reference = 0.0;
    }
    // Zero of the jumps: d_n counts from the reference gap. Slip counts from here, less the slip of the last step that
    // the law has not integrated yet.
    if (p.facet_a < 0) p.offset += p.reference;
    const Location now = locate(w, p, w.contacts.facets);
    p.at = now.at, heirs[k].jump = now.jump;
    // A point that has made no step has not slipped: results may be written before the next one.
    for (int axis = 0; axis < 2; ++axis) f.slid[axis][to] = now.slid[axis], f.slip[axis][to] = 0.0;
    if (nearest >= 0) {
      const Point& q = old.point[nearest];
      const Location& moved = then[size_t(nearest) - finding.first];
      heirs[k] = {now.jump, closure[size_t(nearest) - finding.first], moved.jump - old.normal_jump[nearest]};
      const Vector pending = in_space(
          w, q,
          (moved.slid[0] - old.slid[0][size_t(nearest)]) * q.s + (moved.slid[1] - old.slid[1][size_t(nearest)]) * q.t);
      const double sign = q.a == p.a ? 1.0 : -1.0;
      f.slid[0][to] -= sign * dot(pending, in_space(w, p, p.s)),
          f.slid[1][to] -= sign * dot(pending, in_space(w, p, p.t));
    }
  }
  if (!at_start) keep_energy(w, before, finding, c, heirs);
}

std::vector<double> energies_of_points(const World& w, Family& f, std::span<const Location> locations) {
  std::vector<double> energies(f.size());
  if (!(f.material->api().capabilities & QUOIN_CAN_ENERGY)) return energies;
  for (auto* column : {&f.normal_jump, &f.slip[0], &f.slip[1]}) column->resize(f.size());
  f.stored.assign(f.size(), 0.0);
  for (auto& column : f.dissipated) column.assign(f.size(), 0.0);
  each_part(w.pool, f.size(), kChunk, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      f.normal_jump[i] = locations[i].jump;
      for (int k = 0; k < 2; ++k) f.slip[k][i] = locations[i].slid[k] - f.slid[k][i];
    }
    Chunk part;
    part.first = uint32_t(begin), part.count = uint32_t(end - begin);
    bind(w, f, part);
    part.call.evaluate(*f.material);
    for (size_t i = begin; i < end; ++i) {
      double density = f.stored[i];
      for (const auto& d : f.dissipated) density += d[i];
      energies[i] = density * f.point[i].area;
    }
  });
  return energies;
}

}  // namespace quoin::blocks
