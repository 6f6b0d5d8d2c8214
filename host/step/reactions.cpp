// What supports, and what drives blocks, give to the joints of what they hold.
#include <algorithm>

#include "step/state.h"

namespace quoin {

using geometry::Vector;

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

bool holds(const BodyControl& control) {
  return !control.body.empty() &&
         std::any_of(control.kind.begin(), control.kind.end(), [](DofKind kind) { return kind == DofKind::velocity; });
}

bool moves(const BodyControl& control) {
  for (std::size_t c = 0; c < 3; ++c) {
    if (control.kind[c] == DofKind::velocity &&
        (control.velocity[c] != 0.0 || control.in_cycles == static_cast<int>(c)))
      return true;
  }
  return false;
}

}  // namespace

// Of the bodies and blocks of now; names are those of the first time, as the history has its columns by then.
void Simulation::Impl::find_restraints() {
  std::vector<std::string> names;
  if (large_motion) {
    for (const blocks::Block& block : large_motion->assembly.blocks) names.push_back(block.name);
  } else {
    for (const RigidBody& body : model.bodies) names.push_back(body.name);
  }
  if (!restraints_found) {
    const auto add = [&](const std::string& name, bool driven) {
      const auto found =
          std::find_if(restraints.begin(), restraints.end(), [&](const Restraint& r) { return r.name == name; });
      if (found != restraints.end())
        found->driven = found->driven || driven;
      else if (std::find(names.begin(), names.end(), name) != names.end())
        restraints.push_back({name, driven});
    };
    for (const Stage& of : scene.stages) {
      for (const BodyControl& control : of.controls)
        if (holds(control)) add(control.body, moves(control));
    }
    for (std::size_t b = 0; large_motion && b < names.size() && restraints.size() <= kMostRestraints; ++b)
      if (large_motion->assembly.blocks[b].fixed && !names[b].empty()) add(names[b], false);
    for (std::size_t b = 0; !large_motion && b < names.size(); ++b)
      if (model.assembly.bricks[at(model.bodies[b].block)].fixed && !names[b].empty()) add(names[b], false);
    if (restraints.size() > kMostRestraints) restraints.clear();
    restraints_found = true;
  }
  restraint_of.assign(names.size(), -1);
  for (std::size_t i = 0; i < restraints.size(); ++i) {
    for (std::size_t b = 0; b < names.size(); ++b)
      if (names[b] == restraints[i].name) restraint_of[b] = static_cast<int>(i);
  }
}

void Simulation::Impl::find_restrained_blocks() {
  const auto& blocks = large_motion->assembly.blocks;
  std::set<int> found;
  for (std::size_t b = 0; b < blocks.size(); ++b)
    if (blocks[b].fixed) found.insert(static_cast<int>(b));
  for (const Stage& of : scene.stages) {
    for (const BodyControl& control : of.controls) {
      if (!holds(control)) continue;
      for (const int b : blocks_named(control.body, of.source.text)) found.insert(b);
    }
  }
  restrained_blocks.assign(found.begin(), found.end());
  block_wrench.assign(in_parts ? blocks.size() : 0, {});
}

JointWrench Simulation::Impl::sum_joint_wrench(int body) const {
  const RigidBody& b = model.bodies[at(body)];
  JointWrench sum;
  sum.centre = b.centre;
  for (std::size_t i = 0; i < b.point.size(); ++i) {
    const auto p = static_cast<std::size_t>(b.point[i]), n = static_cast<std::size_t>(model.point_axis[p]);
    Vec3 of_point{};
    const Vec3 all = point_traction(p);
    for (std::size_t c = 0; c < 3; ++c) of_point[(n + c) % 3] = b.sign[i] * (model.area[p] * all[c]);
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t next = (c + 1) % 3, last = (c + 2) % 3;
      sum.force[c] += of_point[c];
      sum.moment[c] += b.arm[i][next] * of_point[last] - b.arm[i][last] * of_point[next];
    }
  }
  // Forces are those of the last evaluation of the laws, so the displacement is given for that time too.
  const Vec3 moved = of_body(body, &BodyLanes::displacement), v = of_body(body, &BodyLanes::velocity);
  for (std::size_t c = 0; c < 3; ++c) sum.displacement[c] = moved[c] - data.time_step * v[c];
  return sum;
}

// Viscous forces of contacts included.
std::vector<JointWrench> Simulation::Impl::sum_large_motion_wrenches(const std::vector<int>& blocks) const {
  std::vector<JointWrench> sums(blocks.size());
  std::vector<int> place(at(large_motion->block_count()), -1);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    place[at(blocks[i])] = static_cast<int>(i);
    sums[i].centre = geometry::array(large_motion->start_position(blocks[i]));
    sums[i].displacement = block_translation_at_forces({blocks[i]});
    sums[i].force = geometry::array(large_motion->contact_force(blocks[i]));
  }
  if (blocks.empty()) return sums;
  for (const blocks::Contact& c : large_motion->contacts.list) {
    const int of_a = place[at(c.pair.a)], of_b = place[at(c.pair.b)];
    if (of_a < 0 && of_b < 0) continue;
    const blocks::Family& f = large_motion->families()[at(c.family)];
    for (std::size_t i = c.first; i < c.first + c.count; ++i) {
      const geometry::Matrix frame = large_motion->frame_of(f.point[i]);
      const Vector place_of_point = large_motion->place_of(f.point[i]);
      Vector on_a;
      for (std::size_t k = 0; k < 3; ++k)
        on_a += f.point[i].area * (f.traction[k][i] + (f.viscous[k].empty() ? 0.0 : f.viscous[k][i])) *
                frame.row[static_cast<int>(k)];
      for (const auto& [side, sign] : {std::pair{of_a, 1.0}, std::pair{of_b, -1.0}}) {
        if (side < 0) continue;
        JointWrench& sum = sums[at(side)];
        const Vector moment = sign * cross(place_of_point - geometry::vector(sum.centre), on_a);
        for (std::size_t k = 0; k < 3; ++k) sum.moment[k] += moment[static_cast<int>(k)];
      }
    }
  }
  return sums;
}

// Bits 0..2: x, y, z of a body or block are imposed now; 3..5: its rotation about them.
std::vector<std::uint8_t> Simulation::Impl::held_now() const {
  std::vector<std::uint8_t> held;
  for (std::size_t b = 0; !large_motion && b < model.bodies.size(); ++b) {
    const auto [index, lane] = body_place[b];
    unsigned bits = 0;
    for (unsigned c = 0; c < 6; ++c) bits |= body_lanes[at(index)].prescribed[c][lane] != 0.0 ? 1u << c : 0u;
    held.push_back(static_cast<std::uint8_t>(bits));
  }
  if (!large_motion) return held;
  for (const blocks::Block& block : large_motion->assembly.blocks) held.push_back(block.fixed ? 0x3f : 0);
  for (const Drive& drive : drives) held[at(drive.block)] = drive.held;
  return held;
}

void Simulation::Impl::measure_reactions(HistoryRow& row) const {
  const std::vector<std::uint8_t> held = held_now();
  std::vector<int> members = restrained_blocks;
  std::vector<JointWrench> wrenches;
  if (large_motion && (!in_parts || has_all())) {
    wrenches = sum_large_motion_wrenches(members);
  } else if (large_motion) {
    for (const int b : members) wrenches.push_back(block_wrench[at(b)]);
  } else {
    members.clear();
    for (int b = 0; b < static_cast<int>(held.size()); ++b) {
      if (held[at(b)] == 0 && restraint_of[at(b)] < 0) continue;
      members.push_back(b);
      wrenches.push_back(has_all() ? sum_joint_wrench(b) : body_wrench[at(b)]);
    }
  }
  std::vector<Vector> centre(restraints.size());
  std::vector<double> count(restraints.size(), 0.0);
  for (std::size_t i = 0; i < members.size(); ++i) {
    const int r = restraint_of[at(members[i])];
    if (r >= 0) centre[at(r)] += geometry::vector(wrenches[i].centre), count[at(r)] += 1.0;
  }
  const double whole = model.assembly.symmetry_factor;
  const auto add = [&](Reaction& sum, const Vector& given, const Vector& moment) {
    for (std::size_t c = 0; c < 3; ++c) {
      const int k = static_cast<int>(c);
      sum.force[c] += given[k], sum.moment[c] += moment[k];
    }
  };
  for (std::size_t i = 0; i < members.size(); ++i) {
    const JointWrench& of = wrenches[i];
    const unsigned bits = held[at(members[i])];
    Vector given, moment;
    for (std::size_t c = 0; c < 3; ++c) {
      const int k = static_cast<int>(c);
      if (bits >> c & 1u) given[k] = -whole * of.force[c];
      if (bits >> (c + 3) & 1u) moment[k] = -whole * of.moment[c];
    }
    add(row.reaction_sum, given, moment + cross(geometry::vector(of.centre), given));
    const int r = restraint_of[at(members[i])];
    if (r < 0) continue;
    Reaction& reaction = row.reactions[at(r)];
    add(reaction, given, moment + cross(geometry::vector(of.centre) - centre[at(r)] / count[at(r)], given));
    for (std::size_t c = 0; c < 3; ++c) reaction.displacement[c] += of.displacement[c] / count[at(r)];
  }
}

}  // namespace quoin
