// The stable time step: 2/omega_max of the assembled, undamaged system, by Lanczos iteration without forming a matrix.
#include <fmt/format.h>

#include <set>

#include "base/error.h"
#include "model/lanczos.h"
#include "model/told_sums.h"
#include "model/world.h"
#include "model/zone_kernels.h"

namespace quoin::blocks {

using namespace geometry;

template <class Visit>
void World::each_own_point(Visit visit, const Unit* alone) const {
  for (size_t k = 0; k < families_.size(); ++k) {
    const Family& f = families_[k];
    for (const uint32_t i : contacts_of_family_[k]) {
      const Contact& c = contacts_[i];
      if (alone && !alone->has(c.pair.a) && !alone->has(c.pair.b)) continue;
      if (!owns(c) || (apart_[size_t(c.pair.a)] && other_half_[size_t(c.pair.a)] == c.pair.b)) continue;
      for (uint32_t p = c.first; p < c.first + c.count; ++p) visit(f, f.point[p]);
    }
  }
}

// Upper bound of the stiffness-to-mass ratio that contacts give to any one block or gridpoint, 1/s2: cheap, coarse, and
// only compared with its own earlier value, to learn whether the frequency must be computed anew.
double World::local_stiffness_bound() const {
  LaneVector<double> body(bodies_.size()), node(node_x_.size());
  each_own_point([&](const Family& f, const Point& p) {
    const double k = std::max(f.kn, f.ks);
    const Vector at = p.facet_a >= 0 && p.facet_b >= 0 ? Vector{} : place_of(p);
    const auto rigid = [&](int block) {
      const Body& b = bodies_[blocks_[block].body];
      if (b.held == 0x3f) return;
      const Vector arm = at - b.x;
      body[blocks_[block].body] +=
          k * p.area * (1 / b.mass + dot(arm, arm) / std::min({b.inertia.x, b.inertia.y, b.inertia.z}));
    };
    const auto soft = [&](const Facet& facet) {
      for (int i = 0; i < 3; ++i)
        node[facet.node[i]] += k * p.area * std::abs(facet.weight[i]) / node_mass_[facet.node[i]];
    };
    if (p.facet_a >= 0)
      soft(facets_[p.facet_a]);
    else
      rigid(p.a);
    if (p.facet_b >= 0)
      soft(facets_[p.facet_b]);
    else
      rigid(p.b);
  });
  double bound = 0.0;
  for (int i = 0; i < block_count(); ++i) {
    if (!owns(i)) continue;
    const ModelBlock& b = blocks_[size_t(i)];
    if (b.body >= 0) bound = std::max(bound, body[size_t(b.body)]);
    for (int n = b.first_node; n < b.first_node + b.node_count; ++n) bound = std::max(bound, node[size_t(n)]);
  }
  return largest(bound);
}

// K times velocities, about the configuration of now, without its stress: of blocks in frames the stiffness of their
// undeformed shape, turned along; of others zone by zone.
void World::add_zone_forces(std::span<const int> blocks, const LaneVector<Vector>& velocity,
                            LaneVector<Vector>& force) const {
  std::vector<double> rows, product;  // four doubles a gridpoint
  for (const int i : blocks) {
    const ModelBlock& b = blocks_[size_t(i)];
    if (b.body >= 0) continue;
    if (by_zone_[size_t(i)]) {
      for (int z = b.first_zone; z < b.first_zone + b.zone_count; ++z) {
        const Zone& zone = zones_[size_t(z)];
        Matrix deformation = Matrix::zero(), h = Matrix::zero();
        for (int k = 0; k < 4; ++k) {
          deformation += outer(node_x_[zone.node[k]], zone.gradient[k]);
          h += outer(velocity[zone.node[k]], zone.gradient[k]);
        }
        const Matrix raw = transposed(deformation) * h, strain = 0.5 * (raw + transposed(raw));
        const Matrix stress = deformation * (2 * zone.mu * strain + zone.lambda * trace(strain) * Matrix{});
        for (int k = 0; k < 4; ++k) force[zone.node[k]] += zone.volume * (stress * zone.gradient[k]);
      }
      continue;
    }
    const Matrix turned = orientation(i);
    rows.assign(4 * size_t(b.node_count), 0.0), product.resize(rows.size());
    for (size_t n = 0; n < size_t(b.node_count); ++n) {
      const Vector v = transposed_times(turned, velocity[size_t(b.first_node) + n]);
      for (int c = 0; c < 3; ++c) rows[4 * n + size_t(c)] = v[c];
    }
    stiffness_times(zones_in_lanes(b), rows, product.data());
    for (size_t n = 0; n < size_t(b.node_count); ++n)
      force[size_t(b.first_node) + n] += turned * Vector{product[4 * n], product[4 * n + 1], product[4 * n + 2]};
  }
}

// Velocities on both sides of contact points between blocks of different ranks, of those who compute them.
struct World::FrequencyHalo {
  Halo halo;
  // of_body(body, visit): its numbers; gridpoints have those of `nodes`.
  template <class OfBody>
  FrequencyHalo(const World& world, Ranks* ranks, LaneVector<Vector>& nodes, const OfBody& of_body) {
    if (!ranks) return;
    const int here = ranks->rank();
    using Side = std::pair<bool, int>;  // whether of a gridpoint, and which; else which body
    std::map<int, std::set<Side>> to, from;
    world.each_own_point([&](const Family&, const Point& p) {
      const int rank_a = world.rank_of_block_[size_t(p.a)], rank_b = world.rank_of_block_[size_t(p.b)];
      if (rank_a == rank_b) return;
      const auto note = [&](int block, int facet, int rank, int other) {
        std::set<Side>& sides = rank == here ? to[other] : from[rank];
        if (facet < 0) sides.insert({false, world.blocks_[size_t(block)].body});
        for (int k = 0; k < 3 && facet >= 0; ++k) sides.insert({true, world.facets_[size_t(facet)].node[k]});
      };
      note(p.a, p.facet_a, rank_a, rank_b), note(p.b, p.facet_b, rank_b, rank_a);
    });
    const auto add = [&](const Side& side, std::vector<double*>& numbers) {
      const auto visit = [&](Vector& v) { numbers.insert(numbers.end(), {&v.x, &v.y, &v.z}); };
      if (side.first)
        visit(nodes[size_t(side.second)]);
      else
        of_body(side.second, visit);
    };
    for (int r = 0; r < ranks->count(); ++r) {
      Border border{r, {}, {}, {}, {}};
      for (const Side& side : to[r]) add(side, border.send);
      for (const Side& side : from[r]) add(side, border.receive);
      halo.add(std::move(border));
    }
  }
  void exchange(Ranks* ranks) {
    if (ranks) halo.send(*ranks), halo.receive(*ranks);
  }
};

double World::highest_frequency(LaneVector<double>* mode, const Unit* alone) const {
  // Unknowns: velocities scaled by the square root of inertia; rigid rotations about principal axes.
  const size_t nb = bodies_.size(), nn = node_x_.size(), n = 6 * nb + 3 * nn;
  std::vector<int> blocks;
  const auto has = [&](int block) { return alone ? alone->has(block) : owns(block); };
  for (int i = 0; i < block_count(); ++i) {
    if (has(i)) blocks.push_back(i);
  }
  Ranks* const ranks = alone ? nullptr : ranks_;
  std::unique_ptr<ToldSums> shared;
  if (ranks) {
    shared = std::make_unique<ToldSums>(*ranks);
    for (size_t i = 0; i < blocks_.size(); ++i) shared->append(rank_of_block_[i], blocks_[i].body >= 0 ? 6 : 0);
    for (size_t i = 0; i < blocks_.size(); ++i) shared->append(rank_of_block_[i], 3 * size_t(blocks_[i].node_count));
  }
  std::vector<int> own_bodies;
  std::vector<VectorRow> own_nodes;
  for (const int i : blocks) {
    const ModelBlock& b = blocks_[size_t(i)];
    const VectorRow of_block{size_t(b.first_node), size_t(b.first_node + b.node_count)};
    if (b.body >= 0)
      own_bodies.push_back(b.body);
    else if (!own_nodes.empty() && own_nodes.back().end == of_block.first)
      own_nodes.back().end = of_block.end;
    else
      own_nodes.push_back(of_block);
  }
  const auto each_body = [&](const auto& visit) {
    for (const int i : own_bodies) visit(size_t(i));
  };
  const auto each_node = [&](const auto& visit) {
    for (const VectorRow& row : own_nodes) {
      for (size_t i = row.first; i < row.end; ++i) visit(i);
    }
  };
  LaneVector<double> scale(n);
  each_body([&](size_t i) {
    for (int k = 0; k < 3; ++k) {
      scale[6 * i + k] = bodies_[i].held >> k & 1 ? 0.0 : 1 / std::sqrt(bodies_[i].mass);
      // Held about some axes only: as if free, which a constraint can only make softer.
      scale[6 * i + 3 + k] = bodies_[i].held >> 3 == 7 ? 0.0 : 1 / std::sqrt(bodies_[i].inertia[k]);
    }
  });
  each_node([&](size_t i) {
    for (int k = 0; k < 3; ++k) scale[6 * nb + 3 * i + k] = node_held_[i] >> k & 1 ? 0.0 : 1 / std::sqrt(node_mass_[i]);
  });
  LaneVector<Vector> v(nb), w(nb), f(nb), m(nb), nv(nn), nf(nn);
  FrequencyHalo halo(*this, ranks, nv,
                     [&](int body, const auto& visit) { visit(v[size_t(body)]), visit(w[size_t(body)]); });
  struct Spring {
    const Family* family;
    const Point* point;
    Vector at, normal;
    double area;  // m2, twice where it is bound to what stands still
  };
  std::vector<Spring> springs;
  each_own_point(
      [&](const Family& family, const Point& p) {
        const double factor = alone && !(alone->has(p.a) && alone->has(p.b)) ? 2.0 : 1.0;
        springs.push_back({&family, &p, place_of(p), frame_of(p).row[0], factor * p.area});
      },
      alone);
  const std::vector<UnitInertia> inertia = splits_motion() ? inertia_of_units(blocks) : std::vector<UnitInertia>{};
  const auto product = [&](const LaneVector<double>& x, LaneVector<double>* result) {
    LaneVector<double>& y = *result;
    each_body([&](size_t i) {
      const double *xi = x.data() + 6 * i, *si = scale.data() + 6 * i;
      v[i] = {xi[0] * si[0], xi[1] * si[1], xi[2] * si[2]};
      w[i] = bodies_[i].r * Vector{xi[3] * si[3], xi[4] * si[4], xi[5] * si[5]};
      f[i] = m[i] = {};
    });
    each_node([&](size_t i) {
      const double *xi = x.data() + 6 * nb + 3 * i, *si = scale.data() + 6 * nb + 3 * i;
      nv[i] = {xi[0] * si[0], xi[1] * si[1], xi[2] * si[2]};
      nf[i] = {};
    });
    if (splits_motion()) scale_motion(blocks, inertia, nv, false);
    halo.exchange(ranks);
    add_zone_forces(blocks, nv, nf);
    for (const auto& [of_family, of_point, at, normal, area] : springs) {
      const Family& family = *of_family;
      const Point& p = *of_point;
      Vector va, vb;
      if (p.facet_a >= 0) {
        for (int k = 0; k < 3; ++k) va += facets_[p.facet_a].weight[k] * nv[facets_[p.facet_a].node[k]];
      } else {
        const int i = blocks_[p.a].body;
        va = v[i] + cross(w[i], at - bodies_[i].x);
      }
      if (p.facet_b >= 0) {
        for (int k = 0; k < 3; ++k) vb += facets_[p.facet_b].weight[k] * nv[facets_[p.facet_b].node[k]];
      } else {
        const int i = blocks_[p.b].body;
        vb = v[i] + cross(w[i], at - bodies_[i].x);
      }
      const Vector d = vb - va;
      const Vector force = area * (family.ks * d + (family.kn - family.ks) * dot(normal, d) * normal);
      if (p.facet_a >= 0) {
        for (int k = 0; k < 3; ++k) nf[facets_[p.facet_a].node[k]] -= facets_[p.facet_a].weight[k] * force;
      } else {
        const int i = blocks_[p.a].body;
        f[i] -= force, m[i] -= cross(at - bodies_[i].x, force);
      }
      if (p.facet_b >= 0) {
        for (int k = 0; k < 3; ++k) nf[facets_[p.facet_b].node[k]] += facets_[p.facet_b].weight[k] * force;
      } else {
        const int i = blocks_[p.b].body;
        f[i] += force, m[i] += cross(at - bodies_[i].x, force);
      }
    }
    if (splits_motion()) scale_motion(blocks, inertia, nf, true);
    each_body([&](size_t i) {
      const Vector torque = transposed_times(bodies_[i].r, m[i]);
      for (int k = 0; k < 3; ++k) {
        y[6 * i + k] = f[i][k] * scale[6 * i + k];
        y[6 * i + 3 + k] = torque[k] * scale[6 * i + 3 + k];
      }
    });
    each_node([&](size_t i) {
      for (int k = 0; k < 3; ++k) y[6 * nb + 3 * i + k] = nf[i][k] * scale[6 * nb + 3 * i + k];
    });
    const auto add = [&](const VectorRow& row, double sum) {
      for (size_t i = row.first; i < row.end; ++i) sum += x[i] * y[i];
      return sum;
    };
    return shared ? shared->sum(add) : add({0, n}, 0.0);
  };
  LaneVector<double> start(n);
  uint64_t random = 88172645463325252u;  // fixed seed: the same step in every run
  for (size_t i = 0; i < n; ++i) {
    random ^= random << 13, random ^= random >> 7, random ^= random << 17;
    if (scale[i] != 0) start[i] = double(random >> 11) / 9007199254740992.0 - 0.5;
  }
  // Rough beside the lattice's: the frequency is found anew each time that contacts have changed.
  LanczosSettings settings;
  settings.max_steps = 80;
  settings.first_check = 11;
  settings.settled = 1e-6;
  settings.with_vector = mode != nullptr;
  LargestEigenvalue largest = largest_eigenvalue(product, std::move(start), settings, shared.get());
  if (mode) *mode = std::move(largest.vector);
  const double value = largest.value;
  return value < 0 ? 0.0 : std::sqrt(value);  // not a number stays so
}

// Whether the stiffness or the inertia that these own blocks have got may ask for a shorter step. Of each unit the
// highest frequency with all others held still and the springs to them doubled: k (u_a - u_b)^2 <= 2 k u_a^2 + 2 k
// u_b^2, so that it bounds modes in which the unit and its neighbours take part. The same on any number of ranks.
bool World::shorten_step(std::span<const int> changed) const {
  return std::any_of(changed.begin(), changed.end(), [&](int block) {
    const Unit unit = unit_of(block);
    return !(highest_frequency(nullptr, &unit) * critical_dt_ <= 2.0);
  });
}

StepLimit World::what_sets_time_step() const {
  LaneVector<double> mode;
  highest_frequency(&mode);
  double most = 0.0;
  StepLimit limit;
  int gridpoint = -1;
  const auto look = [&](size_t first, size_t count) {
    double energy = 0.0;
    for (size_t k = 0; k < count; ++k) energy += mode[first + k] * mode[first + k];
    const bool is_more = energy > most;
    if (is_more) most = energy;
    return is_more;
  };
  for (int i = 0; i < block_count(); ++i) {
    const ModelBlock& b = blocks_[size_t(i)];
    if (b.body >= 0 && look(6 * size_t(b.body), 6)) limit = {i, bodies_[size_t(b.body)].x}, gridpoint = -1;
    for (int n = b.first_node; n < b.first_node + b.node_count; ++n) {
      if (look(6 * bodies_.size() + 3 * size_t(n), 3)) limit = {i, node_x_[size_t(n)]}, gridpoint = n - b.first_node;
    }
  }
  if (gridpoint < 0) return limit;
  const Zoning zoning = make_zoning(limit.block);
  limit.height = 1e300;
  for (const auto& zone : zoning.zones) {
    if (std::find(zone.begin(), zone.end(), gridpoint) == zone.end()) continue;
    const ZoneSize size = size_of_zone(zoning, zone);
    if (size.height < limit.height) limit.height = size.height, limit.shortest_edge = size.shortest_edge;
  }
  return limit;
}

void World::hold_by_springs(double eigenvalue) {
  if (eigenvalue == springs_) return;
  springs_ = eigenvalue;
  find_time_step();
}

double step_over_critical(const SolverSettings& solver, double critical) {
  double xi = 0.0;                                                                       // damping ratio at omega_max
  if (solver.damping == DampingKind::viscous) xi = solver.stiffness_damping / critical;  // beta omega / 2
  if (solver.damping == DampingKind::block) xi = solver.deformation_damping;
  return solver.time_step_fraction * (std::sqrt(1 + xi * xi) - xi);
}

void World::find_time_step(bool may_grow) {
  const double omega = highest_frequency();
  if (!std::isfinite(omega))
    throw Error(Exit::bad_input, "the highest frequency of the model is not a number; check stiffnesses and densities");
  stiffness_bound_ = local_stiffness_bound();
  if (omega == 0) {
    // Nothing is in contact yet: the stiffness that a corner contact will have, taken 4 times for safety.
    double highest = springs_;
    for (int i = 0; i < block_count(); ++i) {
      const ModelBlock& b = blocks_[size_t(i)];
      if (!owns(i) || b.body < 0 || bodies_[b.body].held == 0x3f) continue;
      const Body& body = bodies_[b.body];
      for (const Family& f : families_) {
        const double k = std::max(f.kn, f.ks) * b.corner_area * 4;
        highest = std::max(highest, k / body.mass + k * b.radius * b.radius /
                                                        std::min({body.inertia.x, body.inertia.y, body.inertia.z}));
      }
    }
    highest = largest(highest);
    critical_dt_ = highest > 0 ? 2 / std::sqrt(highest) : 1e-3;
  } else {
    // The eigenvalue of a sum of springs is at most the sum of theirs.
    critical_dt_ = 2 / std::hypot(omega, std::sqrt(springs_));
  }
  const double dt = step_over_critical(solver_, critical_dt_) * critical_dt_;
  if (!std::isfinite(dt) || dt <= 0) {
    throw Error(Exit::bad_input, fmt::format("the time step, {:.3g} s, must be finite and > 0; check stiffnesses, "
                                             "densities and stiffness_damping",
                                             dt));
  }
  dt_ = dt_ > 0 && step_count_ > 0 && !may_grow ? std::min(dt_, dt) : dt;
}

}  // namespace quoin::blocks
