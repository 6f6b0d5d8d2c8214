#include "step/existing_damage.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <span>

#include "base/error.h"
#include "geometry/vector.h"
#include "law/at_rest.h"
#include "law/bound_call.h"
#include "model/contact_frames.h"
#include "model/point_finder.h"
#include "model/property_columns.h"
#include "model/world_results.h"
#include "step/law_swap.h"
#include "step/rank_agreement.h"
#include "step/work_division.h"

namespace quoin {

namespace {

// Data of a block that decide whether a crack runs along its joints.
struct CrackedBlock {
  Vec3 centre;  // position at the start, m
  int unit;     // index of the masonry unit; -1: none
};

// Contact points of one joint family after damage.
struct DamagedFamily {
  std::vector<double> state;          // one column a state of the law, column after column, of all points
  std::vector<double> opening_shift;  // by point, m: added to the opening that the law receives
  std::size_t points = 0;             // number of damaged points
};

using Flat = std::array<double, 2>;  // m, along the wall and up

double side(const Flat& a, const Flat& b, const Flat& p) {
  return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
}

// Whether the segment from p to q crosses the segment from a to b; false where it runs along it.
bool crosses(const Flat& p, const Flat& q, const Flat& a, const Flat& b) {
  const double from = side(a, b, p), to = side(a, b, q);
  return (from != 0.0 || to != 0.0) && from * to <= 0.0 && side(p, q, a) * side(p, q, b) <= 0.0;
}

// The joints that a crack follows.
class Crack {
 public:
  Crack(const Damage& damage, std::span<const CrackedBlock> blocks) : damage_(damage), blocks_(blocks) {
    for (const CrackedBlock& b : blocks) {
      if (b.unit < 0) continue;
      auto& [sum, count] = units_[b.unit];
      for (std::size_t k = 0; k < 3; ++k) sum[k] += b.centre[k];
      ++count;
    }
  }

  // joint: the middle of the common face of both blocks.
  bool follows(int block_a, int block_b, const Vec3& joint) const {
    const CrackedBlock &a = at(block_a), &b = at(block_b);
    if (!damage_.through_units && a.unit >= 0 && a.unit == b.unit) return false;
    const Flat middle = flat(joint);
    return cuts(end(a, b, joint), middle) || cuts(middle, end(b, a, joint));
  }

 private:
  const CrackedBlock& at(int block) const { return blocks_[static_cast<std::size_t>(block)]; }
  Flat flat(const Vec3& x) const { return {x[static_cast<std::size_t>(damage_.crack_along)], x[1]}; }

  Flat centre(const CrackedBlock& b) const {
    if (damage_.through_units || b.unit < 0) return flat(b.centre);
    const auto& [sum, count] = units_.at(b.unit);
    return flat({sum[0] / count, sum[1] / count, sum[2] / count});
  }
  // End of the segment from b to the joint. Blocks beside the masonry, such as beams, may be long: their centre is the
  // neighbour's, mirrored at the joint. The segment begins beside the centre, so a crack through the centre does not
  // cross it.
  Flat end(const CrackedBlock& b, const CrackedBlock& neighbour, const Vec3& joint) const {
    const Flat middle = flat(joint);
    Flat x = centre(b);
    if (b.unit < 0 && neighbour.unit >= 0) {
      const Flat other = centre(neighbour);
      x = {2.0 * middle[0] - other[0], 2.0 * middle[1] - other[1]};
    }
    constexpr double kBeside = 1e-6;
    return {x[0] + kBeside * (middle[0] - x[0]), x[1] + kBeside * (middle[1] - x[1])};
  }
  bool cuts(const Flat& p, const Flat& q) const {
    for (std::size_t k = 1; k < damage_.crack.size(); ++k)
      if (crosses(p, q, damage_.crack[k - 1], damage_.crack[k])) return true;
    return false;
  }

  const Damage& damage_;
  std::span<const CrackedBlock> blocks_;
  std::map<int, std::pair<Vec3, double>> units_;  // sum of the centres of their blocks, m; number of these
};

std::vector<std::size_t> points_of(const Damage& damage, std::span<const PlacedPoint> points,
                                   std::span<const PlacedPoint> of_joints, std::span<const CrackedBlock> blocks) {
  std::map<std::pair<int, int>, std::pair<Vec3, double>> joints;  // sum of area times position, m3; of area, m2
  for (const PlacedPoint& p : of_joints) {
    auto& [sum, area] = joints[{p.block_a, p.block_b}];
    for (std::size_t k = 0; k < 3; ++k) sum[k] += p.area * p.position[k];
    area += p.area;
  }
  std::map<std::pair<int, int>, bool> cracked;
  const Crack crack(damage, blocks);
  for (const auto& [pair, place] : joints) {
    const auto& [sum, area] = place;
    cracked[pair] =
        damage.crack.empty() || crack.follows(pair.first, pair.second, {sum[0] / area, sum[1] / area, sum[2] / area});
  }
  constexpr double kRounding = 1e-9;  // m: gridpoints on a face of the box are inside
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < points.size(); ++i) {
    bool inside = cracked[{points[i].block_a, points[i].block_b}];
    for (std::size_t k = 0; k < 3; ++k)
      inside = inside && points[i].position[k] >= damage.from[k] - kRounding &&
               points[i].position[k] <= damage.to[k] + kRounding;
    if (inside) found.push_back(i);
  }
  return found;
}

std::string ids_of(const quoin_law& law) {
  std::vector<std::string> ids;
  for (std::uint64_t k = 0; k < law.state_count; ++k) ids.emplace_back(law.states[k]->id);
  return ids.empty() ? "none" : fmt::format("{}", fmt::join(ids, ", "));
}

void set_state(const Damage& damage, const JointFamily& family, const quoin_law& law, std::size_t k, double value,
               std::span<const std::size_t> points, std::size_t count, std::vector<double>& state) {
  const quoin_state_info& info = *law.states[k];
  if (!(value >= info.lower && value <= info.upper))
    throw Error(Exit::bad_input,
                fmt::format("{}: {} = {:g} {} of joint family '{}'; law {} allows {:g} to {:g}", damage.source.text,
                            info.id, value, info.unit, family.name, law.id, info.lower, info.upper));
  for (const std::size_t i : points) state[k * count + i] = value;
}

void set_states(const Damage& damage, const JointFamily& family, const Material& material,
                std::span<const std::size_t> points, std::size_t count, std::vector<double>& state) {
  const quoin_law& law = material.api();
  if (damage.xi) {
    bool known = false;
    for (std::uint64_t k = 0; k < law.state_count; ++k) {
      const std::string id = law.states[k]->id;
      if (id != "xi" && !id.starts_with("xi_")) continue;
      known = true;
      set_state(damage, family, law, k, *damage.xi, points, count, state);
    }
    if (!known)
      throw Error(Exit::bad_input, fmt::format("{}: xi: law {} of joint family '{}' has no softening variable xi; its "
                                               "states: {}; give initial_state or state instead",
                                               damage.source.text, law.id, family.name, ids_of(law)));
  }
  for (const auto& [id, value] : damage.state) {
    const int k = material.law().state_index(id);
    if (k < 0)
      throw Error(Exit::bad_input,
                  fmt::format("{}: state.{}: law {} of joint family '{}' has no such state; it has: {}",
                              damage.source.text, id, law.id, family.name, ids_of(law)));
    set_state(damage, family, law, static_cast<std::size_t>(k), value, points, count, state);
  }
}

// Direction in which a joint slides, along s and t. In beds the upper block moves along the wall, in upright joints the
// one of larger coordinates up. So it does not depend on which block is a.
std::array<double, 2> way_of_slip(const PlacedPoint& p, int along) {
  const geometry::Vector n = geometry::vector(p.axis[0]);
  constexpr double kUpright = 0.7;  // cosine of the normal with the vertical below which a joint is upright
  const bool is_bed = std::abs(n.y) >= kUpright;
  geometry::Vector way;
  way[is_bed ? along : 1] = 1.0;
  way = normalized(way - dot(way, n) * n);
  constexpr double kAcross = 1e-9;  // component of a normal that is 0 but for rounding
  const double side = is_bed ? n.y : std::abs(n[along]) > kAcross ? n[along] : n[2 - along];
  if (side < 0.0) way = -way;
  return {dot(way, geometry::vector(p.axis[1])), dot(way, geometry::vector(p.axis[2]))};
}

// States of a law after this slip at zero pressure, in small steps as in an analysis. Where faces ride up, the opening
// follows the pressure that this causes.
void slide(const Damage& damage, const JointFamily& family, const Material& material,
           std::span<const PlacedPoint> points, std::span<const std::size_t> found,
           const std::vector<PropertyColumn>& columns, std::vector<double>& state) {
  constexpr int kSteps = 1000;
  constexpr double kFollows = 0.9;  // share of the closure that is opened; below 1, so that contact is not lost
  const std::size_t states = material.api().state_count;
  const double stiffness = stiffness_bounds_of(family, material, columns).normal;
  const std::size_t count = points.size();
  std::vector<double> opening(count, 0.0), part_s(count), part_t(count), traction(3 * count, 0.0), now = state;
  for (const std::size_t i : found) {
    const auto [s, t] = way_of_slip(points[i], damage.crack_along);
    part_s[i] = s * damage.slip / kSteps, part_t[i] = t * damage.slip / kSteps;
  }
  CallColumns columns_of_call{count, {}, {}, batch_columns(columns, material, 0)};
  for (std::size_t k = 0; k < 3; ++k) columns_of_call.traction[k] = traction.data() + k * count;
  for (std::size_t k = 0; k < states; ++k) columns_of_call.state.push_back(now.data() + k * count);
  BoundCall call;
  call.bind(std::move(columns_of_call));
  call.bind_jumps(opening.data(), part_s.data(), part_t.data());
  for (int step = 0; step < kSteps; ++step) {
    const bool failed = call.evaluate(material);
    material.require_no_fault(Exit::law_refused);
    if (failed)
      throw Error(Exit::law_refused, fmt::format("{}: law {} fails where this damage lets it slide by {:g} m",
                                                 damage.source.text, material.api().id, damage.slip));
    for (std::size_t i = 0; i < count; ++i) opening[i] += kFollows * std::max(0.0, -traction[i]) / stiffness;
  }
  for (std::size_t k = 0; k < states; ++k) {
    for (const std::size_t i : found) state[k * count + i] = now[k * count + i];
  }
}

// Computes states and opening shifts at which the law has no traction, for damaged points alone.
void unload_points(const JointFamily& family, const std::shared_ptr<const Material>& material,
                   std::span<const PlacedPoint> points, std::span<const std::size_t> damaged,
                   const std::vector<double>& opening, DamagedFamily& result) {
  const std::size_t n = damaged.size(), states = material->api().state_count;
  std::vector<double> zero(n, 0.0), gap, area, state;
  for (const std::size_t i : damaged) gap.push_back(opening[i]), area.push_back(points[i].area);
  for (std::size_t k = 0; k < states; ++k) {
    for (const std::size_t i : damaged) state.push_back(result.state[k * points.size() + i]);
  }
  FamilyColumns at_rest;
  at_rest.count = n;
  at_rest.normal_jump = gap.data(), at_rest.area = area.data();
  at_rest.traction = {zero.data(), zero.data(), zero.data()};
  for (std::size_t k = 0; k < states; ++k) at_rest.state.push_back(state.data() + k * n);
  const MigratedFamily rest = migrate(family, *material, *material, at_rest);
  for (std::size_t j = 0; j < n; ++j) {
    for (std::size_t k = 0; k < states; ++k) result.state[k * points.size() + damaged[j]] = rest.state[k * n + j];
    result.opening_shift[damaged[j]] = gap[j] + rest.opening_shift[j];
  }
}

// States of damaged points of a family, without traction and at no opening. `points`: all contact points of the family,
// or some. `of_joints`: all points of the joints of these, which give the places of whole joints to cracks. `hit`
// counts the points of each entry of `damage`. Throws Error(bad_input), with the place in the scene: the law has no
// such state, does not allow the value, or refuses it without traction.
DamagedFamily damage_family(const std::vector<Damage>& damage, const JointFamily& family,
                            const std::shared_ptr<const Material>& material, std::span<const PlacedPoint> points,
                            std::span<const PlacedPoint> of_joints, std::span<const CrackedBlock> blocks,
                            const std::vector<PropertyColumn>& columns, std::vector<double>* hit) {
  const quoin_law& law = material->api();
  const std::size_t count = points.size();
  const auto fill = [&](const std::string& id, std::span<const std::size_t> of, std::vector<double>& state) {
    const std::vector<double> values = material->initial_state(id);
    for (std::size_t k = 0; k < values.size(); ++k) {
      for (const std::size_t i : of) state[k * count + i] = values[k];
    }
  };
  DamagedFamily result;
  result.state.assign(law.state_count * count, 0.0), result.opening_shift.assign(count, 0.0);
  std::vector<std::size_t> all(count), damaged;
  std::iota(all.begin(), all.end(), 0u);
  fill(family.initial_state, all, result.state);

  std::vector<double> opening(count, 0.0);
  std::vector<std::size_t> opened_by(count, 0), last(count, 0);  // entry of a point's opening, and last one of all
  for (std::size_t d = 0; d < damage.size(); ++d) {
    const Damage& entry = damage[d];
    const bool meant =
        entry.joints.empty() || std::find(entry.joints.begin(), entry.joints.end(), family.name) != entry.joints.end();
    const std::vector<std::size_t> found =
        meant ? points_of(entry, points, of_joints, blocks) : std::vector<std::size_t>();
    if (found.empty()) continue;
    (*hit)[d] += static_cast<double>(found.size());
    if (!(law.capabilities & QUOIN_CAN_MIGRATE))
      throw Error(Exit::bad_input, fmt::format("{}: law {} of joint family '{}' cannot take over a state (QUOIN_CAN_"
                                               "MIGRATE), and so cannot begin damaged",
                                               entry.source.text, law.id, family.name));
    try {
      if (!entry.initial_state.empty()) fill(entry.initial_state, found, result.state);
    } catch (const Error& error) {
      throw Error(Exit::bad_input, fmt::format("{}: initial_state: {}", entry.source.text, error.what()));
    }
    if (entry.slip > 0.0) slide(entry, family, *material, points, found, columns, result.state);
    set_states(entry, family, *material, found, count, result.state);
    for (const std::size_t i : found) {
      if (entry.opening) opening[i] = *entry.opening, opened_by[i] = d;
      last[i] = d;
    }
    damaged.insert(damaged.end(), found.begin(), found.end());
  }
  std::sort(damaged.begin(), damaged.end());
  damaged.erase(std::unique(damaged.begin(), damaged.end()), damaged.end());
  result.points = damaged.size();
  if (damaged.empty()) return result;

  unload_points(family, material, points, damaged, opening, result);
  for (const std::size_t i : damaged) {
    if (opening[i] == 0.0 || std::abs(result.opening_shift[i] - opening[i]) <= 1e-9 * opening[i]) continue;
    const Vec3& x = points[i].position;
    const std::string reason = carries_tension(*material, "dry")
                                   ? fmt::format(
                                         "has law {}, which carries tension in its state \"dry\" too, and so "
                                         "cannot stand open without force",
                                         law.id)
                                   : "is not broken through and cannot stand open without force; give initial_state = "
                                     "\"dry\" with it";
    throw Error(Exit::bad_input,
                fmt::format("{}: opening = {:g} m: the joint of family '{}' at ({:.4f}, {:.4f}, {:.4f}) m {}{}",
                            damage[opened_by[i]].source.text, opening[i], family.name, x[0], x[1], x[2], reason,
                            last[i] > opened_by[i] ? "; " + damage[last[i]].source.text + " changes it later" : ""));
  }
  return result;
}

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
  throw_together(s.ranks, fault);
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
