// Deformable blocks and masonry units of two halves as bodies whose rigid motion is split from the rest (inertia.h).
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
  units_.other_half.assign(blocks_.size(), -1), units_.apart.assign(blocks_.size(), 0);
  for (const auto& [unit, blocks] : blocks_of) {
    if (blocks.size() != 2) continue;
    units_.other_half[size_t(blocks[0])] = blocks[1];
    units_.other_half[size_t(blocks[1])] = blocks[0];
    ++units_.count;
  }
}

UnitInertia World::inertia_of(const Unit& unit) const {
  UnitInertia inertia;
  inertia.count = unit.count;
  for (int k = 0; k < unit.count; ++k) {
    const BlockGridpoints g = nodes_.of(blocks_[size_t(unit.block[k])]);
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
    const BlockGridpoints g = nodes_.of(blocks_[size_t(unit.block[k])]);
    const RigidInertia& block = inertia.block[k];
    velocity[k] = block.acceleration(sum_about(block.centre(), g.x, g.v, g.mass));
  }
  return rigid_energy(inertia, {solver_.deformation_inertia, solver_.unit_inertia}, velocity);
}

std::vector<UnitInertia> World::inertia_of_units(std::span<const int> blocks) const {
  std::vector<UnitInertia> inertia(blocks_.size());
  for (const int i : blocks) {
    if (blocks_[size_t(i)].body < 0 && units_.of(i).block[0] == i) inertia[size_t(i)] = inertia_of(units_.of(i));
  }
  return inertia;
}

// M'^-1/2 M^1/2 on velocities of gridpoints, or M^1/2 M'^-1/2 on forces, which is its transpose.
void World::scale_motion(std::span<const int> blocks, const std::vector<UnitInertia>& inertias, LaneVector<Vector>& y,
                         bool of_forces) const {
  const double of_deformation = 1 / std::sqrt(solver_.deformation_inertia);
  for (const int i : blocks) {
    const Unit unit = units_.of(i);
    if (blocks_[size_t(i)].body >= 0 || unit.block[0] != i) continue;
    const double of_unit = unit.count == 1 ? 1.0 : 1 / std::sqrt(solver_.unit_inertia);
    const UnitInertia& inertia = inertias[size_t(i)];
    Rigid sum[2];
    for (int k = 0; k < unit.count; ++k) {
      const ModelBlock& b = blocks_[size_t(unit.block[k])];
      const BlockGridpoints g = nodes_.of(blocks_[size_t(unit.block[k])]);
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
        const Vector motion = rigid.linear + cross(rigid.angular, nodes_.x[n] - block.centre());
        y[n] = of_deformation * y[n] + (of_forces ? nodes_.mass[n] : 1.0) * motion;
      }
    }
  }
}

// Whether a point of the joint between halves can close before the next check. Until then each of them moves by less
// than a quarter of the way (motion_checks.cpp). Or whether it holds them: what is left of its stiffness, sigma over
// opening, is more than 1/s_u of kn. Without the added inertia it would then vibrate faster than a closed joint does
// with it. What has come apart is farther away.
bool World::are_together(int a, int b) const {
  const Pair pair{a, b};
  const auto c = std::lower_bound(contacts_.list.begin(), contacts_.list.end(), pair,
                                  [](const Contact& contact, const Pair& p) { return contact.pair < p; });
  if (c == contacts_.list.end() || pair < c->pair || c->count == 0) return false;
  const Family& f = contacts_.families[size_t(c->family)];
  const double way = (units_.apart[size_t(a)] ? 1.0 : 2.0) * detection_fraction() * detection_.size;
  for (uint32_t p = c->first; p < c->first + c->count; ++p) {
    const double opening = f.normal_jump[p];
    if (opening < way || solver_.unit_inertia * f.traction[0][p] > f.kn * opening) return true;
  }
  return false;
}

// The added inertia of halves against each other is there to slow the vibration of their joint, which would set the
// time step. So it stays as long as a point of the joint can close. Where nothing holds them together it would slow
// their fall apart. Inertia that goes or comes back takes no momentum with it, as velocities stay and P_b - P_u has
// none. Its kinetic energy, (s_u - 1)/2 v . M (P_b - P_u) v, is booked.
void World::part_units() {
  if (stepping_.count < checks_.next || !splits_motion()) return;
  std::vector<double> freed(blocks_.size(), std::nan(""));  // by the first half of those that part or meet, J
  bool changed = false;
  for (int a = 0; a < block_count(); ++a) {
    const int b = units_.other_half[size_t(a)];
    if (b < a || !owns(a) || are_together(a, b) != bool(units_.apart[size_t(a)])) continue;
    const double added =
        rigid_kinetic_energy({{a, b}, 2}) - rigid_kinetic_energy({{a}, 1}) - rigid_kinetic_energy({{b}, 1});
    freed[size_t(a)] = units_.apart[size_t(a)] ? -added : added;
    changed = true;
  }
  if (!any(changed)) return;
  gather_by_block(freed);
  std::vector<int> here;
  for (int a = 0; a < block_count(); ++a) {
    if (std::isnan(freed[size_t(a)])) continue;
    if (owns(a)) here.insert(here.end(), {a, units_.other_half[size_t(a)]});
    const bool part = !units_.apart[size_t(a)];
    units_.apart[size_t(a)] = units_.apart[size_t(units_.other_half[size_t(a)])] = part;
    units_.count += part ? -1 : 1;
    if (energy_) step_sums_.later.detection += freed[size_t(a)];
  }
  part_.fetch();
  take_back_facets();
  divide_work();
  if (solver_.unit_inertia != 1.0 && any(shorten_step(here))) find_time_step();
}

}  // namespace quoin::blocks
