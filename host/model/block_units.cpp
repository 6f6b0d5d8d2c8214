// Deformable blocks and masonry units of two halves as bodies whose rigid motion is told from the rest (inertia.h).
#include <map>

#include "model/world.h"

namespace quoin::blocks {

using namespace geometry;

// Two deformable blocks of one unit are its halves; units cut into more stand alone block by block, as on the lattice.
void World::find_units() {
  std::map<int, std::vector<int>> blocks_of;
  for (int i = 0; i < block_count(); ++i) {
    if (blocks_[size_t(i)].body < 0 && assembly_.blocks[size_t(i)].unit >= 0)
      blocks_of[assembly_.blocks[size_t(i)].unit].push_back(i);
  }
  other_half_.assign(blocks_.size(), -1);
  for (const auto& [unit, blocks] : blocks_of) {
    if (blocks.size() != 2) continue;
    other_half_[size_t(blocks[0])] = blocks[1];
    other_half_[size_t(blocks[1])] = blocks[0];
    ++unit_count_;
  }
}

Unit World::unit_of(int block) const {
  const int other = other_half_[size_t(block)];
  if (other < 0) return {{block, -1}, 1};
  return {{std::min(block, other), std::max(block, other)}, 2};
}

Gridpoints World::gridpoints_of(int block) const {
  const ModelBlock& b = blocks_[size_t(block)];
  const auto of_block = [&](const auto& field) {
    return std::span(field).subspan(size_t(b.first_node), size_t(b.node_count));
  };
  return {of_block(node_x_), of_block(node_v_), of_block(node_mass_), of_block(node_held_)};
}

UnitInertia World::inertia_of(const Unit& unit) const {
  UnitInertia inertia;
  inertia.count = unit.count;
  for (int k = 0; k < unit.count; ++k) {
    const Gridpoints g = gridpoints_of(unit.block[k]);
    inertia.block[k] = RigidInertia(g.x, g.mass, g.held);
  }
  if (unit.count == 2) inertia.whole = RigidInertia(inertia.block[0], inertia.block[1]);
  return inertia;
}

// What M' leaves out of the kinetic energy of s_b M, of the velocities half a step ago, J (< 0).
double World::rigid_kinetic_energy(const Unit& unit) const {
  const UnitInertia inertia = inertia_of(unit);
  Rigid velocity[2];
  for (int k = 0; k < unit.count; ++k) {
    const Gridpoints g = gridpoints_of(unit.block[k]);
    const RigidInertia& block = inertia.block[k];
    velocity[k] = block.acceleration(sum_about(block.centre(), g.x, g.v, g.mass));
  }
  return rigid_energy(inertia, {solver_.deformation_inertia, solver_.unit_inertia}, velocity);
}

std::vector<UnitInertia> World::inertia_of_units() const {
  std::vector<UnitInertia> inertia(blocks_.size());
  for (int i = 0; i < block_count(); ++i) {
    if (owns(i) && blocks_[size_t(i)].body < 0 && unit_of(i).block[0] == i) inertia[size_t(i)] = inertia_of(unit_of(i));
  }
  return inertia;
}

// M'^-1/2 M^1/2 on velocities of gridpoints, or M^1/2 M'^-1/2 on forces, which is its transpose.
void World::scale_motion(const std::vector<UnitInertia>& inertias, LaneVector<Vector>& y, bool of_forces) const {
  const double of_deformation = 1 / std::sqrt(solver_.deformation_inertia);
  for (int i = 0; i < block_count(); ++i) {
    const Unit unit = unit_of(i);
    if (!owns(i) || blocks_[size_t(i)].body >= 0 || unit.block[0] != i) continue;
    const double of_unit = unit.count == 1 ? 1.0 : 1 / std::sqrt(solver_.unit_inertia);
    const UnitInertia& inertia = inertias[size_t(i)];
    Rigid sum[2];
    for (int k = 0; k < unit.count; ++k) {
      const ModelBlock& b = blocks_[size_t(unit.block[k])];
      const Gridpoints g = gridpoints_of(unit.block[k]);
      const std::span<const Vector> of_block(y.data() + b.first_node, size_t(b.node_count));
      sum[k] = sum_about(inertia.block[k].centre(), g.x, of_block, of_forces ? std::span<const double>{} : g.mass);
    }
    const Rigid whole = unit.count == 2 ? inertia.motion(sum) : Rigid{};
    for (int k = 0; k < unit.count; ++k) {
      const ModelBlock& b = blocks_[size_t(unit.block[k])];
      const RigidInertia& block = inertia.block[k];
      Rigid rigid = (of_unit - of_deformation) * block.acceleration(sum[k]);
      if (unit.count == 2) rigid = rigid + (1 - of_unit) * inertia.at_block(k, whole);
      for (size_t n = size_t(b.first_node); n < size_t(b.first_node + b.node_count); ++n) {
        const Vector motion = rigid.linear + cross(rigid.angular, node_x_[n] - block.centre());
        y[n] = of_deformation * y[n] + (of_forces ? node_mass_[n] : 1.0) * motion;
      }
    }
  }
}

// Halves that have turned or moved against each other beyond the bound of small motion are blocks of their own for
// good: inertia on each other that nothing holds would slow their fall apart. Velocities stay, and so does momentum;
// the kinetic energy of that inertia is booked, and the time step chosen anew.
void World::part_units() {
  if (step_count_ < next_check_ || !splits_motion()) return;
  std::vector<double> freed(blocks_.size(), std::nan(""));  // by the first half of those that part, J
  bool parted = false;
  for (int a = 0; a < block_count(); ++a) {
    const int b = other_half_[size_t(a)];
    if (b < a || !owns(a)) continue;
    Vector xa, xb;
    Matrix ra, rb;
    pose(a, xa, ra), pose(b, xb, rb);
    const Matrix &start_ra = start_[size_t(a)].r, &start_rb = start_[size_t(b)].r;
    const Vector half = 0.5 * (start_[size_t(b)].x - start_[size_t(a)].x);  // to the middle of their joint
    const Vector opening = xb - rb * transposed_times(start_rb, half) - (xa + ra * transposed_times(start_ra, half));
    const double turned = angle_between(transposed(ra) * rb, transposed(start_ra) * start_rb);
    const double length = std::min(blocks_[size_t(a)].least_extent, blocks_[size_t(b)].least_extent);
    if (turned <= solver_.motion_bound.rotation && norm(opening) <= solver_.motion_bound.sliding * length) continue;
    const double together = rigid_kinetic_energy({{a, b}, 2});
    freed[size_t(a)] = together - rigid_kinetic_energy({{a}, 1}) - rigid_kinetic_energy({{b}, 1});
    parted = true;
  }
  if (!any(parted)) return;
  tell_by_block(freed);
  for (int a = 0; a < block_count(); ++a) {
    if (std::isnan(freed[size_t(a)])) continue;
    int& b = other_half_[size_t(a)];
    other_half_[size_t(b)] = -1, b = -1;
    --unit_count_;
    if (energy_) later_.detection += freed[size_t(a)];
  }
  fetch_();
  take_back_facets();
  divide_work();
  if (solver_.unit_inertia != 1.0) find_time_step();
}

}  // namespace quoin::blocks
