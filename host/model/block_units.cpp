// Deformable blocks and units of two halves, as bodies whose rigid motion is split from the rest (block_inertia.h).
#include "model/block_units.h"

#include <map>

#include "model/contact_frames.h"
#include "model/world.h"

namespace quoin::blocks {

using namespace geometry;

// Two deformable blocks of one unit are its halves; units that are cut into more are advanced block by block, as on the
// lattice.
void find_units(World& w) {
  std::map<int, std::vector<int>> blocks_of;
  for (int i = 0; i < w.block_count(); ++i) {
    if (w.blocks[size_t(i)].body < 0 && w.assembly.blocks[size_t(i)].unit >= 0)
      blocks_of[w.assembly.blocks[size_t(i)].unit].push_back(i);
  }
  w.units.other_half.assign(w.blocks.size(), -1), w.units.apart.assign(w.blocks.size(), 0);
  w.units.joint.assign(w.blocks.size(), 0);
  for (const auto& [unit, blocks] : blocks_of) {
    if (blocks.size() != 2) continue;
    w.units.other_half[size_t(blocks[0])] = blocks[1];
    w.units.other_half[size_t(blocks[1])] = blocks[0];
    ++w.units.count;
  }
}

namespace {

UnitInertia inertia_of(const World& w, const Unit& unit) {
  UnitInertia inertia;
  inertia.count = unit.count;
  for (int k = 0; k < unit.count; ++k) {
    const BlockGridpoints g = w.nodes.of(w.blocks[size_t(unit.block[k])]);
    inertia.block[k] = RigidInertia(g.x, g.mass, g.held);
  }
  if (unit.count == 2) inertia.whole = RigidInertia(inertia.block[0], inertia.block[1]);
  return inertia;
}

}  // namespace

// Kinetic energy by M' less that by s_b M, at the velocities half a step ago, J (< 0).
double rigid_kinetic_energy(const World& w, const Unit& unit) {
  const UnitInertia inertia = inertia_of(w, unit);
  Rigid velocity[2];
  for (int k = 0; k < unit.count; ++k) {
    const BlockGridpoints g = w.nodes.of(w.blocks[size_t(unit.block[k])]);
    const RigidInertia& block = inertia.block[k];
    velocity[k] = block.acceleration(sum_about(block.centre(), g.x, g.v, g.mass));
  }
  return rigid_energy(inertia, {w.solver.deformation_inertia, w.solver.unit_inertia}, velocity);
}

std::vector<UnitInertia> inertia_of_units(const World& w, std::span<const int> blocks) {
  std::vector<UnitInertia> inertia(w.blocks.size());
  for (const int i : blocks) {
    if (w.blocks[size_t(i)].body < 0 && w.units.of(i).block[0] == i) inertia[size_t(i)] = inertia_of(w, w.units.of(i));
  }
  return inertia;
}

// Applies M'^-1/2 M^1/2 to velocities of gridpoints, or its transpose M^1/2 M'^-1/2 to forces.
void scale_motion(const World& w, std::span<const int> blocks, const std::vector<UnitInertia>& inertias,
                  LaneVector<Vector>& y, bool of_forces) {
  const double of_deformation = 1 / std::sqrt(w.solver.deformation_inertia);
  for (const int i : blocks) {
    const Unit unit = w.units.of(i);
    if (w.blocks[size_t(i)].body >= 0 || unit.block[0] != i) continue;
    const double of_unit = unit.count == 1 ? 1.0 : 1 / std::sqrt(w.solver.unit_inertia);
    const UnitInertia& inertia = inertias[size_t(i)];
    Rigid sum[2];
    for (int k = 0; k < unit.count; ++k) {
      const ModelBlock& b = w.blocks[size_t(unit.block[k])];
      const BlockGridpoints g = w.nodes.of(w.blocks[size_t(unit.block[k])]);
      const std::span<const Vector> of_block(y.data() + b.first_node, size_t(b.node_count));
      sum[k] = sum_about(inertia.block[k].centre(), g.x, of_block, of_forces ? std::span<const double>{} : g.mass);
    }
    const Rigid whole = unit.count == 2 ? inertia.motion(sum) : Rigid{};
    for (int k = 0; k < unit.count; ++k) {
      const ModelBlock& b = w.blocks[size_t(unit.block[k])];
      const RigidInertia& block = inertia.block[k];
      Rigid rigid = (of_unit - of_deformation) * block.acceleration(sum[k]);
      if (unit.count == 2) rigid = rigid + (1 - of_unit) * inertia.at_block(k, whole);
      for (size_t n = size_t(b.first_node); n < size_t(b.first_node + b.node_count); ++n) {
        const Vector motion = rigid.linear + cross(rigid.angular, w.nodes.x[n] - block.centre());
        y[n] = of_deformation * y[n] + (of_forces ? w.nodes.mass[n] : 1.0) * motion;
      }
    }
  }
}

namespace {

// Whether the two halves hold together. They do while a point of their joint can close before the next check. Until
// then each half moves by less than a quarter of the way (motion_checks.cpp). They also do while the joint's secant
// stiffness, sigma over opening, is more than 1/s_u of kn. Without the added inertia it would then vibrate faster than
// a closed joint does with it. Halves that are apart join at half of the opening at which they separate.
bool are_together(World& w, int a, int b) {
  const std::vector<Contact>& list = w.contacts.list;
  const Pair pair{a, b};
  size_t& joint = w.units.joint[size_t(a)];
  if (joint >= list.size() || list[joint].pair != pair)  // contacts have changed
    joint = size_t(std::ranges::lower_bound(list, pair, {}, &Contact::pair) - list.begin());
  if (joint == list.size() || list[joint].pair != pair || list[joint].count == 0) return false;
  const Contact& c = list[joint];
  const Family& f = w.contacts.families[size_t(c.family)];
  const double way = (w.units.apart[size_t(a)] ? 1.0 : 2.0) * detection_fraction(w) * w.detection.size;
  for (uint32_t p = c.first; p < c.first + c.count; ++p) {
    const double opening = f.normal_jump[p];
    if (opening < way || w.solver.unit_inertia * f.traction[0][p] > f.kn * opening) return true;
  }
  return false;
}

}  // namespace

// The added inertia of halves against each other slows the vibration of their joint, which would set the time step. So
// it stays as long as a point of the joint can close. Where nothing holds the halves together, it would slow their fall
// apart. Adding or removing it changes no momentum, as velocities stay and P_b - P_u has none. Its kinetic energy, (s_u
// - 1)/2 v . M (P_b - P_u) v, is booked.
void part_units(World& w) {
  if (w.stepping.count < w.checks.next || !splits_motion(w)) return;
  std::vector<int> changed;  // first halves of units that separate or join
  for (int a = 0; a < w.block_count(); ++a) {
    const int b = w.units.other_half[size_t(a)];
    if (b > a && w.part.owns(a) && are_together(w, a, b) == bool(w.units.apart[size_t(a)])) changed.push_back(a);
  }
  if (!w.part.any(!changed.empty())) return;
  std::vector<double> freed(w.blocks.size(), std::nan(""));  // by these halves, J
  for (const int a : changed) {
    const int b = w.units.other_half[size_t(a)];
    const double added =
        rigid_kinetic_energy(w, {{a, b}, 2}) - rigid_kinetic_energy(w, {{a}, 1}) - rigid_kinetic_energy(w, {{b}, 1});
    freed[size_t(a)] = w.units.apart[size_t(a)] ? -added : added;
  }
  w.part.gather_by_block(freed);
  std::vector<int> here;
  for (int a = 0; a < w.block_count(); ++a) {
    if (std::isnan(freed[size_t(a)])) continue;
    if (w.part.owns(a)) here.insert(here.end(), {a, w.units.other_half[size_t(a)]});
    const bool part = !w.units.apart[size_t(a)];
    w.units.apart[size_t(a)] = w.units.apart[size_t(w.units.other_half[size_t(a)])] = part;
    w.units.count += part ? -1 : 1;
    if (w.books_energy) w.step_sums.later.detection += freed[size_t(a)];
  }
  w.part.fetch();
  take_back_facets(w);
  w.pieces.are_old = true;
  divide_work(w);
  if (w.solver.unit_inertia != 1.0 && w.part.any(shorten_step(w, here))) find_time_step(w);
}

}  // namespace quoin::blocks
