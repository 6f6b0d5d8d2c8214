#include "step/tangent.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "base/error.h"
#include "step/points_at_rest.h"
#include "step/results.h"
#include "step/stages.h"
#include "step/unknowns.h"

namespace quoin {

namespace {

using geometry::Matrix;
using geometry::Vector;

// Change of traction by the probing motion: far below any strength, far above the rounding of tractions.
constexpr double kProbe = 1.0;  // Pa

struct PointStiffness {
  std::vector<double> normal, shear;  // Pa/m, by contact point
};

// Mask of all capabilities.
constexpr std::uint64_t kAny = ~std::uint64_t{0};

// Traction along n, s or t after a small motion along it, Pa; NaN where a law has no capabilities.
std::vector<double> traction_after(const Simulation::Impl& s, const PointRange& all, std::size_t along,
                                   const std::vector<double>& motion) {
  const std::size_t count = at(all.end);
  std::vector<double> result(count, std::numeric_limits<double>::quiet_NaN()), slip[2], jump(count);
  for (auto& of_axis : slip) of_axis.assign(count, 0.0);
  if (along > 0) slip[along - 1] = motion;
  evaluate_points_at_rest(s, kAny, all, [&](quoin_batch& batch, std::size_t first) {
    for (std::size_t i = 0; i < batch.count; ++i)
      jump[first + i] = batch.normal_jump.data[i * batch.normal_jump.stride] + (along == 0 ? motion[first + i] : 0.0);
    batch.normal_jump = {jump.data() + first, 1};
    for (std::size_t k = 0; k < 2; ++k) batch.slip_increment[k] = {slip[k].data() + first, 1};
    batch.traction_new[along] = {result.data() + first, 1};
  });
  return result;
}

PointStiffness stiffness_now(const Simulation::Impl& s, const PointRange& all,
                             const std::vector<ContactPoint>& points) {
  const std::size_t count = at(all.end);
  PointStiffness k{std::vector<double>(count), std::vector<double>(count)};
  std::vector<double> closing(count), forth(count), back(count);
  for (const ContactPoint& p : points) {
    const quoin_stiffness_bounds bounds = stiffness_bounds_at(s, p);
    closing[at(p.index)] = bounds.normal > 0.0 ? -kProbe / bounds.normal : 0.0;
    forth[at(p.index)] = bounds.shear > 0.0 ? kProbe / bounds.shear : 0.0;
    back[at(p.index)] = -forth[at(p.index)];
  }
  const std::vector<double> none(count, 0.0);
  for (std::size_t along = 0; along < 3; ++along) {
    const std::vector<double> still = traction_after(s, all, along, none);
    const std::vector<double> one = traction_after(s, all, along, along == 0 ? closing : forth);
    const std::vector<double> other = along == 0 ? one : traction_after(s, all, along, back);
    for (std::size_t i = 0; i < count; ++i) {
      const double way = along == 0 ? closing[i] : forth[i];
      if (way == 0.0) continue;
      // The larger stiffness of both directions: in one of them the point may slide.
      const double stiffness =
          std::isnan(still[i])
              ? still[i]
              : std::max({0.0, (one[i] - still[i]) / way, along > 0 ? (still[i] - other[i]) / way : 0.0});
      along == 0 ? k.normal[i] = stiffness : k.shear[i] += 0.5 * stiffness;
    }
  }
  for (const ContactPoint& p : points) {  // points whose law gives no stiffness: its bounds
    if (!std::isnan(k.normal[at(p.index)]) && !std::isnan(k.shear[at(p.index)])) continue;
    const quoin_stiffness_bounds bounds = stiffness_bounds_at(s, p);
    const bool carries = p.traction[0] != 0.0 || p.jump[0] <= 0.0;
    k.normal[at(p.index)] = carries ? bounds.normal : 0.0, k.shear[at(p.index)] = carries ? bounds.shear : 0.0;
  }
  return k;
}

// Inertia of a rigid block about the global axes, kg m2.
Matrix inertia_of(const Simulation::Impl& s, int b) {
  if (!s.large_motion) return Matrix::diagonal(geometry::vector(s.model.bodies[at(s.model.place[at(b)].body)].inertia));
  const blocks::Body& body = body_of(*s.large_motion, b);
  const double unscaled = body.mass > 0.0 ? s.large_motion->blocks[b].mass / body.mass : 0.0;
  Matrix inertia = Matrix::zero();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      for (int c = 0; c < 3; ++c) inertia.row[i][j] += unscaled * body.r.row[i][c] * body.r.row[j][c] * body.inertia[c];
    }
  }
  return inertia;
}

void add_gridpoints(const Simulation::Impl& s, int b, const Unknowns::OfBlock& u, Tangent* tangent) {
  std::vector<double> mass;
  if (s.large_motion) {
    const int first = s.large_motion->blocks[b].first_node;
    double scaled = 0.0;
    for (std::size_t n = 0; n < u.gridpoint.size(); ++n) mass.push_back(s.large_motion->nodes.mass[at(first) + n]);
    for (const double m : mass) scaled += m;
    for (double& m : mass) m *= s.large_motion->blocks[b].mass / scaled;
  } else {
    s.model.for_each_gridpoint(b, [&](std::size_t, double m) { mass.push_back(m); });
  }
  for (std::size_t n = 0; n < u.gridpoint.size(); ++n) {
    for (int c = 0; c < 3; ++c) {
      const int i = u.gridpoint[n][at(c)];
      if (i < 0) continue;
      tangent->unknown[at(i)] = {b, static_cast<int>(n), {}, {}, {}};
      tangent->unknown[at(i)].translation[c] = 1.0;
      tangent->mass[at(i)] = mass[n];
    }
  }
}

// Adds a rigid body, and to `turned`, whose columns are the new unknowns.
void add_body(const Simulation::Impl& s, int b, const Unknowns::OfBlock& u, Tangent* tangent,
              StiffnessEntries* turned) {
  const double mass =
      s.large_motion ? s.large_motion->blocks[b].mass : s.model.bodies[at(s.model.place[at(b)].body)].mass;
  std::vector<int> axes;
  for (int c = 0; c < 3; ++c) {
    if (const int i = u.body[at(c)]; i >= 0) {
      tangent->unknown[at(i)] = {b, -1, {}, {}, u.centre};
      tangent->unknown[at(i)].translation[c] = 1.0, tangent->mass[at(i)] = mass;
      turned->emplace_back(i, i, 1.0);
    }
    if (u.body[at(c + 3)] >= 0) axes.push_back(c);
  }
  std::size_t next = 0;
  for (const FreeRotation& rotation : free_rotations(axes, inertia_of(s, b))) {
    const int column = u.body[at(axes[next++] + 3)];
    for (const int axis : axes) turned->emplace_back(u.body[at(axis + 3)], column, rotation.spin[axis]);
    tangent->unknown[at(column)] = {b, -1, {}, rotation.spin, u.centre};
    tangent->mass[at(column)] = rotation.inertia;
  }
}

// A force that turns with a rigid block changes by theta x F: its stiffness is [F]x between forces and spins. That of
// its moment has no symmetric part.
void add_following(const Unknowns& unknowns, int block, const Vector& force, StiffnessEntries* entries) {
  const std::array<int, 6>& of = unknowns.blocks()[at(block)].body;
  add_turning({of[0], of[1], of[2]}, {of[3], of[4], of[5]}, force, entries);
}

// On each corner of a triangle of a deformable face acts -p/6 (y - x) x (z - x). It changes by -p/6 e x u for the
// motion u of the corner opposite to the edge e.
void add_pressure(blocks::Model& m, const Unknowns& unknowns, const blocks::Pressure& p, StiffnessEntries* entries) {
  const double pressure = p.scale * p.value;
  const Unknowns::OfBlock& u = unknowns.blocks()[at(p.block)];
  if (u.rigid) return add_following(unknowns, p.block, pressure * (body_of(m, p.block).r * p.push), entries);
  for (const auto& triangle : p.triangles) {
    const auto unknown = [&](std::size_t k) { return u.gridpoint[at(triangle[k] - m.blocks[p.block].first_node)]; };
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector edge = m.nodes.x[at(triangle[(k + 2) % 3])] - m.nodes.x[at(triangle[(k + 1) % 3])];
      for (std::size_t i = 0; i < 3; ++i) add_turning(unknown(i), unknown(k), (pressure / 6.0) * edge, entries);
    }
  }
}

// Adds the stiffness of loads: forces keep their directions, pressures follow faces.
void add_loads(const Simulation::Impl& s, const Unknowns& unknowns, StiffnessEntries* entries) {
  blocks::Model& m = *s.large_motion;
  const auto add = [&](int block, const Vector& force, const Vector& arm) {
    if (unknowns.blocks()[at(block)].rigid) unknowns.add_force(block, force, body_of(m, block).r * arm, entries);
  };
  for (int b = 0; b < static_cast<int>(m.actions.applied.size()); ++b)
    add(b, m.actions.applied[at(b)].force, m.blocks[b].load_arm);
  for (const blocks::Load& load : m.actions.loads) add(load.block, load.scale * load.force, load.arm);
  for (const blocks::Pressure& pressure : m.actions.pressures) add_pressure(m, unknowns, pressure, entries);
}

}  // namespace

// Dashpots of impact and viscous damping: viscosity over stiffness by contact point, normal and along, and of zones, s.
struct Dashpots {
  std::vector<std::array<double, 2>> of_point;
  double of_zones = 0.0, of_mass = 0.0;  // 1/s
};

std::optional<Dashpots> dashpots_of(const Simulation::Impl& s, const std::vector<ContactPoint>& points) {
  const Damping damping = damping_of(solver_in_use(s));
  if (!damping.impacts && damping.alpha == 0.0 && damping.beta == 0.0) return std::nullopt;
  Dashpots all{std::vector<std::array<double, 2>>(points.size(), {damping.beta, damping.beta}), damping.beta,
               damping.alpha};
  if (!damping.impacts) return all;
  const ImpactDamping& impacts = s.time_step.impacts;
  all.of_zones = impacts.of_zones;
  if (s.large_motion) {
    all.of_point = blocks::impact_viscosities(*s.large_motion);
  } else {
    for (const ContactPoint& p : points) all.of_point[at(p.index)] = impacts.viscosity[at(p.family)];
  }
  return all;
}

Tangent tangent_of(const Simulation::Impl& s) {
  if (s.ranks) throw Error(Exit::bad_input, "modes of a state: in one process alone; start quoin without mpirun");
  const Unknowns unknowns(s);
  const std::vector<ContactPoint> points = contact_points(s);
  const PointStiffness k = stiffness_now(s, all_points(s), points);
  Tangent t;
  t.groups = unknowns.groups();
  t.unknown.resize(at(unknowns.count())), t.mass.resize(at(unknowns.count()));
  t.symmetry_factor =
      s.large_motion ? (s.large_motion->assembly.symmetry_plane_z0 ? 2.0 : 1.0) : s.model.assembly.symmetry_factor;
  const std::optional<Dashpots> dashpots = dashpots_of(s, points);
  StiffnessEntries entries, turned, viscous;
  unknowns.add_zones(&entries);
  for (const Eigen::Triplet<double>& e : entries) {
    if (dashpots) viscous.emplace_back(e.row(), e.col(), dashpots->of_zones * e.value());
  }
  unknowns.add_stresses(points, &entries);
  if (s.large_motion) add_loads(s, unknowns, &entries);  // on the lattice loads act at centres
  for (const ContactPoint& p : points) {
    const double normal = k.normal[at(p.index)], shear = k.shear[at(p.index)];
    ++t.points;
    if (normal == 0.0 && shear == 0.0) ++t.open;
    unknowns.add_point(p, p.area * normal, p.area * shear, &entries);
    if (!dashpots || (p.traction[0] >= 0.0 && damping_of(solver_in_use(s)).impacts)) continue;
    const auto& [beta, along] = dashpots->of_point[at(p.index)];
    unknowns.add_point(p, p.area * beta * normal, p.area * along * shear, &viscous);
  }
  for (int b = 0; b < block_count(s); ++b) {
    const Unknowns::OfBlock& u = unknowns.blocks()[at(b)];
    if (u.rigid)
      add_body(s, b, u, &t, &turned);
    else
      add_gridpoints(s, b, u, &t);
    for (const auto& of_point : u.gridpoint) {
      for (const int i : of_point)
        if (i >= 0) turned.emplace_back(i, i, 1.0);
    }
  }
  const auto n = static_cast<Eigen::Index>(unknowns.count());
  Eigen::SparseMatrix<double> about_axes(n, n), turn(n, n);
  about_axes.setFromTriplets(entries.begin(), entries.end());
  turn.setFromTriplets(turned.begin(), turned.end());
  const auto turned_about = [&turn](const Eigen::SparseMatrix<double>& lower) {
    const Eigen::SparseMatrix<double> whole = lower.selfadjointView<Eigen::Lower>();
    return Eigen::SparseMatrix<double>(
        Eigen::SparseMatrix<double>(turn.transpose() * whole * turn).triangularView<Eigen::Lower>());
  };
  t.stiffness = turned_about(about_axes);
  if (!dashpots) return t;
  about_axes.setFromTriplets(viscous.begin(), viscous.end());
  t.viscosity = turned_about(about_axes);
  for (Eigen::Index i = 0; i < n; ++i)
    if (dashpots->of_mass != 0.0) t.viscosity.coeffRef(i, i) += dashpots->of_mass * t.mass[static_cast<std::size_t>(i)];
  return t;
}

}  // namespace quoin
