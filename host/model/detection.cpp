// Contact detection: which blocks are close, where they touch, and what history a new contact point inherits.
#include <fmt/format.h>

#include <set>
#include <tuple>

#include "base/error.h"
#include "geometry/overlap.h"
#include "model/fields.h"
#include "model/world.h"

namespace quoin::blocks {

using namespace geometry;

namespace {
// Faces closer to parallel than this (about 2.5 degrees) at the start can be a joint.
constexpr double parallel_cosine = 0.999;
// Between features that agree within this fraction of the smallest block, the reference face of before is kept.
constexpr double preference_fraction = 1e-4;
// Of the local stiffness bound, before 2/omega_max is looked for again. The step is then longer than its fraction of it
// by the root of this at most.
constexpr double kLeastGrowth = 1.01, kMostGrowth = 1.1;
// Faces of detected overlap merge points within this fraction of the smallest block.
constexpr double merge_fraction = 1e-6;

}  // namespace

struct World::NewPoint {
  Point point;
  Facet facet_a, facet_b;
  bool joint = true;  // within the joint tolerance at the start
};

Placed World::placed(int block) const {
  const ModelBlock& b = blocks_[block];
  const Vector* v = shapes_.placed_corner.data() + b.first_corner;
  Vector centre;
  const size_t n = b.shape->vertices.size();
  for (size_t i = 0; i < n; ++i) centre += v[i];
  return {b.shape, v, shapes_.placed_normal.data() + b.first_normal, centre / double(n)};
}

void World::place_blocks() {
  for (size_t i = 0; i < blocks_.size(); ++i) {
    if (!part_.laid_out[i]) continue;
    const ModelBlock& b = blocks_[i];
    Vector* corner = shapes_.placed_corner.data() + b.first_corner;
    Vector* normal = shapes_.placed_normal.data() + b.first_normal;
    const size_t corners = b.shape->vertices.size(), faces = b.shape->faces.size();
    if (b.body >= 0) {
      const Body& body = bodies_[b.body];
      for (size_t k = 0; k < corners; ++k) corner[k] = body.x + body.r * shapes_.corner[b.first_corner + k];
      for (size_t f = 0; f < faces; ++f) normal[f] = body.r * shapes_.normal[b.first_normal + f];
      continue;
    }
    for (size_t k = 0; k < corners; ++k) corner[k] = nodes_.x[size_t(b.first_node) + k];
    for (size_t f = 0; f < faces; ++f) {
      const auto& face = b.shape->faces[f];
      Vector m;
      for (size_t k = 1; k + 1 < face.size(); ++k) {
        m += cross(corner[face[k]] - corner[face[0]], corner[face[k + 1]] - corner[face[0]]);
      }
      normal[f] = normalized(m);
    }
  }
}

// How far b has moved as seen from a since the pair's last narrow detection: translation plus rotation times radius, m.
double World::pair_motion(const Contact& c, const PairPlace& place, const Pose& a, const Pose& b) const {
  const Vector shift = transposed_times(a.r, b.x - a.x) - place.relative_x;
  const double angle = angle_between(transposed(a.r) * b.r, place.relative_r);
  return norm(shift) + angle * lever_of(c, norm(b.x - a.x));
}

// What a rotation of b as seen from a moves its parts by, m: the larger radius, of a at most what reaches to b.
double World::lever_of(const Contact& c, double distance) const {
  return std::max(blocks_[c.pair.b].radius, std::min(blocks_[c.pair.a].radius, distance));
}

double World::motion_since_broad_phase(int block) const {
  const ModelBlock& b = blocks_[block];
  Vector x;
  Matrix r;
  pose(block, x, r);
  const Pose& broad = poses_.broad[size_t(block)];
  return norm(x - broad.x) + angle_between(r, broad.r) * b.radius;
}

double World::detection_fraction() const {
  return assembly_.contact.small_displacement > 0 ? assembly_.contact.small_displacement : 0.005;
}

double World::allowed_motion(const Contact& c, const PairPlace& place) const {
  const double extent = std::min(blocks_[c.pair.a].least_extent, blocks_[c.pair.b].least_extent);
  const double fraction = detection_fraction();
  if (c.count == 0) return std::max(fraction * extent, 0.5 * place.separation.distance);
  return (c.initial ? std::max(fraction, assembly_.contact.joint_motion) : fraction) * extent;
}

struct World::Finding {
  bool examined = false;
  bool fresh = false;             // new points, or none any more
  size_t begin = 0;               // of its new points in Detection::points, where they are found here
  uint32_t fresh_count = 0;       // of these
  uint32_t first = 0, count = 0;  // its points of before, in their family
  uint32_t first_facet = 0;
};

struct World::Detection {
  bool at_start;
  std::vector<Contact> contacts;  // in the order of the pairs
  LaneVector<PairPlace> places;   // of each contact
  LaneVector<PairCheck> checks;   // the same
  std::vector<Finding> findings;  // the same
  std::vector<NewPoint> points;
  std::vector<Contact> lost;  // had points, and are no longer close to each other
  bool changed = false;       // some contact has other points than before
};

// What a new point has from its nearest old one.
struct World::Heir {
  double closure = 0.0;           // plastic, m
  double opening = std::nan("");  // since the last step, m; not known for a point without history
};

// What contact points were before detection: families without their laws, and where they sat.
struct World::Before {
  std::vector<Family> families;
  LaneVector<Facet> facets;
};

void World::detect_contacts(bool everything) {
  Detection found;
  found.at_start = detection_.count++ == 0;
  take_back_facets();
  place_blocks();
  const std::vector<Pair> pairs = close_pairs(everything);
  std::optional<Error> fault;
  try {
    narrow_phase(pairs, everything, found);
  } catch (const Error& error) {
    fault = error;
  }
  fail_together(fault);
  exchange_findings(found);
  if (found.changed || found.at_start) {
    place_points(found);
  } else {
    contacts_.list = std::move(found.contacts);
    contacts_.place = std::move(found.places);
    checks_.pair = std::move(found.checks);
  }
  for (size_t i = 0; i < contacts_.list.size(); ++i) {
    if (owns(contacts_.list[i])) checks_.next = std::min(checks_.next, checks_.pair[i].step);
  }
  checks_.next = -long(largest(double(-checks_.next)));
  bind_neighbours();
}

// Broad phase: all pairs within the skin, found again when some block has used up its part of it.
std::vector<Pair> World::close_pairs(bool everything) {
  bool stale = everything;
  for (size_t i = 0; i < blocks_.size() && !stale; ++i)
    stale = owns(int(i)) && motion_since_broad_phase(int(i)) > 0.2 * detection_.skin;
  std::vector<Pair> pairs;
  if (!any(stale)) {
    for (const Contact& c : contacts_.list) pairs.push_back(c.pair);
    return pairs;
  }
  std::vector<Box> boxes(blocks_.size());
  const Vector inflate{0.5 * detection_.skin, 0.5 * detection_.skin, 0.5 * detection_.skin};
  for (size_t i = 0; i < blocks_.size(); ++i) {
    if (!part_.laid_out[i]) continue;
    const ModelBlock& b = blocks_[i];
    for (size_t k = 0; k < b.shape->vertices.size(); ++k) boxes[i].include(shapes_.placed_corner[b.first_corner + k]);
    boxes[i].lower -= inflate, boxes[i].upper += inflate;
    pose(int(i), poses_.broad[i].x, poses_.broad[i].r);
  }
  gather_by_block(boxes);
  for (size_t i = 0; i < blocks_.size(); ++i) part_.rough_place[i] = 0.5 * (boxes[i].lower + boxes[i].upper);
  pairs = overlapping_pairs(boxes);
  const auto held = [&](int i) {  // those that stages drive are laid out everywhere
    return blocks_[i].body >= 0 && assembly_.blocks[i].fixed &&
           (!part_.laid_out[size_t(i)] || bodies_[blocks_[i].body].held == 0x3f);
  };
  std::erase_if(pairs, [&](const Pair& p) { return held(p.a) && held(p.b); });
  receive_new_neighbours(pairs);
  return pairs;
}

// Narrow phase: of own pairs those that are new, or have moved enough, are looked at; the others go on as they are.
void World::narrow_phase(const std::vector<Pair>& pairs, bool everything, Detection& found) {
  found.contacts.reserve(pairs.size());
  found.places = LaneVector<PairPlace>(pairs.size());
  found.checks = LaneVector<PairCheck>(pairs.size());
  found.findings.reserve(pairs.size());
  auto old = contacts_.list.begin();
  const auto lose = [&] {
    if (old->count > 0) found.lost.push_back(*old);
    ++old;
  };
  for (const Pair& pair : pairs) {
    while (old != contacts_.list.end() && old->pair < pair) lose();
    const bool known = old != contacts_.list.end() && old->pair == pair;
    const size_t then = size_t(old - contacts_.list.begin()), now = found.contacts.size();
    Contact c;
    if (known) c = *old++;
    c.pair = pair;
    Finding finding;
    finding.first = c.first, finding.count = c.count, finding.first_facet = c.first_facet;
    if (owns(c)) {
      PairPlace& place = found.places[now];
      PairCheck& check = found.checks[now];
      if (known) place = contacts_.place[then], check = checks_.pair[then];
      if (!known || everything || is_ripe(c, place, check)) {
        detect_pair(c, place, known, finding, found);
        check_pair_motion(c, place, pose(c.pair.a), pose(c.pair.b), check);
      }
    }
    found.contacts.push_back(c);
    found.findings.push_back(finding);
  }
  while (old != contacts_.list.end()) lose();
}

// Where the two blocks of a pair touch, and the points that belong there.
void World::detect_pair(Contact& c, PairPlace& place, bool known, Finding& finding, Detection& found) {
  finding.examined = true;
  const Pair pair = c.pair;
  const Placed a = placed(pair.a), b = placed(pair.b);
  place.separation =
      separate(a, b, detection_.skin, preference_fraction * detection_.size, known ? &place.separation : nullptr);
  const double distance = place.separation.distance;
  Vector xa, xb;
  Matrix ra, rb;
  pose(pair.a, xa, ra), pose(pair.b, xb, rb);
  place.relative_x = transposed_times(ra, xb - xa);
  place.relative_r = transposed(ra) * rb;
  if (found.at_start && distance < -detection_.joint_tolerance) {
    throw Error(
        Exit::bad_input,
        fmt::format(
            "blocks {} and {} overlap by {:.3g} m near {} (more than the joint tolerance {:.3g} m); move or cut one "
            "of them",
            label(assembly_, pair.a), label(assembly_, pair.b), -distance, geometry::place(0.5 * (a.centre + b.centre)),
            detection_.joint_tolerance));
  }
  finding.begin = found.points.size();
  if (distance <= detection_.reach) {
    make_points(c, place.separation, found.at_start, found.points);
    finding.fresh = true;
    c.beside_joint |= found.at_start && found.points.size() == finding.begin && distance <= detection_.joint_tolerance;
  } else {
    // Beyond reach the points go, unless one still carries something: a joint that stretches further than the skin.
    c.beside_joint = false;
    finding.fresh = !carries(c);
  }
  const auto fresh = std::span(found.points).subspan(finding.begin);
  if (!fresh.empty() && c.family < 0) name_family(c, place.separation.normal, fresh);
  finding.fresh_count = c.family < 0 ? 0 : uint32_t(fresh.size());  // none: declared to pass through each other
}

// How many points each pair has now, and of what: known to all, so that points have the numbers of one process.
void World::exchange_findings(Detection& found) {
  struct Exchanged {
    int32_t family;
    uint32_t fresh_count;
    bool examined, fresh, beside_joint;
  };
  std::vector<Exchanged> exchanged;
  for (size_t i = 0; part_.ranks && i < found.contacts.size(); ++i) {
    const Finding& f = found.findings[i];
    exchanged.push_back({found.contacts[i].family, f.fresh_count, f.examined, f.fresh, found.contacts[i].beside_joint});
  }
  all_gather(part_.ranks, std::span(exchanged), [&](size_t i) { return rank_of(found.contacts[i]); });
  for (size_t i = 0; i < exchanged.size(); ++i) {
    Contact& c = found.contacts[i];
    Finding& f = found.findings[i];
    c.family = exchanged[i].family, c.beside_joint = exchanged[i].beside_joint;
    f.fresh_count = exchanged[i].fresh_count, f.examined = exchanged[i].examined, f.fresh = exchanged[i].fresh;
  }
  found.changed = !found.lost.empty();
  for (const Finding& f : found.findings) {
    detection_.narrow_calls += f.examined ? 1 : 0;
    found.changed |= f.fresh && (f.fresh_count > 0 || f.count > 0);
  }
}

bool World::carries(const Contact& c) const {
  for (uint32_t i = c.first; i < c.first + c.count; ++i) {
    for (const auto& traction : contacts_.families[c.family].traction) {
      if (traction[i] != 0.0) return true;
    }
  }
  return false;
}

void World::name_family(Contact& c, const Vector& normal, std::span<const NewPoint> points) const {
  Vector middle;
  for (const NewPoint& p : points) middle += p.point.at / double(points.size());
  c.family = assembly_.family_of ? assembly_.family_of({c.pair.a, c.pair.b, normal}) : 0;
  if (c.family >= int(contacts_.families.size())) {
    throw Error(Exit::bad_input, fmt::format("blocks {} and {} meet near {}, and no joint family is given for them",
                                             label(assembly_, c.pair.a), label(assembly_, c.pair.b), place(middle)));
  }
}

// Families with room for the points of now, in the order of the pairs; facets in the order of points.
void World::number_points(Detection& found, Before& before) {
  std::vector<uint32_t> points(contacts_.families.size(), 0), facets(contacts_.families.size(), 0);
  const auto each_contact = [&](const auto& visit) {
    for (size_t i = 0; i < found.contacts.size(); ++i) {
      if (found.contacts[i].family >= 0) visit(found.contacts[i], found.findings[i]);
    }
  };
  each_contact([&](Contact& c, const Finding& finding) {
    c.count = finding.fresh ? finding.fresh_count : finding.count;
    c.initial = c.initial || (found.at_start && c.count > 0);
    c.first = points[size_t(c.family)];
    points[size_t(c.family)] += c.count;
    facets[size_t(c.family)] += c.count * uint32_t(facets_a_point(c));
  });
  for (Contact& c : found.contacts) {
    if (c.family < 0) c.count = 0;
  }
  before.families.resize(contacts_.families.size());
  uint32_t all_facets = 0;
  for (size_t k = 0; k < contacts_.families.size(); ++k) {
    take_points(contacts_.families[k], before.families[k]);
    resize(contacts_.families[k], points[k]);
    all_facets += std::exchange(facets[k], all_facets);
  }
  each_contact([&](Contact& c, const Finding&) {
    c.first_facet = facets[size_t(c.family)];
    facets[size_t(c.family)] += c.count * uint32_t(facets_a_point(c));
  });
  before.facets = std::exchange(contacts_.facets, LaneVector<Facet>(all_facets));
}

// Those that go on are moved, the others made with the history of those nearby. Where several processes share the
// model, those between own blocks and others.
void World::place_points(Detection& found) {
  Before before;
  number_points(found, before);
  if (!found.at_start && start_joints_.kept.empty())
    start_joints_.kept = LaneVector<double>(start_joints_.point.size() * kept_width());
  const auto keep_of = [&](const Contact& c, uint32_t first, uint32_t count) {
    if (c.initial && count > 0 && owns(c.pair.a))
      keep_of_joint(c, before.families[c.family], before.facets, first, count);
  };

  // Energies that are freed, J, in a fixed order, and the pairs that they belong to.
  std::vector<double> freed;
  std::vector<const Contact*> freed_by;
  const auto free = [&](const Contact& c, double energy) {
    if (energy_) freed.push_back(energy), freed_by.push_back(&c);
  };
  for (const Contact& c : found.lost) {
    keep_of(c, c.first, c.count);
    free(c, owns(c) ? energy_of_points(before.families[c.family], before.facets, c.first, c.count) : 0.0);
  }
  // Contacts that go on as they are, one after the other before and now: they are copied together.
  Finding kept;
  Contact together;
  uint32_t facets = 0;
  const auto keep = [&] {
    if (together.count > 0) keep_points(before, kept, together, facets);
    together.count = facets = 0;
  };
  for (size_t i = 0; i < found.contacts.size(); ++i) {
    const Contact& c = found.contacts[i];
    const Finding& finding = found.findings[i];
    if (c.family < 0) continue;
    if (finding.fresh) {
      const bool own = owns(c);
      keep();
      if (!found.at_start) keep_of(c, finding.first, finding.count);
      free(c, own ? energy_of_points(before.families[c.family], before.facets, finding.first, finding.count) : 0.0);
      if (own) hand_over(before, finding, c, std::span(found.points).subspan(finding.begin, c.count), found.at_start);
      free(c, own ? -energy_of_points(contacts_.families[c.family], contacts_.facets, c.first, c.count) : 0.0);
    } else if (c.count > 0 && owns(c)) {
      const uint32_t of_contact = c.count * uint32_t(facets_a_point(c));
      const bool goes_on = together.count > 0 && together.family == c.family &&
                           kept.first + kept.count == finding.first && together.first + together.count == c.first;
      if (goes_on) {
        kept.count += c.count, together.count += c.count, facets += of_contact;
      } else {
        keep();
        kept = finding, together = c, facets = of_contact;
      }
    }
  }
  keep();
  all_gather(part_.ranks, std::span(freed), [&](size_t i) { return rank_of(*freed_by[i]); });
  double sum = 0.0;
  for (const double energy : freed) sum += energy;
  if (energy_) step_sums_.later.detection += sum;
  contacts_.list = std::move(found.contacts);
  contacts_.place = std::move(found.places);
  checks_.pair = std::move(found.checks);
  if (found.at_start) note_start_joints();
  divide_work();
  if (found.at_start) return;
  const double bound = local_stiffness_bound();
  // Springs may grow by what the step has in hand, as its frequency costs many steps.
  const double fraction = solver_.time_step_fraction;
  if (bound <= std::clamp(1.0 / (fraction * fraction), kLeastGrowth, kMostGrowth) * stepping_.stiffness_bound) return;
  std::set<int> changed;
  for (size_t i = 0; i < contacts_.list.size(); ++i) {
    if (!found.findings[i].fresh) continue;
    for (const int block : {contacts_.list[i].pair.a, contacts_.list[i].pair.b}) {
      if (owns(block)) changed.insert(units_.of(block).block[0]);
    }
  }
  if (any(shorten_step(std::vector<int>(changed.begin(), changed.end()))))
    find_time_step();
  else
    stepping_.stiffness_bound = bound;
}

void World::note_start_joints() {
  uint32_t points = 0;
  for (const Contact& c : contacts_.list) {
    if (c.count > 0) start_joints_.joint.push_back({c.pair, c.family, points, c.count});
    points += c.count;
  }
  start_joints_.point = LaneVector<StartPoint>(points);
  auto joint = start_joints_.joint.begin();
  for (const Contact& c : contacts_.list) {
    if (c.count == 0) continue;
    for (uint32_t k = 0; k < c.count && owns(c); ++k) {
      const Point& p = contacts_.families[c.family].point[c.first + k];
      start_joints_.point[joint->first + k] = {p.at, p.area};
    }
    ++joint;
  }
}

void World::take_points(Family& f, Family& into) {
  into = std::move(f);
  f = {};
  f.material = into.material, f.initial = into.initial, f.dry = into.dry, f.kn = into.kn, f.ks = into.ks;
  f.state.resize(into.state.size());
  f.columns = into.columns;
}

void World::keep_points(const Before& before, const Finding& finding, const Contact& c, uint32_t facets) {
  const Family& old = before.families[c.family];
  Family& f = contacts_.families[c.family];
  WorldFields::of_points(
      [&](const Field& field, const auto& from, auto& to) {
        if (field.of_step || from.empty() || to.empty()) return;
        std::copy_n(from.begin() + finding.first, finding.count, to.begin() + c.first);
      },
      old, f);
  std::copy_n(before.facets.begin() + finding.first_facet, facets, contacts_.facets.begin() + c.first_facet);
  const auto carry = [&](int32_t& index) {
    if (index >= 0) index += int32_t(c.first_facet) - int32_t(finding.first_facet);
  };
  for (uint32_t i = c.first; i < c.first + c.count; ++i) carry(f.point[i].facet_a), carry(f.point[i].facet_b);
}

// New points take the history of the nearest old one of their contact: old points have moved along with their blocks.
void World::hand_over(const Before& before, const Finding& finding, const Contact& c, std::span<const NewPoint> points,
                      bool at_start) {
  Family& f = contacts_.families[c.family];
  const Family& old = before.families[c.family];
  double old_area = 0.0;
  for (uint32_t j = finding.first; j < finding.first + finding.count; ++j) old_area += old.point[j].area;
  const double radius2 =
      finding.count > 0 ? std::max(2.0 * old_area / finding.count, 1e-4 * detection_.size * detection_.size) : 0.0;
  std::vector<Vector> then;  // where the old points are by now
  for (uint32_t j = finding.first; j < finding.first + finding.count; ++j)
    then.push_back(locate(old.point[j], before.facets).at);
  std::vector<Heir> heirs(points.size());
  uint32_t next_facet = c.first_facet;
  const auto put = [&](const Facet& facet) {
    contacts_.facets[next_facet] = facet;
    return int32_t(next_facet++);
  };
  for (size_t k = 0; k < points.size(); ++k) {
    const uint32_t to = c.first + uint32_t(k);
    Point& p = f.point[to];
    p = points[k].point;
    if (p.facet_a >= 0) p.facet_a = put(points[k].facet_a);
    if (p.facet_b >= 0) p.facet_b = put(points[k].facet_b);
    if (!f.old_jump.empty()) f.old_jump[to] = std::nan("");  // no rate, no viscous traction in the first step
    long nearest = -1;
    double best = radius2;
    for (uint32_t j = finding.first; j < finding.first + finding.count; ++j) {
      const Vector d = then[j - finding.first] - p.at;
      if (dot(d, d) < best) best = dot(d, d), nearest = long(j);
    }
    if (nearest >= 0) {
      inherit(old, size_t(nearest), c, f, to);
    } else {
      const bool bonded = at_start && points[k].joint;
      const auto& values = bonded ? f.initial : f.dry;
      for (size_t s = 0; s < f.state.size(); ++s) f.state[s][to] = values[s];
      if (!bonded) p.reference = 0.0;
    }
    // The zero of the jumps. d_n counts from the reference gap. Slip counts from here, less what the last step has
    // moved and the law has not taken yet.
    if (p.facet_a < 0) p.offset += p.reference;
    const Location now = locate(p, contacts_.facets);
    p.at = now.at;
    for (int axis = 0; axis < 2; ++axis) f.slid[axis][to] = now.slid[axis];
    if (nearest >= 0) {
      const Point& q = old.point[nearest];
      const Location moved = locate(q, before.facets);
      heirs[k] = {plastic_closure(old, size_t(nearest)), moved.jump - old.normal_jump[nearest]};
      const Vector pending = in_space(q, (moved.slid[0] - old.slid[0][size_t(nearest)]) * q.s +
                                             (moved.slid[1] - old.slid[1][size_t(nearest)]) * q.t);
      const double sign = q.a == p.a ? 1.0 : -1.0;
      f.slid[0][to] -= sign * dot(pending, in_space(p, p.s)), f.slid[1][to] -= sign * dot(pending, in_space(p, p.t));
    }
  }
  if (!at_start) keep_energy(before, finding, c, heirs);
}

Vector World::in_space(const Point& p, const Vector& v) const {
  if (p.on_gridpoints) return rotation_of_frame(p.a) * v;
  return p.facet_a >= 0 || blocks_[p.a].body < 0 ? v : bodies_[blocks_[p.a].body].r * v;
}

void World::inherit(const Family& old, size_t from, const Contact& c, Family& f, size_t to) const {
  for (size_t s = 0; s < f.state.size(); ++s) f.state[s][to] = old.state[s][from];
  for (size_t k = 0; k < f.columns.size(); ++k) f.columns[k].values[to] = old.columns[k].values[from];
  f.normal_jump[to] = old.normal_jump[from];
  if (!old.stored.empty()) f.stored[to] = old.stored[from];
  const Point& q = old.point[from];
  Point& p = f.point[to];
  const bool open = old.traction[0][from] == 0.0 && old.traction[1][from] == 0.0 && old.traction[2][from] == 0.0;
  p.reference = c.initial || !open ? q.reference : 0.0;  // an open dry contact starts from the true gap
  // Vectors of the joint keep their direction in space: they are turned from the old axes into the new ones. The roles
  // of a and b may have changed with the reference face. Sigma and the traction on the former block a change with it.
  const double sign = q.a == p.a ? 1.0 : -1.0;
  const Vector s = in_space(p, p.s), t = in_space(p, p.t);
  const auto turn = [&](const auto& then_s, const auto& then_t, auto& now_s, auto& now_t) {
    const Vector v = sign * (then_s[from] * in_space(q, q.s) + then_t[from] * in_space(q, q.t));
    std::tie(now_s[to], now_t[to]) = turned_into(s, t, v);
  };
  f.traction[0][to] = old.traction[0][from];
  if (!old.viscous[0].empty() && !f.viscous[0].empty()) f.viscous[0][to] = old.viscous[0][from];
  for (size_t k = 0; k < std::size(f.maxwell) && !old.maxwell[k].empty() && !f.maxwell[k].empty(); k += 3)
    f.maxwell[k][to] = old.maxwell[k][from];
  turn_joint_vectors(old, f, turn);
}

bool World::has_columns(When when) const {
  return when == When::with_stiffness_damping ? viscous_contacts()
         : when == When::with_maxwell         ? has_maxwell()
         : when == When::with_energies        ? energy_
                                              : true;
}

void World::resize(Family& f, size_t n) const {
  for (PropertyColumn& c : f.columns) c.values.assign(n, c.usual);
  WorldFields::of_points(
      [&](const Field& field, auto& column) {
        if (field.known_to_all || (field.when == When::with_energies && !energy_)) return;
        // What damping has is of no use without it, and then gone: a stage may have switched it off.
        column = std::decay_t<decltype(column)>(has_columns(field.when) ? n : 0);
      },
      f);
}

// What a closed point has crushed, or dilated, since it was placed: the law's sigma = kn (d_n + closure), m.
double World::plastic_closure(const Family& f, size_t i) {
  return f.traction[0][i] < 0 ? f.traction[0][i] / f.kn - f.normal_jump[i] : std::max(0.0, -f.normal_jump[i]);
}

// New points hold the elastic energy of those that they replace: the overlap counts from a shifted reference, and shear
// traction is scaled. Fewer of them, or less area, hold it deeper; never deeper than the lost area explains.
void World::keep_energy(const Before& before, const Finding& finding, const Contact& c, std::span<const Heir> heirs) {
  struct Sums {
    double area = 0.0, normal = 0.0, shear = 0.0;  // m2; sums of area * overlap^2 and of area * tau^2
    double deepest = 0.0, largest = 0.0;           // overlap^2, tau^2
    void add(const Family& f, size_t i, double overlap) {
      const double d2 = std::min(0.0, overlap) * std::min(0.0, overlap),
                   tau2 = f.traction[1][i] * f.traction[1][i] + f.traction[2][i] * f.traction[2][i];
      area += f.point[i].area;
      normal += f.point[i].area * d2, shear += f.point[i].area * tau2;
      deepest = std::max(deepest, d2), largest = std::max(largest, tau2);
    }
  };
  Family& f = contacts_.families[c.family];
  const Family& old = before.families[c.family];
  Sums then, now;
  for (uint32_t i = finding.first; i < finding.first + finding.count; ++i)
    then.add(old, i, locate(old.point[i], before.facets).jump + plastic_closure(old, i));
  for (uint32_t k = 0; k < c.count; ++k)
    now.add(f, c.first + k, locate(f.point[c.first + k], contacts_.facets).jump + heirs[k].closure);
  const auto scale = [&](double sum_then, double sum_now, double most_then, double most_now) {
    if (sum_now == 0) return 1.0;
    const double most = std::max(1.0, then.area / now.area) * most_then / most_now;
    return std::sqrt(std::min(sum_then / sum_now, most));
  };
  const double deeper = scale(then.normal, now.normal, then.deepest, now.deepest);
  const double stronger = scale(then.shear, now.shear, then.largest, now.largest);
  for (uint32_t k = 0; k < c.count; ++k) {
    const uint32_t i = c.first + k;
    Point& p = f.point[i];
    const double overlap = locate(p, contacts_.facets).jump + heirs[k].closure;
    if (overlap < 0) {
      p.reference += (1 - deeper) * overlap;
      if (p.facet_a < 0) p.offset += (1 - deeper) * overlap;
    }
    if (std::isnan(heirs[k].opening)) continue;
    const double pressed = f.traction[0][i];
    // As if the point had been there in the last step: stiffness damping sees motion alone.
    f.normal_jump[i] = locate(p, contacts_.facets).jump - heirs[k].opening;
    if (f.traction[0][i] <= 0) f.traction[0][i] = std::min(0.0, f.kn * (f.normal_jump[i] + heirs[k].closure));
    if (!f.old_jump.empty()) f.old_jump[i] = f.normal_jump[i];
    // Shear goes no further than the pressure goes with it: a traction within its strength stays there.
    const double share = std::min(stronger, pressed < 0 ? f.traction[0][i] / pressed : 1.0);
    f.traction[1][i] *= share, f.traction[2][i] *= share;
  }
}

// What these points store at the positions of now, and dissipate on the way there from the last step, J.
double World::energy_of_points(const Family& f, const LaneVector<Facet>& facets, uint32_t first, uint32_t count) const {
  if (!energy_ || count == 0) return 0.0;
  Family trial;
  trial.material = f.material;
  const auto part = [&](const auto& column) {
    return std::decay_t<decltype(column)>(column.begin() + first, column.begin() + first + count);
  };
  trial.point = part(f.point);
  for (const auto& column : f.state) trial.state.push_back(part(column));
  for (const PropertyColumn& c : f.columns) trial.columns.push_back({c.id, c.usual, c.most, part(c.values)});
  for (int k = 0; k < 3; ++k) trial.traction[k] = part(f.traction[k]);
  for (auto* column : {&trial.normal_jump, &trial.slip[0], &trial.slip[1], &trial.stored}) column->resize(count);
  for (auto& column : trial.dissipated) column.resize(count);
  for (uint32_t i = 0; i < count; ++i) {
    const Point& p = trial.point[i];
    const Location now = locate(p, facets);
    trial.normal_jump[i] = now.jump;
    for (int k = 0; k < 2; ++k) trial.slip[k][i] = now.slid[k] - f.slid[k][first + i];
  }
  Chunk all;
  all.count = count;
  bind(trial, all);
  trial.material->evaluate(&all.batch);
  double sum = 0.0;
  for (uint32_t i = 0; i < count; ++i) {
    double density = trial.stored[i];
    for (const auto& d : trial.dissipated) density += d[i];
    sum += density * trial.point[i].area;
  }
  return sum;
}

// A pair that has had no points yet has no family either: by the one that it would have.
RigidPoints World::rigid_points_of(const Contact& c, const Vector& normal, bool at_start) const {
  int family = c.family;
  if (family < 0) family = assembly_.family_of ? assembly_.family_of({c.pair.a, c.pair.b, normal}) : 0;
  if (family < 0 || family >= int(assembly_.families.size())) return RigidPoints::corners;
  const RigidPoints rule = assembly_.families[size_t(family)].rigid_points;
  if (rule != RigidPoints::cubic_at_start) return rule;
  return at_start || c.initial ? RigidPoints::cubic : RigidPoints::corners;
}

void World::make_points(const Contact& c, const Separation& s, bool at_start, std::vector<NewPoint>& out) {
  // Corners are given a nominal area, which keeps them from sinking in. Not those of blocks that touch along an edge
  // since the start, as four units around a joint's end do: their neighbours keep them apart. The nominal area would
  // lock units that slide past each other by a height of some micrometres.
  const double nominal = c.beside_joint ? 0.0 : std::min(blocks_[c.pair.a].corner_area, blocks_[c.pair.b].corner_area);
  const double of_faces = at_start ? 0.0 : nominal;
  const RigidPoints rule = rigid_points_of(c, s.normal, at_start);
  if (s.feature == Separation::edges) {
    if (edge_point(c.pair, s, nominal, out)) return;
    // Edges that keep blocks apart but pass beside each other, as the rims of units that lie on one another do.
    const Placed a = placed(c.pair.a), b = placed(c.pair.b);
    const int face_of_a = facing(a, s.normal), face_of_b = facing(b, -s.normal);
    if (dot(a.normals[face_of_a], s.normal) >= -dot(b.normals[face_of_b], s.normal))
      face_points(c.pair.a, face_of_a, c.pair.b, at_start, of_faces, rule, out);
    else
      face_points(c.pair.b, face_of_b, c.pair.a, at_start, of_faces, rule, out);
  } else if (s.feature == Separation::face_of_a) {
    face_points(c.pair.a, s.index_a, c.pair.b, at_start, of_faces, rule, out);
  } else {
    face_points(c.pair.b, s.index_b, c.pair.a, at_start, of_faces, rule, out);
  }
}

// Points where the face of `carrier` that looks at `owner` overlaps the face `owner_face`, in the plane of that face.
// They have the nominal area (m2) at least.
void World::face_points(int owner, int owner_face, int carrier, bool at_start, double nominal, RigidPoints rule,
                        std::vector<NewPoint>& out) {
  const Placed a = placed(owner), b = placed(carrier);
  const Vector n = a.normals[owner_face];
  const auto& corners = a.shape->faces[owner_face];
  const Vector origin = a.vertices[corners[0]];
  const Vector along = a.vertices[corners[1]] - origin;
  const Vector s = normalized(along - dot(along, n) * n), t = cross(n, s);
  const int facing_face = facing(b, -n);
  const Vector nb = b.normals[facing_face];
  const double cosine = -dot(n, nb),
               tolerance = merge_fraction * std::min(blocks_[owner].least_extent, blocks_[carrier].least_extent);
  const auto flat = [&](const Vector& p) { return Point2{dot(s, p - origin), dot(t, p - origin)}; };

  // The patches: whole faces of rigid blocks, surface triangles of deformable ones.
  struct Patch {
    Polygon polygon;
    Point2 low, high;
  };
  const auto patches = [&](int block, const Placed& p, int face, bool reverse) {
    std::vector<Patch> list;
    const auto add = [&](Polygon polygon) {
      if (reverse) std::reverse(polygon.begin(), polygon.end());
      Point2 low{1e300, 1e300}, high{-1e300, -1e300};
      for (const Point2& q : polygon) {
        low = {std::min(low.x, q.x), std::min(low.y, q.y)}, high = {std::max(high.x, q.x), std::max(high.y, q.y)};
      }
      list.push_back({std::move(polygon), low, high});
    };
    if (blocks_[block].body >= 0) {
      Polygon polygon;
      for (int k : p.shape->faces[face]) polygon.push_back(flat(p.vertices[k]));
      add(polygon);
    } else {
      for (const auto& tri : blocks_[block].surface) {
        if (tri.face == face)
          add({flat(nodes_.x[tri.node[0]]), flat(nodes_.x[tri.node[1]]), flat(nodes_.x[tri.node[2]])});
      }
    }
    return list;
  };
  std::vector<QuadraturePoint> points;
  if (cosine > 0.05) {
    const std::vector<Patch> pa = patches(owner, a, owner_face, false), pb = patches(carrier, b, facing_face, true);
    const bool rigid = blocks_[owner].body >= 0 && blocks_[carrier].body >= 0;
    Polygon overlap_polygon, scratch;
    std::vector<QuadraturePoint> local;
    for (const Patch& p : pa) {
      for (const Patch& q : pb) {
        if (p.high.x < q.low.x || q.high.x < p.low.x || p.high.y < q.low.y || q.high.y < p.low.y) continue;
        clip(q.polygon, p.polygon, tolerance, overlap_polygon, scratch);
        if (overlap_polygon.empty()) continue;
        local.clear();
        if (rigid && assembly_.contact.point_spacing > 0) {
          grid_rule(overlap_polygon, assembly_.contact.point_spacing, local);
        } else if (rigid && rule == RigidPoints::cubic) {
          cubic_rule(overlap_polygon, local);
        } else {
          vertex_rule(overlap_polygon, local);
        }
        // Linear jumps and shape functions agree across patch borders, so coinciding points are one.
        for (const QuadraturePoint& l : local) add_merged(points, 0, l, 10 * tolerance);
      }
    }
  }
  const auto make = [&](const Vector& at, double area, double gap) {
    NewPoint made;
    Point& p = made.point;
    p.a = owner, p.b = carrier;
    p.n = n, p.s = s, p.t = t;
    p.area = area, p.at = at;
    // a joint of the start: the gap found there is the reference
    made.joint = at_start && std::abs(gap) <= detection_.joint_tolerance && cosine > parallel_cosine;
    p.reference = made.joint ? gap : 0.0;
    anchor(made, owner, at - gap * n, owner_face, true);
    anchor(made, carrier, at, facing_face, false);
    choose_frame(made);
    out.push_back(made);
  };
  if (points.empty()) {
    // Faces that do not overlap (a corner beside a steep face): the deepest corner of the carrier, if it lies on this
    // face.
    int deepest = 0;
    for (size_t i = 1; i < b.shape->vertices.size(); ++i) {
      if (dot(n, b.vertices[i]) < dot(n, b.vertices[deepest])) deepest = int(i);
    }
    const double gap = dot(n, b.vertices[deepest] - origin);
    const Point2 at = flat(b.vertices[deepest]);
    bool inside = gap <= 0;
    for (size_t k = 0; k < corners.size() && inside; ++k) {
      const Point2 p = flat(a.vertices[corners[k]]), q = flat(a.vertices[corners[(k + 1) % corners.size()]]);
      inside = (q.x - p.x) * (at.y - p.y) - (q.y - p.y) * (at.x - p.x) >= 0;
    }
    if (inside && nominal > 0 && blocks_[carrier].body >= 0) make(b.vertices[deepest], nominal, gap);
    return;
  }
  // Slivers of overlap would be soft springs; a nominal area keeps corners from sinking in.
  double total = 0.0;
  for (const QuadraturePoint& q : points) total += q.area;
  const double stiffen = std::max(1.0, 0.5 * nominal / total);
  const Vector on_b = b.vertices[b.shape->faces[facing_face][0]];
  for (const QuadraturePoint& q : points) {
    const Vector foot = origin + q.at.x * s + q.at.y * t;
    const double gap = dot(on_b - foot, nb) / dot(n, nb);
    if (!at_start && gap > 20 * detection_.reach) continue;  // far side of a tilted block
    make(foot + gap * n, q.area * stiffen, gap);
  }
}

// Whether edges cross, and the point where they do, unless its area (m2) is nothing.
bool World::edge_point(const Pair& pair, const Separation& separation, double area, std::vector<NewPoint>& out) {
  const Placed a = placed(pair.a), b = placed(pair.b);
  const auto &ea = a.shape->edges[separation.index_a], &eb = b.shape->edges[separation.index_b];
  const Vector u = a.vertices[ea.head] - a.vertices[ea.tail], v = b.vertices[eb.head] - b.vertices[eb.tail];
  const auto crossing = crossing_points(a.vertices[ea.tail], u, b.vertices[eb.tail], v);
  if (!crossing) return false;
  if (area <= 0) return true;
  const auto& [pa, pb] = *crossing;
  NewPoint made;
  Point& p = made.point;
  p.a = pair.a, p.b = pair.b;
  p.n = separation.normal;
  p.s = normalized(u - dot(u, p.n) * p.n), p.t = cross(p.n, p.s);
  p.area = area;
  p.at = pb;
  made.joint = false;
  anchor(made, p.a, pa, ea.left, true);
  anchor(made, p.b, pb, eb.left, false);
  choose_frame(made);
  out.push_back(made);
  return true;
}

// Ties one side of a point to its block: in its body frame, or on the nearest surface triangle of a deformable one.
namespace {

// A point this close to a gridpoint, as part of an edge, sits on it. Far above rounding in the places of points that
// meet gridpoints, far below anything that a mesh can show.
constexpr double kAtGridpoint = 1e-9;

// The gridpoint becomes the first of the triangle, with all of the weight.
void put_on_gridpoint(Facet& facet) {
  for (int k = 0; k < 3; ++k) {
    if (facet.weight[k] < 1.0 - kAtGridpoint) continue;
    std::rotate(facet.node, facet.node + k, facet.node + 3);
    facet.weight[0] = 1.0, facet.weight[1] = facet.weight[2] = 0.0;
    return;
  }
}

}  // namespace

void World::anchor(NewPoint& made, int block, const Vector& at, int face, bool plane_side) {
  Point& p = made.point;
  const ModelBlock& mb = blocks_[block];
  if (mb.body >= 0) {
    const Body& body = bodies_[mb.body];
    if (plane_side) {
      p.n = transposed_times(body.r, p.n), p.s = transposed_times(body.r, p.s), p.t = transposed_times(body.r, p.t);
      p.offset = dot(p.n, transposed_times(body.r, at - body.x));  // of the plane; settle_reference adds the reference
    } else {
      p.arm = transposed_times(body.r, at - body.x);
    }
    return;
  }
  Facet facet{};
  double best = -1e300;
  for (const auto& tri : mb.surface) {
    if (tri.face != face) continue;
    const Vector &x1 = nodes_.x[tri.node[0]], e2 = nodes_.x[tri.node[1]] - x1, e3 = nodes_.x[tri.node[2]] - x1;
    const Vector m = cross(e2, e3);
    const double square = dot(m, m);
    const double w2 = dot(cross(at - x1, e3), m) / square, w3 = dot(cross(e2, at - x1), m) / square, w1 = 1 - w2 - w3;
    const double least = std::min({w1, w2, w3});
    if (least <= best) continue;
    best = least;
    for (int k = 0; k < 3; ++k) facet.node[k] = tri.node[k];
    facet.weight[0] = w1, facet.weight[1] = w2, facet.weight[2] = w3;
  }
  if (plane_side) {
    p.facet_a = 0;  // numbered when the point is stored
    made.facet_a = facet;
  } else {
    put_on_gridpoint(facet);
    p.facet_b = 0;
    made.facet_b = facet;
  }
}

// The frame of a point whose plane belongs to a deformable block. That of the block where both sides are gridpoints,
// else that of the triangle, which edge contacts keep too.
void World::choose_frame(NewPoint& made) const {
  Point& p = made.point;
  if (p.facet_a < 0) return;
  Facet on_a = made.facet_a;
  put_on_gridpoint(on_a);
  p.on_gridpoints = p.facet_b >= 0 && may_have_frame(p.a) && sits_on_gridpoint(on_a) && sits_on_gridpoint(made.facet_b);
  if (!p.on_gridpoints) return refresh_facet_frame(p, made.facet_a);
  made.facet_a = on_a;
  const Matrix r = rotation_of_frame(p.a);
  p.n = transposed_times(r, p.n), p.s = transposed_times(r, p.s), p.t = transposed_times(r, p.t);
}

// The frame of a deformable plane side: n of its triangle, s along its first edge.
void World::refresh_facet_frame(Point& p, Facet& facet) const {
  const Vector &x1 = nodes_.x[facet.node[0]], e2 = nodes_.x[facet.node[1]] - x1, e3 = nodes_.x[facet.node[2]] - x1;
  const double length = norm(e2);
  p.s = e2 / length;
  p.n = normalized(cross(e2, e3));
  p.t = cross(p.n, p.s);
  const double x3 = dot(p.s, e3), y3 = dot(p.t, e3);
  facet.gradient[1][0] = 1 / length, facet.gradient[1][1] = -x3 / (length * y3);
  facet.gradient[2][0] = 0, facet.gradient[2][1] = 1 / y3;
  for (int k = 0; k < 2; ++k) facet.gradient[0][k] = -facet.gradient[1][k] - facet.gradient[2][k];
}

void World::take_back_facets() {
  for (const int c : chunks_.own) {
    const Chunk& chunk = chunks_.all[size_t(c)];
    Family& f = contacts_.families[size_t(chunk.family)];
    for (const FacetLanes& lanes : chunk.facets) {
      for (size_t l = 0; l < lanes.count; ++l) {
        Facet& facet = contacts_.facets[size_t(lanes.facet_a[l])];
        for (int k = 0; k < 3; ++k) facet.weight[k] = lanes.weight_a[k][l];
        if (!small_) refresh_facet_frame(f.point[lanes.first + l], facet);
      }
    }
  }
}

// Where the point is now: place in space, gap from the plane less the reference, position along s and t in a's frame.
World::Location World::locate(const Point& p, const LaneVector<Facet>& facets) const {
  Location l;
  if (p.facet_b >= 0) {
    const Facet& facet = facets[p.facet_b];
    l.at = facet.weight[0] * nodes_.x[facet.node[0]] + facet.weight[1] * nodes_.x[facet.node[1]] +
           facet.weight[2] * nodes_.x[facet.node[2]];
  } else {
    const Body& b = bodies_[blocks_[p.b].body];
    l.at = b.x + b.r * p.arm;
  }
  if (p.facet_a >= 0) {
    const Facet& facet = facets[p.facet_a];
    Vector d = l.at - (facet.weight[0] * nodes_.x[facet.node[0]] + facet.weight[1] * nodes_.x[facet.node[1]] +
                       facet.weight[2] * nodes_.x[facet.node[2]]);
    if (p.on_gridpoints) d = transposed_times(rotation_of_frame(p.a), d);
    l.jump = dot(p.n, d) - p.reference;
    l.slid[0] = dot(p.s, d), l.slid[1] = dot(p.t, d);
  } else {
    const Body& a = bodies_[blocks_[p.a].body];
    const Vector j = transposed_times(a.r, l.at - a.x);
    l.jump = dot(p.n, j) - p.offset;
    l.slid[0] = dot(p.s, j), l.slid[1] = dot(p.t, j);
  }
  return l;
}

}  // namespace quoin::blocks
