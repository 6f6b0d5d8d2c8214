// Contact detection: pairs of close blocks, their contact points, and the history that a new contact point inherits.
#include "model/detection.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "base/error.h"
#include "model/block_layout.h"
#include "model/contact_frames.h"
#include "model/contact_lists.h"
#include "model/inherited_points.h"
#include "model/new_points.h"
#include "model/placed_blocks.h"
#include "model/world.h"
#include "model/world_parts.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

// The reference face of before is kept among features that agree within this fraction of the smallest block.
constexpr double preference_fraction = 1e-4;
// Limits of the growth of the local stiffness bound up to which 2/omega_max is not computed again. Between them the
// margin of the step fraction decides. The step then exceeds its fraction of the critical step by the root of this
// growth at most.
constexpr double kLeastGrowth = 1.01, kMostGrowth = 1.1;

constexpr size_t kPairsAPart = 256;  // of the work of one thread at a time

struct Detection {
  bool at_start;
  std::vector<Contact> contacts;  // in the order of the pairs
  std::vector<Finding> findings;  // by contact
  std::vector<NewPoint> points;
  std::vector<Contact> lost;  // contacts with points whose pair is now beyond the skin
  bool changed = false;       // whether points of any contact have changed
};

// Pairs beyond the skin whose joints are pulled stay, as the law alone ends a joint.
void keep_pulled_pairs(const World& w, std::vector<Pair>& pairs) {
  std::vector<Pair> beyond;
  std::vector<uint8_t> pulled;
  for (const Contact& c : w.contacts.list) {
    if (c.count == 0 || std::ranges::binary_search(pairs, c.pair)) continue;
    beyond.push_back(c.pair), pulled.push_back(w.part.owns(c.pair) && pulled_opening(w, c));
  }
  all_gather(w.part.ranks, std::span(pulled), [&](size_t i) { return w.part.rank_of(beyond[i]); });
  const size_t within = pairs.size();
  for (size_t i = 0; i < beyond.size(); ++i) {
    if (pulled[i]) pairs.push_back(beyond[i]);
  }
  std::inplace_merge(pairs.begin(), pairs.begin() + long(within), pairs.end());
}

// Broad phase: all pairs within the skin. They are found again when a block has used most of its share.
std::vector<Pair> close_pairs(World& w, bool everything) {
  bool stale = everything;
  for (size_t i = 0; i < w.blocks.size() && !stale; ++i)
    stale = w.part.owns(int(i)) &&
            motion_since_broad_phase(w, int(i), pose(w, int(i))) > kMostlyUsed * kOfSkin * w.detection.skin;
  std::vector<Pair> pairs;
  if (!w.part.any(stale)) {
    for (const Contact& c : w.contacts.list) pairs.push_back(c.pair);
    return pairs;
  }
  std::vector<Box> boxes(w.blocks.size());
  const Vector inflate{0.5 * w.detection.skin, 0.5 * w.detection.skin, 0.5 * w.detection.skin};
  for (size_t i = 0; i < w.blocks.size(); ++i) {
    if (!w.part.laid_out[i]) continue;
    const ModelBlock& b = w.blocks[i];
    for (size_t k = 0; k < b.shape->vertices.size(); ++k) boxes[i].include(w.shapes.placed_corner[b.first_corner + k]);
    boxes[i].lower -= inflate, boxes[i].upper += inflate;
    w.poses.broad[i] = pose(w, int(i));
  }
  w.part.gather_by_block(boxes);
  for (size_t i = 0; i < w.blocks.size(); ++i) w.part.rough_place[i] = 0.5 * (boxes[i].lower + boxes[i].upper);
  pairs = overlapping_pairs(boxes);
  keep_pulled_pairs(w, pairs);
  const auto held = [&](int i) {  // fixed blocks that stages drive are laid out on all ranks
    return w.blocks[i].body >= 0 && w.assembly.blocks[i].is_support() &&
           (!w.part.laid_out[size_t(i)] || w.bodies[w.blocks[i].body].held == 0x3f);
  };
  std::erase_if(pairs, [&](const Pair& p) { return held(p.a) && held(p.b); });
  receive_new_neighbours(w, pairs);
  return pairs;
}

bool carries(const World& w, const Contact& c) {
  for (uint32_t i = c.first; i < c.first + c.count; ++i) {
    for (const auto& traction : w.contacts.families[c.family].traction) {
      if (traction[i] != 0.0) return true;
    }
  }
  return false;
}

void name_family(const World& w, Contact& c, const Vector& normal, std::span<const NewPoint> points) {
  c.family = family_of(w, c, normal);
  if (c.family < int(w.contacts.families.size())) return;
  Vector middle;
  for (const NewPoint& p : points) middle += p.point.at / double(points.size());
  throw Error(Exit::bad_input, fmt::format("blocks {} and {} meet near {}, and no joint family is given for them",
                                           label(w.assembly, c.pair.a), label(w.assembly, c.pair.b), place(middle)));
}

// Narrow phase of one pair: separation of its blocks, and new contact points.
void detect_pair(const World& w, Contact& c, PairPlace& place, Finding& finding, bool at_start,
                 std::vector<NewPoint>& points) {
  finding.examined = true;
  const Pair pair = c.pair;
  const Placed a = placed(w, pair.a), b = placed(w, pair.b);
  place.separation = separate(a, b, w.detection.skin, preference_fraction * w.detection.size,
                              finding.known ? &place.separation : nullptr);
  const double distance = place.separation.distance;
  const Pose of_a = pose(w, pair.a), of_b = pose(w, pair.b);
  place.relative_x = transposed_times(of_a.r, of_b.x - of_a.x);
  place.relative_r = transposed(of_a.r) * of_b.r;
  if (at_start && distance < -w.detection.joint_tolerance) {
    throw Error(
        Exit::bad_input,
        fmt::format(
            "blocks {} and {} overlap by {:.3g} m near {} (more than the joint tolerance {:.3g} m); move or cut one "
            "of them",
            label(w.assembly, pair.a), label(w.assembly, pair.b), -distance,
            geometry::place(0.5 * (a.centre + b.centre)), w.detection.joint_tolerance));
  }
  finding.begin = points.size();
  if (distance <= w.detection.reach) {
    make_points(w, c, place.separation, at_start, points);
    finding.fresh = true;
    if (at_start && points.size() == finding.begin && distance <= w.detection.joint_tolerance) c.beside_joint = 1;
  } else {
    // Beyond reach the points are removed, unless one carries traction: a joint that stretches further than the skin.
    c.beside_joint = 0;
    finding.fresh = !carries(w, c);
  }
  const auto fresh = std::span(points).subspan(finding.begin);
  if (!fresh.empty() && c.family < 0) name_family(w, c, place.separation.normal, fresh);
  finding.fresh_count = c.family < 0 ? 0 : uint32_t(fresh.size());  // 0: declared to pass through each other
}

// Contacts of the current pairs, with the data of the same pairs before; contacts of other pairs are lost.
void keep_contacts(World& w, const std::vector<Pair>& pairs, Detection& found) {
  const std::vector<Contact>& old = w.contacts.list;
  std::vector<KeptItems> kept;
  size_t then = 0;
  const auto lose = [&] {
    if (old[then].count > 0) found.lost.push_back(old[then]);
    ++then;
  };
  found.contacts.reserve(pairs.size()), found.findings.reserve(pairs.size());
  for (const Pair& pair : pairs) {
    while (then < old.size() && old[then].pair < pair) lose();
    Contact c;
    c.pair = pair;
    Finding finding;
    finding.known = then < old.size() && old[then].pair == pair;
    if (finding.known) {
      if (w.part.owns(pair)) keep_on(kept, uint32_t(then), uint32_t(found.contacts.size()), 1);
      c = old[then++];
    }
    if (c.count > 0) finding.first = c.first, finding.count = c.count, finding.first_facet = c.first_facet;
    found.contacts.push_back(c), found.findings.push_back(finding);
  }
  while (then < old.size()) lose();
  keep_pairs(w, kept, pairs.size());
}

// Narrow phase of own pairs that are new or have moved enough; others keep their points.
void narrow_phase(World& w, bool everything, Detection& found) {
  std::vector<std::vector<NewPoint>> points((found.contacts.size() + kPairsAPart - 1) / kPairsAPart);
  each_part(w.pool, found.contacts.size(), kPairsAPart, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      Contact& c = found.contacts[i];
      Finding& finding = found.findings[i];
      PairCheck& check = w.checks.pair[i];
      if (!w.part.owns(c.pair) || (finding.known && !everything && !check.mostly_used)) continue;
      PairPlace& place = w.contacts.place[i];
      detect_pair(w, c, place, finding, found.at_start, points[begin / kPairsAPart]);
      check_pair_motion(w, c, place, checked_motion(w, c.pair.a), checked_motion(w, c.pair.b), check);
    }
  });
  for (size_t part = 0; part < points.size(); ++part) {
    const size_t begin = part * kPairsAPart, end = std::min(begin + kPairsAPart, found.findings.size());
    for (size_t i = begin; i < end; ++i) found.findings[i].begin += found.points.size();
    found.points.insert(found.points.end(), points[part].begin(), points[part].end());
    points[part] = {};
  }
}

// Exchanges the family and number of points of each pair, so that points have the numbers of a single process.
void exchange_findings(World& w, Detection& found) {
  struct Exchanged {
    int32_t family;
    uint32_t fresh_count;
    bool examined, fresh;
    uint16_t beside_joint;
  };
  std::vector<Exchanged> exchanged;
  for (size_t i = 0; w.part.ranks && i < found.contacts.size(); ++i) {
    const Finding& f = found.findings[i];
    exchanged.push_back({found.contacts[i].family, f.fresh_count, f.examined, f.fresh, found.contacts[i].beside_joint});
  }
  all_gather(w.part.ranks, std::span(exchanged), [&](size_t i) { return w.part.rank_of(found.contacts[i].pair); });
  for (size_t i = 0; i < exchanged.size(); ++i) {
    Contact& c = found.contacts[i];
    Finding& f = found.findings[i];
    c.family = exchanged[i].family, c.beside_joint = exchanged[i].beside_joint;
    f.fresh_count = exchanged[i].fresh_count, f.examined = exchanged[i].examined, f.fresh = exchanged[i].fresh;
  }
  found.changed = !found.lost.empty();
  for (const Finding& f : found.findings) {
    w.detection.narrow_calls += f.examined ? 1 : 0;
    found.changed |= f.fresh && (f.fresh_count > 0 || f.count > 0);
  }
}

// Numbers all points in the order of the pairs, and facets in the order of points. Returns copies of the points that
// are replaced or lost.
PointsBefore number_points(World& w, Detection& found) {
  std::vector<CopiedContact> aside;
  std::vector<uint32_t> points(w.contacts.families.size(), 0), facets(w.contacts.families.size(), 0);
  uint32_t facets_aside = 0;
  const auto put_aside = [&](const Contact& c, uint32_t& first, uint32_t first_facet, uint32_t count) {
    if (count == 0 || !w.part.owns(c.pair)) return;
    const uint32_t of_contact = count * uint32_t(facets_a_point(w, c)), to = points[size_t(c.family)];
    aside.push_back({c.family, {first, to, count}, {first_facet, facets_aside, of_contact}});
    first = to, points[size_t(c.family)] += count, facets_aside += of_contact;
  };
  for (size_t i = 0; i < found.contacts.size(); ++i) {
    Finding& finding = found.findings[i];
    if (finding.fresh) put_aside(found.contacts[i], finding.first, finding.first_facet, finding.count);
  }
  for (Contact& c : found.lost) put_aside(c, c.first, c.first_facet, c.count);
  PointsBefore before = set_aside(w, aside);
  points.assign(points.size(), 0);
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
    facets[size_t(c.family)] += c.count * uint32_t(facets_a_point(w, c));
  });
  for (Contact& c : found.contacts) {
    if (c.family < 0) c.count = 0;
  }
  uint32_t all_facets = 0;
  for (uint32_t& of_family : facets) all_facets += std::exchange(of_family, all_facets);
  std::vector<std::vector<KeptItems>> kept(w.contacts.families.size()), kept_facets(w.contacts.families.size());
  each_contact([&](Contact& c, const Finding& finding) {
    const size_t family = size_t(c.family);
    const uint32_t of_contact = c.count * uint32_t(facets_a_point(w, c));
    c.first_facet = facets[family];
    facets[family] += of_contact;
    if (finding.fresh || c.count == 0 || !w.part.owns(c.pair)) return;
    keep_on(kept[family], finding.first, c.first, c.count);
    keep_on(kept_facets[family], finding.first_facet, c.first_facet, of_contact);
  });
  each_part(w.pool, found.contacts.size(), kPairsAPart, [&](size_t begin, size_t end) {
    for (size_t k = begin; k < end; ++k) {
      const Contact& c = found.contacts[k];
      const Finding& finding = found.findings[k];
      if (c.family < 0 || finding.fresh || c.first_facet == finding.first_facet || !w.part.owns(c.pair)) continue;
      for (uint32_t i = finding.first; i < finding.first + c.count; ++i)
        move_facets(w.contacts.families[size_t(c.family)].point[i], c.first_facet, finding.first_facet);
    }
  });
  for (size_t k = 0; k < kept.size(); ++k) keep_points(w, w.contacts.families[k], kept[k], points[k]);
  std::vector<KeptItems> all_kept;
  for (const auto& of_family : kept_facets) all_kept.insert(all_kept.end(), of_family.begin(), of_family.end());
  keep_facets(w, all_kept, all_facets);
  return before;
}

// Books the elastic energies of points that are removed (> 0) or placed (< 0), in a fixed order. The law is called for
// the points in `before`, so they are not those of before any more.
void book_energies(World& w, PointsBefore& before, const Detection& found) {
  if (!w.books_energy) return;
  std::vector<std::vector<KeptItems>> fresh(w.contacts.families.size());
  std::vector<uint32_t> count(w.contacts.families.size(), 0), first_fresh(found.contacts.size(), 0);
  for (size_t i = 0; i < found.contacts.size(); ++i) {
    const Contact& c = found.contacts[i];
    if (c.count == 0 || !found.findings[i].fresh || !w.part.owns(c.pair)) continue;
    first_fresh[i] = count[size_t(c.family)];
    fresh[size_t(c.family)].push_back({c.first, first_fresh[i], c.count});
    count[size_t(c.family)] += c.count;
  }
  std::vector<std::vector<double>> removed, placed;
  for (size_t k = 0; k < fresh.size(); ++k) {
    removed.push_back(energies_of_points(w, before.families[k], before.location[k]));
    Family copies = copied_points(w.contacts.families[k], fresh[k]);
    placed.push_back(energies_of_points(w, copies, locations_of(w, copies, w.contacts.facets)));
  }
  std::vector<double> freed;  // J
  std::vector<Pair> freed_by;
  const auto book = [&](const Contact& c, const auto& energies, uint32_t first, uint32_t items, double sign) {
    const uint32_t end = w.part.owns(c.pair) ? first + items : first;
    double sum = 0.0;
    for (uint32_t i = first; i < end; ++i) sum += energies[size_t(c.family)][i];
    freed.push_back(sign * sum), freed_by.push_back(c.pair);
  };
  for (const Contact& c : found.lost) book(c, removed, c.first, c.count, 1.0);
  for (size_t i = 0; i < found.contacts.size(); ++i) {
    const Contact& c = found.contacts[i];
    const Finding& finding = found.findings[i];
    if (c.family < 0 || !finding.fresh) continue;
    book(c, removed, finding.first, finding.count, 1.0);
    book(c, placed, first_fresh[i], c.count, -1.0);
  }
  all_gather(w.part.ranks, std::span(freed), [&](size_t i) { return w.part.rank_of(freed_by[i]); });
  w.step_sums.later.detection += std::accumulate(freed.begin(), freed.end(), 0.0);
}

// Keeps or makes contact points. New points inherit the history of points nearby. With ranks: points of pairs with an
// own block.
void place_points(World& w, Detection& found) {
  PointsBefore before = number_points(w, found);
  if (!found.at_start && w.start_joints.kept.empty())
    w.start_joints.kept = LaneVector<double>(w.start_joints.point.size() * kept_width(w));
  const auto keep_of = [&](const Contact& c, uint32_t first, uint32_t count) {
    if (found.at_start || !c.initial || count == 0 || !w.part.owns(c.pair.a)) return;
    keep_of_joint(w, c, before.families[size_t(c.family)],
                  std::span(before.location[size_t(c.family)]).subspan(first, count), first);
  };
  each_part(w.pool, found.lost.size(), kPairsAPart, [&](size_t begin, size_t end) {
    for (const Contact& c : std::span(found.lost).subspan(begin, end - begin)) keep_of(c, c.first, c.count);
  });
  each_part(w.pool, found.contacts.size(), kPairsAPart, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const Contact& c = found.contacts[i];
      const Finding& finding = found.findings[i];
      if (c.family < 0 || !finding.fresh || !w.part.owns(c.pair)) continue;
      keep_of(c, finding.first, finding.count);
      hand_over(w, before, finding, c, std::span(found.points).subspan(finding.begin, c.count), found.at_start);
      // At the start set_solver follows, with all joints at hand.
      if (c.count > 0 && !found.at_start) w.contacts.place[i].viscosity = viscosity_of_pair(w, c);
    }
  });
  book_energies(w, before, found);
  w.contacts.list = std::move(found.contacts);
  if (found.at_start) note_start_joints(w);
  divide_work(w);
  if (found.at_start) return;
  std::vector<bool> has_changed(w.blocks.size());
  for (size_t i = 0; i < w.contacts.list.size(); ++i) {
    const Pair& pair = w.contacts.list[i].pair;
    if (found.findings[i].fresh) has_changed[size_t(pair.a)] = has_changed[size_t(pair.b)] = true;
  }
  const double bound = local_stiffness_bound(w, [&](int block) { return has_changed[size_t(block)]; });
  // Stiffness may grow within the margin of the time step fraction, as the frequency costs as much as many steps.
  const double fraction = w.solver.time_step_fraction;
  const double growth = std::clamp(1.0 / (fraction * fraction), kLeastGrowth, kMostGrowth);
  if (bound <= growth * w.stepping.stiffness_bound) {
    // Stiff contacts that are gone give back the impact damping that they took.
    const bool is_reduced = w.damping.impacts && w.impacts.share < 1.0;
    if (is_reduced && growth * local_stiffness_bound(w, [](int) { return true; }) < w.stepping.stiffness_bound)
      find_time_step(w);
    return;
  }
  std::set<int> changed;
  for (int block = 0; block < w.block_count(); ++block) {
    if (has_changed[size_t(block)] && w.part.owns(block)) changed.insert(w.units.of(block).block[0]);
  }
  if (w.part.any(shorten_step(w, std::vector<int>(changed.begin(), changed.end()))))
    find_time_step(w);
  else
    w.stepping.stiffness_bound = bound;
}

}  // namespace

void detect_contacts(World& w, bool everything) {
  Detection found;
  found.at_start = w.detection.count++ == 0;
  take_back_facets(w);
  place_blocks(w);
  const std::vector<Pair> pairs = close_pairs(w, everything);
  keep_contacts(w, pairs, found);
  std::optional<Error> fault;
  try {
    narrow_phase(w, everything, found);
  } catch (const Error& error) {
    fault = error;
  }
  w.part.fail_together(fault);
  exchange_findings(w, found);
  if (found.changed || found.at_start) {
    place_points(w, found);
  } else {
    w.contacts.list = std::move(found.contacts);
    list_contacts_by_family(w);
  }
  for (size_t i = 0; i < w.contacts.list.size(); ++i) {
    if (w.part.owns(w.contacts.list[i].pair)) w.checks.next = std::min(w.checks.next, w.checks.pair[i].step);
  }
  w.checks.next = -long(w.part.largest(double(-w.checks.next)));
  bind_neighbours(w);
}

}  // namespace quoin::blocks
