// Stable time step: 2/omega_max of the assembled, undamaged system, by Lanczos iteration without forming a matrix.
#include <fmt/format.h>

#include "base/error.h"
#include "members/members.h"
#include "model/block_layout.h"
#include "model/contact_frames.h"
#include "model/halo.h"
#include "model/impact_damping.h"
#include "model/lanczos.h"
#include "model/stepping.h"
#include "model/world.h"
#include "model/world_results.h"
#include "model/zone_kernels.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

// Stiffness K, viscosity C of impact damping, or a sum of both: factors on those of contact points, zones and members.
struct JointSprings {
  double of_stiffness, of_viscosity;
  double of_zones, of_members;  // 1; for dashpots s
  // Normal to the joint and along it, Pa/m; for dashpots Pa s/m.
  std::array<double, 2> of_point(const Family& f, size_t point, const PairPlace& pair) const {
    if (of_viscosity == 0.0) return {of_stiffness * f.kn, of_stiffness * f.ks};
    const auto [normal, shear] = stiffness_of_point(f, point);
    return {of_stiffness * f.kn + of_viscosity * (pair.viscosity[0] * normal),
            of_stiffness * f.ks + of_viscosity * (pair.viscosity[1] * shear)};
  }
};

// visit(family, index of its point, pair): contact points of own pairs with a block for which is_wanted(block) holds.
template <class Visit, class IsWanted>
void each_own_point(const World& w, Visit visit, IsWanted is_wanted) {
  for (size_t k = 0; k < w.contacts.families.size(); ++k) {
    const Family& f = w.contacts.families[k];
    for (const uint32_t i : w.contacts.of_family[k]) {
      const Contact& c = w.contacts.list[i];
      if (!is_wanted(c.pair.a) && !is_wanted(c.pair.b)) continue;
      if (!w.part.owns(c.pair) || (w.units.apart[size_t(c.pair.a)] && w.units.other_half[size_t(c.pair.a)] == c.pair.b))
        continue;
      for (uint32_t p = c.first; p < c.first + c.count; ++p) visit(f, p, w.contacts.place[i]);
    }
  }
}

constexpr JointSprings kStiffness{1.0, 0.0, 1.0, 1.0};

JointSprings impact_dashpots(const World& w) { return {0.0, 1.0, w.impacts.zone_beta, 0.0}; }

// K + 2 C/dt with a share of the viscosity.
JointSprings with_dashpots(const World& w, double share, double dt) {
  const double of_viscosity = 2 * share / dt;
  return {1.0, of_viscosity, 1.0 + of_viscosity * w.impacts.zone_beta, 1.0};
}

}  // namespace

// Upper bound of the ratio of contact stiffness to mass over these blocks and their gridpoints, 1/s2. Dashpots of
// impacts are counted as the stiffness that a step has from them. It is cheap and coarse. Only its growth is used: it
// decides whether the frequency is computed again.
double local_stiffness_bound(const World& w, const std::function<bool(int block)>& is_wanted) {
  LaneVector<double> body(w.bodies.size()), node(w.nodes.x.size());
  const JointSprings springs =
      w.damping.impacts && w.stepping.dt > 0 ? with_dashpots(w, w.impacts.share, w.stepping.dt) : kStiffness;
  const auto add = [&](const Family& f, size_t point, const PairPlace& pair) {
    const Point& p = f.point[point];
    const auto [kn, ks] = springs.of_point(f, point, pair);
    const double k = std::max(kn, ks);
    const Vector at = p.facet_a >= 0 && p.facet_b >= 0 ? Vector{} : place_of(w, p);
    const auto rigid = [&](int block) {
      const Body& b = w.bodies[w.blocks[block].body];
      if (b.held == 0x3f) return;
      const Vector arm = at - b.x;
      body[w.blocks[block].body] +=
          k * p.area * (1 / b.mass + dot(arm, arm) / std::min({b.inertia.x, b.inertia.y, b.inertia.z}));
    };
    const auto soft = [&](const Facet& facet) {
      for (int i = 0; i < 3; ++i)
        node[facet.node[i]] += k * p.area * std::abs(facet.weight[i]) / w.nodes.mass[facet.node[i]];
    };
    if (p.facet_a >= 0)
      soft(w.contacts.facets[p.facet_a]);
    else
      rigid(p.a);
    if (p.facet_b >= 0)
      soft(w.contacts.facets[p.facet_b]);
    else
      rigid(p.b);
  };
  each_own_point(w, add, is_wanted);
  double bound = 0.0;
  for (int i = 0; i < w.block_count(); ++i) {
    if (!w.part.owns(i) || !is_wanted(i)) continue;
    const ModelBlock& b = w.blocks[size_t(i)];
    if (b.body >= 0) bound = std::max(bound, body[size_t(b.body)]);
    for (int n = b.first_node; n < b.first_node + b.node_count; ++n) bound = std::max(bound, node[size_t(n)]);
  }
  return w.part.largest(bound);
}

namespace {

// Adds K times velocities, about the current configuration, without the stiffness of its stress. Blocks in frames have
// the stiffness of their undeformed shape, rotated with the frame. Others are computed zone by zone.
void add_zone_forces(const World& w, std::span<const int> blocks, const LaneVector<Vector>& velocity,
                     LaneVector<Vector>& force) {
  std::vector<double> rows, product;  // four doubles a gridpoint
  for (const int i : blocks) {
    const ModelBlock& b = w.blocks[size_t(i)];
    if (b.body >= 0) continue;
    if (w.frames.by_zone[size_t(i)]) {
      const auto first = size_t(b.first_node);
      for (int z = 0; z < b.zone_count; ++z) {
        const Zone zone = zone_of(w, i, z);
        Matrix deformation = Matrix::zero(), h = Matrix::zero();
        for (int k = 0; k < 4; ++k) {
          deformation += outer(w.nodes.x[first + size_t(zone.node[k])], zone.gradient[k]);
          h += outer(velocity[first + size_t(zone.node[k])], zone.gradient[k]);
        }
        const Matrix raw = transposed(deformation) * h, strain = 0.5 * (raw + transposed(raw));
        const Matrix stress = deformation * (2 * zone.mu * strain + zone.lambda * trace(strain) * Matrix{});
        for (int k = 0; k < 4; ++k) force[first + size_t(zone.node[k])] += zone.volume * (stress * zone.gradient[k]);
      }
      continue;
    }
    const Matrix turned = orientation_of(w, i);
    rows.assign(4 * size_t(b.node_count), 0.0), product.resize(rows.size());
    for (size_t n = 0; n < size_t(b.node_count); ++n) {
      const Vector v = transposed_times(turned, velocity[size_t(b.first_node) + n]);
      for (int c = 0; c < 3; ++c) rows[4 * n + size_t(c)] = v[c];
    }
    stiffness_times(w.zones.lanes_of(b), rows, product.data());
    for (size_t n = 0; n < size_t(b.node_count); ++n)
      force[size_t(b.first_node) + n] += turned * Vector{product[4 * n], product[4 * n + 1], product[4 * n + 2]};
  }
}

// Halo exchange of velocities on both sides of contact points between blocks of different ranks.
struct FrequencyHalo {
  Halo halo;
  // of_body(body, visit): visits its numbers; numbers of gridpoints are those of `nodes`.
  template <class OfBody>
  FrequencyHalo(const World& world, Ranks* ranks, LaneVector<Vector>& nodes, const OfBody& of_body) {
    if (!ranks) return;
    const int here = ranks->rank();
    using Side = std::pair<bool, int>;  // true and a gridpoint, or false and a body
    BorderKeys<Side> keys;
    const auto add_sides = [&](const Family& f, size_t point, const PairPlace&) {
      const Point& p = f.point[point];
      const int rank_a = world.part.rank_of_block[size_t(p.a)], rank_b = world.part.rank_of_block[size_t(p.b)];
      if (rank_a == rank_b) return;
      const auto note = [&](int block, int facet, int rank, int other) {
        if (facet < 0) keys.add({false, world.blocks[size_t(block)].body}, rank, here, {other});
        for (int k = 0; k < 3 && facet >= 0; ++k)
          keys.add({true, world.contacts.facets[size_t(facet)].node[k]}, rank, here, {other});
      };
      note(p.a, p.facet_a, rank_a, rank_b), note(p.b, p.facet_b, rank_b, rank_a);
    };
    each_own_point(world, add_sides, [](int) { return true; });
    halo = keys.halo(ranks->count(), [&](const Side& side, std::vector<double*>& numbers) {
      const auto visit = [&](Vector& v) { numbers.insert(numbers.end(), {&v.x, &v.y, &v.z}); };
      if (side.first)
        visit(nodes[size_t(side.second)]);
      else
        of_body(side.second, visit);
    });
  }
  void exchange(Ranks* ranks) {
    if (ranks) halo.send(*ranks), halo.receive(*ranks);
  }
};

// Operator M^-1/2 K M^-1/2, of own blocks or of one unit. Unknowns are velocities scaled by the square root of inertia,
// first of bodies, then of gridpoints. Rotations are about principal axes.
struct Vibration {
  struct Spring {
    const Point* point;
    std::array<double, 2> stiffness;  // normal to the joint and along it
    Vector at, normal;
    double area;   // m2, twice where the other side is fixed
    Vector force;  // on block b, in the last product
  };
  struct SpringEnd {
    uint32_t spring;
    bool on_b;
  };

  const World& world;
  const JointSprings& stiffness;
  const Unit* alone;
  Ranks* ranks;  // null: one process, or a unit alone
  std::unique_ptr<GatheredSums> shared;
  std::vector<int> blocks, own_bodies;
  std::vector<VectorRow> own_nodes;
  std::vector<UnitInertia> inertia;  // empty: no inertia is scaled
  std::vector<Spring> springs;
  ByBlock<SpringEnd> ends;
  LaneVector<double> scale;
  LaneVector<Vector> v, w, f, m, nv, nf;  // velocity, spin, force, moment of bodies; velocity, force of gridpoints
  FrequencyHalo halo;

  Vibration(const World& of, const JointSprings& k, const Unit* unit)
      : world(of),
        stiffness(k),
        alone(unit),
        ranks(unit ? nullptr : of.part.ranks),
        v(of.bodies.size()),
        w(v.size()),
        f(v.size()),
        m(v.size()),
        nv(of.nodes.x.size()),
        nf(nv.size()),
        halo(of, ranks, nv, [this](int body, const auto& visit) { visit(v[size_t(body)]), visit(w[size_t(body)]); }) {
    list_blocks();
    fill_scale();
    each_own_point(
        world,
        [&](const Family& family, size_t point, const PairPlace& pair) {
          const Point& p = family.point[point];
          const double factor = alone && !(alone->has(p.a) && alone->has(p.b)) ? 2.0 : 1.0;
          springs.push_back({&p,
                             stiffness.of_point(family, point, pair),
                             place_of(world, p),
                             frame_of(world, p).row[0],
                             factor * p.area,
                             {}});
        },
        [&](int block) { return !alone || alone->has(block); });
    list_by_block(world.blocks.size(), ends, [&](const auto& visit) {
      for (uint32_t i = 0; i < springs.size(); ++i)
        visit(springs[i].point->a, SpringEnd{i, false}), visit(springs[i].point->b, SpringEnd{i, true});
    });
    if (splits_motion(world)) inertia = inertia_of_units(world, blocks);
  }

  // Unknowns: six of each body, then three of each gridpoint; for a unit alone, only its own.
  size_t of_nodes() const { return 6 * (alone ? own_bodies.size() : v.size()); }
  size_t size() const { return of_nodes() + 3 * (alone ? node_count() : nv.size()); }
  size_t node_count() const {
    size_t count = 0;
    for (const VectorRow& row : own_nodes) count += row.end - row.first;
    return count;
  }

  // visit(body, index of its first unknown)
  template <class Visit>
  void each_body(const Visit& visit) const {
    size_t next = 0;
    for (const int i : own_bodies) visit(size_t(i), alone ? next : 6 * size_t(i)), next += 6;
  }
  // visit(gridpoint, index of its first unknown)
  template <class Visit>
  void each_node(const Visit& visit) const {
    size_t next = of_nodes();
    for (const VectorRow& row : own_nodes) {
      for (size_t i = row.first; i < row.end; ++i) visit(i, alone ? next : of_nodes() + 3 * i), next += 3;
    }
  }

  void list_blocks() {
    for (int i = 0; i < world.block_count(); ++i) {
      if (alone ? alone->has(i) : world.part.owns(i)) blocks.push_back(i);
    }
    for (const int i : blocks) {
      const ModelBlock& b = world.blocks[size_t(i)];
      const VectorRow of_block{size_t(b.first_node), size_t(b.first_node + b.node_count)};
      if (b.body >= 0)
        own_bodies.push_back(b.body);
      else if (!own_nodes.empty() && own_nodes.back().end == of_block.first)
        own_nodes.back().end = of_block.end;
      else
        own_nodes.push_back(of_block);
    }
    if (!ranks) return;
    shared = std::make_unique<GatheredSums>(*ranks);
    const auto append = [&](size_t i, size_t numbers) { shared->append(world.part.rank_of_block[i], numbers); };
    for (size_t i = 0; i < world.blocks.size(); ++i) append(i, world.blocks[i].body >= 0 ? 6 : 0);
    for (size_t i = 0; i < world.blocks.size(); ++i) append(i, 3 * size_t(world.blocks[i].node_count));
  }

  void fill_scale() {
    scale = LaneVector<double>(size());
    each_body([&](size_t i, size_t first) {
      const Body& b = world.bodies[i];
      for (int k = 0; k < 3; ++k) {
        scale[first + k] = b.held >> k & 1 ? 0.0 : 1 / std::sqrt(b.mass);
        // Held about some axes only: computed as free, which a constraint can only make softer.
        scale[first + 3 + k] = b.held >> 3 == 7 ? 0.0 : 1 / std::sqrt(b.inertia[k]);
      }
    });
    each_node([&](size_t i, size_t first) {
      for (int k = 0; k < 3; ++k)
        scale[first + k] = world.nodes.held[i] >> k & 1 ? 0.0 : 1 / std::sqrt(world.nodes.mass[i]);
    });
  }

  void scatter(const LaneVector<double>& x) {
    each_body([&](size_t i, size_t first) {
      const double *xi = x.data() + first, *si = scale.data() + first;
      v[i] = {xi[0] * si[0], xi[1] * si[1], xi[2] * si[2]};
      w[i] = world.bodies[i].r * Vector{xi[3] * si[3], xi[4] * si[4], xi[5] * si[5]};
      f[i] = m[i] = {};
    });
    each_node([&](size_t i, size_t first) {
      const double *xi = x.data() + first, *si = scale.data() + first;
      nv[i] = {xi[0] * si[0], xi[1] * si[1], xi[2] * si[2]};
      nf[i] = {};
    });
  }

  Vector velocity(int block, int32_t facet, const Vector& at) const {
    Vector sum;
    if (facet >= 0) {
      const Facet& on = world.contacts.facets[facet];
      for (int k = 0; k < 3; ++k) sum += on.weight[k] * nv[on.node[k]];
    } else {
      const int i = world.blocks[block].body;
      sum = v[i] + cross(w[i], at - world.bodies[i].x);
    }
    return sum;
  }

  // sign: 1 on b, -1 on a.
  void add_force(int block, int32_t facet, const Vector& at, double sign, const Vector& force) {
    if (facet >= 0) {
      const Facet& on = world.contacts.facets[facet];
      for (int k = 0; k < 3; ++k) nf[on.node[k]] += sign * (on.weight[k] * force);
    } else {
      const int i = world.blocks[block].body;
      f[i] += sign * force, m[i] += sign * cross(at - world.bodies[i].x, force);
    }
  }

  // y = M^-1/2 K M^-1/2 x; returns x . y over all ranks.
  double product(const LaneVector<double>& x, LaneVector<double>* y) {
    constexpr size_t kBlocksAPart = 64, kSpringsAPart = 1024;  // of the work of one thread at a time
    const auto each_part_of_blocks = [&](const auto& visit) {
      each_part(world.pool, blocks.size(), kBlocksAPart,
                [&](size_t begin, size_t end) { visit(std::span(blocks).subspan(begin, end - begin)); });
    };
    const bool splits = splits_motion(world);
    scatter(x);
    if (splits) each_part_of_blocks([&](auto part) { scale_motion(world, part, inertia, nv, false); });
    halo.exchange(ranks);
    if (stiffness.of_zones != 0.0) each_part_of_blocks([&](auto part) { add_zone_forces(world, part, nv, nf); });
    if (stiffness.of_zones != 1.0) each_node([&](size_t i, size_t) { nf[i] = stiffness.of_zones * nf[i]; });
    each_part(world.pool, springs.size(), kSpringsAPart, [&](size_t begin, size_t end) {
      for (auto& [point, k, at, normal, area, force] : std::span(springs).subspan(begin, end - begin)) {
        const auto [kn, ks] = k;
        const Vector d = velocity(point->b, point->facet_b, at) - velocity(point->a, point->facet_a, at);
        force = area * (ks * d + (kn - ks) * dot(normal, d) * normal);
      }
    });
    each_part_of_blocks([&](auto part) {
      for (const int block : part) {
        for (const auto [i, on_b] : ends.of(block)) {
          const Spring& spring = springs[i];
          const int32_t facet = on_b ? spring.point->facet_b : spring.point->facet_a;
          add_force(block, facet, spring.at, on_b ? 1.0 : -1.0, spring.force);
        }
      }
    });
    if (world.held_by.members && stiffness.of_members != 0.0) add_member_springs(world, alone, {v, w, nv}, {f, m, nf});
    if (splits) each_part_of_blocks([&](auto part) { scale_motion(world, part, inertia, nf, true); });
    return gather(x, y);
  }

  double gather(const LaneVector<double>& x, LaneVector<double>* y) {
    each_body([&](size_t i, size_t first) {
      const Vector torque = transposed_times(world.bodies[i].r, m[i]);
      for (int k = 0; k < 3; ++k) {
        (*y)[first + k] = f[i][k] * scale[first + k];
        (*y)[first + 3 + k] = torque[k] * scale[first + 3 + k];
      }
    });
    each_node([&](size_t i, size_t first) {
      for (int k = 0; k < 3; ++k) (*y)[first + k] = nf[i][k] * scale[first + k];
    });
    const auto add = [&](const VectorRow& row, double sum) {
      for (size_t i = row.first; i < row.end; ++i) sum += x[i] * (*y)[i];
      return sum;
    };
    return shared ? shared->sum(add) : add({0, size()}, 0.0);
  }

  // Random vector with a fixed seed: the same step in every run.
  LaneVector<double> start() const {
    LaneVector<double> x(size());
    uint64_t random = 88172645463325252u;
    for (size_t i = 0; i < x.size(); ++i) {
      random ^= random << 13, random ^= random >> 7, random ^= random << 17;
      if (scale[i] != 0) x[i] = double(random >> 11) / 9007199254740992.0 - 0.5;
    }
    return x;
  }
};

double largest_over_inertia(const World& w, const JointSprings& stiffness, LaneVector<double>* mode = nullptr,
                            const Unit* alone = nullptr) {
  Vibration vibration(w, stiffness, alone);
  const auto product = [&](const LaneVector<double>& x, LaneVector<double>* y) { return vibration.product(x, y); };
  // Coarser than on the lattice: the frequency is computed again each time that contacts have changed.
  LanczosSettings settings;
  settings.max_steps = 80;
  settings.first_check = 11;
  settings.settled = 1e-6;
  settings.with_vector = mode != nullptr;
  LargestEigenvalue largest = largest_eigenvalue(product, vibration.start(), settings, vibration.shared.get());
  if (mode) *mode = std::move(largest.vector);
  return largest.value;
}

}  // namespace

double highest_frequency(const World& w, LaneVector<double>* mode = nullptr) {
  const double value = largest_over_inertia(w, kStiffness, mode);
  return value < 0 ? 0.0 : std::sqrt(value);  // not-a-number is returned
}

// Whether the stiffness or the inertia of these own blocks may need a shorter step. It compares the highest frequency
// of each unit, with all others fixed and the springs to them doubled. As k (u_a - u_b)^2 <= 2 k u_a^2 + 2 k u_b^2,
// this bounds modes of the unit and its neighbours. The result is the same on any number of ranks.
bool shorten_step(const World& w, std::span<const int> changed) {
  const double stable = w.damping.impacts ? w.impacts.stable_dt : w.stepping.critical_dt;
  const JointSprings springs = w.damping.impacts ? with_dashpots(w, w.impacts.share, stable) : kStiffness;
  return std::any_of(changed.begin(), changed.end(), [&](int block) {
    const Unit unit = w.units.of(block);
    return !(largest_over_inertia(w, springs, nullptr, &unit) + w.stepping.springs <= 4.0 / (stable * stable));
  });
}

StepLimit what_sets_time_step(const World& w) {
  LaneVector<double> mode;
  highest_frequency(w, &mode);
  StepLimit limit;
  if (mode.empty()) return limit;  // nothing can move
  double most = 0.0;
  int gridpoint = -1;
  const auto look = [&](size_t first, size_t count) {
    double energy = 0.0;
    for (size_t k = 0; k < count; ++k) energy += mode[first + k] * mode[first + k];
    const bool is_more = energy > most;
    if (is_more) most = energy;
    return is_more;
  };
  for (int i = 0; i < w.block_count(); ++i) {
    const ModelBlock& b = w.blocks[size_t(i)];
    if (b.body >= 0 && look(6 * size_t(b.body), 6)) limit = {i, w.bodies[size_t(b.body)].x}, gridpoint = -1;
    for (int n = b.first_node; n < b.first_node + b.node_count; ++n) {
      if (look(6 * w.bodies.size() + 3 * size_t(n), 3)) limit = {i, w.nodes.x[size_t(n)]}, gridpoint = n - b.first_node;
    }
  }
  if (gridpoint < 0) return limit;
  const Zoning zoning = make_zoning(w, limit.block);
  limit.height = 1e300;
  for (const auto& zone : zoning.zones) {
    if (std::find(zone.begin(), zone.end(), gridpoint) == zone.end()) continue;
    const ZoneSize size = size_of_zone(zoning, zone);
    if (size.height < limit.height) limit.height = size.height, limit.shortest_edge = size.shortest_edge;
  }
  return limit;
}

namespace {

// of_members: bound of the nodes of floors and beams, which no dashpot damps, 1/s2.
double step_under_impact_damping(World& w, double of_members) {
  const double rate = largest_over_inertia(w, impact_dashpots(w));
  const auto [left, share] = step_under_impacts(w.stepping.critical_dt, rate, [&](double of_all, double dt) {
    return std::max(of_members, w.stepping.springs + largest_over_inertia(w, with_dashpots(w, of_all, dt)));
  });
  w.impacts.share = share;
  return left;
}

// Critical step and step for the frequency and the springs in w.stepping.
void choose_time_step(World& w, bool may_grow) {
  const double omega = w.stepping.omega;
  if (omega == 0) {
    // Nothing is in contact yet: the stiffness of a corner contact, times 4 for safety.
    double highest = w.stepping.springs;
    for (int i = 0; i < w.block_count(); ++i) {
      const ModelBlock& b = w.blocks[size_t(i)];
      if (!w.part.owns(i) || b.body < 0 || w.bodies[b.body].held == 0x3f) continue;
      const Body& body = w.bodies[b.body];
      for (const Family& f : w.contacts.families) {
        const double k = std::max(f.kn, f.ks) * b.corner_area * 4;
        highest = std::max(highest, k / body.mass + k * b.radius * b.radius /
                                                        std::min({body.inertia.x, body.inertia.y, body.inertia.z}));
      }
    }
    highest = w.part.largest(highest);
    w.stepping.critical_dt = highest > 0 ? 2 / std::sqrt(highest) : 1e-3;
  } else {
    // The largest eigenvalue of a sum is at most the sum of the largest.
    w.stepping.critical_dt = 2 / std::hypot(omega, std::sqrt(w.stepping.springs));
  }
  const double of_members = w.held_by.members ? w.held_by.members->own_eigenvalue(w.solver.mass_scaling) : 0.0;
  if (of_members > 0) w.stepping.critical_dt = std::min(w.stepping.critical_dt, 2 / std::sqrt(of_members));
  double dt = step_over_critical(w.solver, w.stepping.critical_dt) * w.stepping.critical_dt;
  if (w.damping.impacts) {
    const double left = omega > 0 ? step_under_impact_damping(w, of_members) : kLeastImpactStep;
    w.impacts.stable_dt = left * w.stepping.critical_dt;
    double stiffer = 1.0;  // stiffness of joints above the band, with Maxwell elements
    for (const MaxwellElement& e : w.impacts.maxwell) stiffer += e.share;
    // Without Maxwell elements, time_step_fraction leaves a margin for the stiffness that they add.
    constexpr double kClose = 0.95;
    dt = std::min(dt, kClose / std::sqrt(stiffer) * w.stepping.critical_dt) * left;
  }
  if (!std::isfinite(dt) || dt <= 0) {
    throw Error(Exit::bad_input, fmt::format("the time step, {:.3g} s, must be finite and > 0; check stiffnesses, "
                                             "densities and stiffness_damping",
                                             dt));
  }
  w.stepping.dt = w.stepping.dt > 0 && w.stepping.count > 0 && !may_grow ? std::min(w.stepping.dt, dt) : dt;
}

}  // namespace

double step_over_critical(const SolverSettings& solver, double critical) {
  const Damping damping = damping_of(solver);
  return solver.time_step_fraction * step_left(damping.zone_ratio + damping.beta / critical);  // beta omega / 2
}

void find_time_step(World& w, bool may_grow) {
  take_back_facets(w);
  w.stepping.omega = highest_frequency(w);
  if (!std::isfinite(w.stepping.omega))
    throw Error(Exit::bad_input, "the highest frequency of the model is not a number; check stiffnesses and densities");
  choose_time_step(w, may_grow);
  w.stepping.stiffness_bound = local_stiffness_bound(w, [](int) { return true; });
}

void World::hold_by_springs(double eigenvalue) {
  if (eigenvalue == stepping.springs) return;
  stepping.springs = eigenvalue;
  take_back_facets(*this);
  choose_time_step(*this, false);
}

}  // namespace quoin::blocks
