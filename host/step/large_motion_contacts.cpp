// Contact points in a step of large motion, chunk by chunk: jumps, the law, forces.
#include <algorithm>
#include <cmath>

#include "model/contact_frames.h"
#include "step/contact_kernels.h"
#include "step/large_motion.h"
#include "step/point_kernels.h"
#include "step/rigid_kernels.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

struct Axes {  // axes of the points of a chunk
  FacetFrames* triangles;
  PairAxes* pairs;
};

GridpointColumns gridpoint_columns(Family& f, const Chunk& chunk) {
  return {columns_of(f), chunk.node_a.data(), chunk.node_b.data(), chunk.first};
}

BlockPlaces places_of_blocks(const Model& m) {
  return {m.is_small ? nullptr : m.frames.frame.data(), m.nodes.x.data(), m.bodies.data()};
}

void contact_kinematics(Model& m, Family& f, Chunk& chunk, const Axes& axes) {
  rigid_jumps(chunk.pairs, m.bodies.data(), columns_of(f));
  gridpoint_jumps(chunk.gridpoint_pairs, axes.pairs, places_of_blocks(m), gridpoint_columns(f, chunk));
  facet_jumps(chunk.facets, axes.triangles, m.nodes.x.data(), columns_of(f), m.is_small);
  for (OtherPoint& other : chunk.others) {
    const uint32_t i = other.index;
    Point& p = f.point[i];
    if (p.facet_a >= 0 && !m.is_small) {
      const TriangleFrame frame = triangle_frame(m.nodes.x, m.contacts.facets[p.facet_a]);
      take_axes(p, frame);
      other.gradient = frame.gradient;
    }
    const Location now = locate(m, p, m.contacts.facets);
    p.at = now.at;
    f.normal_jump[i] = now.jump;
    for (int k = 0; k < 2; ++k) f.slip[k][i] = now.slid[k] - f.slid[k][i], f.slid[k][i] = now.slid[k];
    if (p.facet_a >= 0 && !m.is_small) {
      // The foot on the triangle follows the point, so that the pair of forces stays collinear.
      move_foot(m.contacts.facets[p.facet_a], other.gradient, f.slid[0][i], f.slid[1][i]);
      f.slid[0][i] = f.slid[1][i] = 0.0;
    }
  }
}

void contact_law(Model& m, Family& f, Chunk& chunk) {
  if (m.damping.of_contacts()) {
    for (int k = 0; k < 3; ++k)
      std::copy_n(f.traction[k].begin() + chunk.first, chunk.count, f.old_traction[k].begin() + chunk.first);
  }
  chunk.call.evaluate(*f.material);
  if (m.books_energy) sum_energies(f.area.data() + chunk.first, chunk.call);
}

// Computes tractions of stiffness-proportional or impact damping.
void viscous_tractions(Model& m, Family& f, Chunk& chunk) {
  const size_t first = chunk.first;
  const PointColumns c = columns_of(f, first);
  MaxwellColumns maxwell{};
  const auto stiffness = [&](const char* id, double of_material) {
    const PropertyColumn* const drawn = find_column(f.columns, id);
    return drawn ? OfPoints{of_material / drawn->usual, drawn->values.data() + first} : OfPoints{of_material};
  };
  maxwell.normal = stiffness("normal_stiffness", f.material->stiffness_bounds().normal);
  maxwell.shear = stiffness("shear_stiffness", f.material->stiffness_bounds().shear);
  for (size_t k = 0; m.damping.has_maxwell() && k < std::size(f.maxwell); ++k)
    maxwell.traction[k] = f.maxwell[k].data() + first;
  for (size_t e = 0; m.damping.has_maxwell() && e < m.impacts.maxwell.size(); ++e) {
    const double way = m.impacts.maxwell[e].rate * m.stepping.dt;
    maxwell.keep[e] = std::exp(-way), maxwell.gain[e] = -m.impacts.maxwell[e].share * std::expm1(-way) / way;
  }
  double rate[2][kChunk];
  for (size_t k = 0; k < 2 && m.damping.impacts; ++k) {
    for (size_t i = 0; i < chunk.count; ++i) rate[k][i] = m.impacts.share * chunk.viscosity[k][i] / m.stepping.dt;
  }
  if (m.damping.impacts)
    chunk.call.damping = damp_impacts(c, maxwell, chunk.count, {1.0, rate[0]}, {1.0, rate[1]});
  else
    chunk.call.damping = damp_points(c, chunk.count, m.damping.beta / m.stepping.dt);
}

void contact_forces(Model& m, Family& f, Chunk& chunk, const Axes& axes) {
  chunk.call.damping = 0.0;
  if (m.damping.of_contacts()) viscous_tractions(m, f, chunk);
  rigid_forces(chunk.pairs, m.bodies.data(), columns_of(f));
  gridpoint_forces(chunk.gridpoint_pairs, axes.pairs, places_of_blocks(m), gridpoint_columns(f, chunk),
                   m.chunks.rows.data());
  facet_forces(chunk.facets, axes.triangles, columns_of(f), m.chunks.rows.data());
  for (OtherPoint& other : chunk.others) {
    const uint32_t i = other.index;
    const Point& p = f.point[i];
    double traction[3];
    for (int k = 0; k < 3; ++k) traction[k] = f.traction[k][i] + (f.viscous[k].empty() ? 0.0 : f.viscous[k][i]);
    other.shear[0] = traction[1], other.shear[1] = traction[2];
    other.force = {};
    if (traction[0] == 0 && traction[1] == 0 && traction[2] == 0) continue;
    other.force = p.area * in_space(m, p, traction[0] * p.n + traction[1] * p.s + traction[2] * p.t);
  }
}

}  // namespace

void Model::advance_contacts(int index, PhaseClock* clock) {
  Chunk& chunk = chunks.all[size_t(index)];
  Family& f = contacts.families[size_t(chunk.family)];
  thread_local std::vector<FacetFrames> formed;
  thread_local std::vector<PairAxes> turned;
  formed.resize(std::max(formed.size(), chunk.facets.size()));
  turned.resize(std::max(turned.size(), chunk.gridpoint_pairs.size()));
  const Axes axes = is_small ? Axes{chunk.frames.data(), chunk.pair_axes.data()} : Axes{formed.data(), turned.data()};
  contact_kinematics(*this, f, chunk, axes);  // jumps, in frames that move with the blocks
  lap(clock, Phase::jumps);
  contact_law(*this, f, chunk);  // tractions from jumps: the plug-in
  lap(clock, Phase::law);
  contact_forces(*this, f, chunk, axes);  // one force a point, which its two blocks fetch
  lap(clock, Phase::contact_forces);
}

}  // namespace quoin::blocks
