// The stable time step: 2/omega_max of the assembled, undamaged system, by Lanczos iteration without forming a matrix.
#include <fmt/format.h>

#include "base/error.h"
#include "model/lanczos.h"
#include "model/world.h"
#include "model/zone_kernels.h"

namespace quoin::blocks {

using namespace geometry;

// Upper bound of the stiffness-to-mass ratio that contacts give to any one block or gridpoint, 1/s2: cheap, coarse, and
// only compared with its own earlier value, to learn whether the frequency must be computed anew.
double World::local_stiffness_bound() const {
  std::vector<double> body(bodies_.size(), 0.0), node(node_x_.size(), 0.0);
  for (const Family& f : families_) {
    const double k = std::max(f.kn, f.ks);
    for (const Point& p : f.point) {
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
    }
  }
  double bound = 0.0;
  for (double x : body) bound = std::max(bound, x);
  for (double x : node) bound = std::max(bound, x);
  return bound;
}

// K times velocities, about the configuration of now, without its stress: of blocks in frames the stiffness of their
// undeformed shape, turned along; of others zone by zone.
void World::add_zone_forces(const std::vector<Vector>& velocity, std::vector<Vector>& force) const {
  std::vector<double> rows, product;  // four doubles a gridpoint
  for (int i = 0; i < block_count(); ++i) {
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

double World::highest_frequency() const {
  // Unknowns: velocities scaled by the square root of inertia; rigid rotations about principal axes.
  const size_t nb = bodies_.size(), nn = node_x_.size(), n = 6 * nb + 3 * nn;
  std::vector<double> scale(n);
  for (size_t i = 0; i < nb; ++i) {
    for (int k = 0; k < 3; ++k) {
      scale[6 * i + k] = bodies_[i].held >> k & 1 ? 0.0 : 1 / std::sqrt(bodies_[i].mass);
      // Held about some axes only: as if free, which a constraint can only make softer.
      scale[6 * i + 3 + k] = bodies_[i].held >> 3 == 7 ? 0.0 : 1 / std::sqrt(bodies_[i].inertia[k]);
    }
  }
  for (size_t i = 0; i < nn; ++i) {
    for (int k = 0; k < 3; ++k) scale[6 * nb + 3 * i + k] = node_held_[i] >> k & 1 ? 0.0 : 1 / std::sqrt(node_mass_[i]);
  }
  std::vector<Vector> v(nb), w(nb), f(nb), m(nb), nv(nn), nf(nn);
  std::vector<Vector> place, normals;  // of all contact points
  for (const Family& family : families_) {
    for (const Point& p : family.point) place.push_back(place_of(p)), normals.push_back(frame_of(p).row[0]);
  }
  const std::vector<UnitInertia> inertia = splits_motion() ? inertia_of_units() : std::vector<UnitInertia>{};
  const auto product = [&](const LaneVector<double>& x, LaneVector<double>* result) {
    LaneVector<double>& y = *result;
    for (size_t i = 0; i < nb; ++i) {
      const double *xi = x.data() + 6 * i, *si = scale.data() + 6 * i;
      v[i] = {xi[0] * si[0], xi[1] * si[1], xi[2] * si[2]};
      w[i] = bodies_[i].r * Vector{xi[3] * si[3], xi[4] * si[4], xi[5] * si[5]};
      f[i] = m[i] = {};
    }
    for (size_t i = 0; i < nn; ++i) {
      const double *xi = x.data() + 6 * nb + 3 * i, *si = scale.data() + 6 * nb + 3 * i;
      nv[i] = {xi[0] * si[0], xi[1] * si[1], xi[2] * si[2]};
      nf[i] = {};
    }
    if (splits_motion()) scale_motion(inertia, nv, false);
    add_zone_forces(nv, nf);
    for (size_t next = 0; const Family& family : families_) {
      for (const Point& p : family.point) {
        const Vector at = place[next], normal = normals[next];
        ++next;
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
        const Vector force = p.area * (family.ks * d + (family.kn - family.ks) * dot(normal, d) * normal);
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
    }
    if (splits_motion()) scale_motion(inertia, nf, true);
    for (size_t i = 0; i < nb; ++i) {
      const Vector torque = transposed_times(bodies_[i].r, m[i]);
      for (int k = 0; k < 3; ++k) {
        y[6 * i + k] = f[i][k] * scale[6 * i + k];
        y[6 * i + 3 + k] = torque[k] * scale[6 * i + 3 + k];
      }
    }
    for (size_t i = 0; i < nn; ++i) {
      for (int k = 0; k < 3; ++k) y[6 * nb + 3 * i + k] = nf[i][k] * scale[6 * nb + 3 * i + k];
    }
    double sum = 0.0;
    for (size_t i = 0; i < n; ++i) sum += x[i] * y[i];
    return sum;
  };
  LaneVector<double> start(n);
  uint64_t random = 88172645463325252u;  // fixed seed: the same step in every run
  for (size_t i = 0; i < n; ++i) {
    random ^= random << 13, random ^= random >> 7, random ^= random << 17;
    start[i] = scale[i] == 0 ? 0.0 : double(random >> 11) / 9007199254740992.0 - 0.5;
  }
  // Rough beside the lattice's: the frequency is found anew each time that contacts have changed.
  LanczosSettings settings;
  settings.max_steps = 80;
  settings.first_check = 11;
  settings.settled = 1e-6;
  const double value = largest_eigenvalue(product, std::move(start), settings).value;
  return value < 0 ? 0.0 : std::sqrt(value);  // not a number stays so
}

void World::hold_by_springs(double eigenvalue) {
  springs_ = eigenvalue;
  find_time_step();
}

void World::find_time_step() {
  const double omega = highest_frequency();
  if (!std::isfinite(omega))
    throw Error(Exit::bad_input, "the highest frequency of the model is not a number; check stiffnesses and densities");
  stiffness_bound_ = local_stiffness_bound();
  if (omega == 0) {
    // Nothing is in contact yet: the stiffness that a corner contact will have, taken 4 times for safety.
    double highest = springs_;
    for (const ModelBlock& b : blocks_) {
      if (b.body < 0 || bodies_[b.body].held == 0x3f) continue;
      const Body& body = bodies_[b.body];
      for (const Family& f : families_) {
        const double k = std::max(f.kn, f.ks) * b.corner_area * 4;
        highest = std::max(highest, k / body.mass + k * b.radius * b.radius /
                                                        std::min({body.inertia.x, body.inertia.y, body.inertia.z}));
      }
    }
    critical_dt_ = highest > 0 ? 2 / std::sqrt(highest) : 1e-3;
  } else {
    // The eigenvalue of a sum of springs is at most the sum of theirs.
    critical_dt_ = 2 / std::hypot(omega, std::sqrt(springs_));
  }
  double fraction = solver_.time_step_fraction;
  if (solver_.damping == DampingKind::viscous && solver_.stiffness_damping > 0) {
    const double xi = solver_.stiffness_damping / critical_dt_;  // damping ratio at omega_max: beta omega / 2
    fraction *= std::sqrt(1 + xi * xi) - xi;
  }
  if (solver_.damping == DampingKind::block) {
    const double xi = solver_.deformation_damping;
    fraction *= std::sqrt(1 + xi * xi) - xi;
  }
  const double dt = fraction * critical_dt_;
  if (!std::isfinite(dt) || dt <= 0) {
    throw Error(Exit::bad_input, fmt::format("the time step, {:.3g} s, must be finite and > 0; check stiffnesses, "
                                             "densities and stiffness_damping",
                                             dt));
  }
  dt_ = dt_ > 0 && step_count_ > 0 ? std::min(dt_, dt) : dt;
}

}  // namespace quoin::blocks
