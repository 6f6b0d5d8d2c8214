#include "step/reactions.h"

#include <algorithm>
#include <set>

#include "members/members.h"
#include "model/world_results.h"
#include "step/block_motion.h"
#include "step/gather.h"
#include "step/large_motion_run.h"
#include "step/lattice_motion.h"
#include "step/state.h"

namespace quoin {

using geometry::Vector;

std::vector<std::uint8_t> held_now(const Simulation::Impl& s) {
  std::vector<std::uint8_t> held;
  for (int block = 0; block < block_count(s); ++block)
    held.push_back(is_fixed(s, block) ? kAllPrescribed : std::uint8_t{0});
  for (const Drive& drive : s.actions.drives) held[at(drive.block)] = drive.held;
  return held;
}

namespace {

bool holds_place(const BodyControl& control) {
  return std::ranges::find(control.kind, DofKind::velocity) != control.kind.end();
}
bool holds(const BodyControl& control) { return !control.body.empty() && (holds_place(control) || !control.may_turn); }

bool moves(const BodyControl& control) {
  for (std::size_t c = 0; c < 3; ++c) {
    if (control.kind[c] == DofKind::velocity &&
        (control.velocity[c] != 0.0 || control.in_cycles == static_cast<int>(c)))
      return true;
  }
  return false;
}

}  // namespace

void find_restraints(Simulation::Impl& s) {
  if (!s.large_motion) find_restrained_blocks(s);
  std::vector<std::string> names;
  for (int b = 0; b < block_count(s); ++b)
    names.push_back(s.large_motion || is_rigid(s, b) ? name_in_stages(s, b) : std::string());
  if (!s.reactions.restraints_found) {
    const auto add = [&](const std::string& name, bool driven) {
      const auto found = std::find_if(s.reactions.restraints.begin(), s.reactions.restraints.end(),
                                      [&](const Restraint& r) { return r.name == name; });
      if (found != s.reactions.restraints.end())
        found->driven = found->driven || driven;
      else if (std::find(names.begin(), names.end(), name) != names.end())
        s.reactions.restraints.push_back({name, driven});
    };
    for (const Stage& of : s.scene.stages) {
      for (const BodyControl& control : of.controls)
        if (holds(control)) add(control.body, moves(control));
    }
    for (std::size_t b = 0; b < names.size() && s.reactions.restraints.size() <= kMostRestraints; ++b)
      if (is_fixed(s, static_cast<int>(b)) && !names[b].empty()) add(names[b], false);
    if (s.reactions.restraints.size() > kMostRestraints) s.reactions.restraints.clear();
    s.reactions.restraints_found = true;
  }
  s.reactions.restraint_of.assign(names.size(), -1);
  for (std::size_t i = 0; i < s.reactions.restraints.size(); ++i) {
    for (std::size_t b = 0; b < names.size(); ++b)
      if (names[b] == s.reactions.restraints[i].name) s.reactions.restraint_of[b] = static_cast<int>(i);
  }
}

void find_restrained_blocks(Simulation::Impl& s) {
  std::set<int> found;
  for (int b = 0; b < block_count(s); ++b)
    if (is_fixed(s, b)) found.insert(b);
  for (const Stage& of : s.scene.stages) {
    for (const BodyControl& control : of.controls) {
      if (!holds(control)) continue;
      for (const int b : blocks_named(s, control.body, of.source.text)) {
        // Where rotation alone is held, its moment is a reaction, too.
        if (is_rigid(s, b) || (s.large_motion && holds_place(control))) found.insert(b);
      }
    }
  }
  s.reactions.restrained_blocks.assign(found.begin(), found.end());
  s.reactions.wrench.assign(s.ranks ? at(block_count(s)) : 0, {});
}

std::vector<JointWrench> sum_large_motion_wrenches(const Simulation::Impl& s, const std::vector<int>& blocks) {
  std::vector<JointWrench> sums(blocks.size());
  std::vector<int> place(at(s.large_motion->block_count()), -1);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    place[at(blocks[i])] = static_cast<int>(i);
    sums[i].centre = geometry::array(start_position_of(*s.large_motion, blocks[i]));
    sums[i].displacement = displacement_at_forces(s, {blocks[i]});
    sums[i].force = geometry::array(s.large_motion->step_sums.contact_force[blocks[i]]);
  }
  if (blocks.empty()) return sums;
  const auto add_moment = [](JointWrench& sum, const Vector& at, const Vector& force) {
    sum.moment += geometry::array(cross(at - geometry::vector(sum.centre), force));
  };
  if (const members::Members* const members = s.large_motion->held_by.members.get()) {
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      for (const int node : members->nodes_of(blocks[i]))
        add_moment(sums[i], members->nodes()[at(node)].x, members->nodes()[at(node)].force);
    }
  }
  for (const blocks::Contact& c : s.large_motion->contacts.list) {
    if (c.count == 0 || (place[at(c.pair.a)] < 0 && place[at(c.pair.b)] < 0)) continue;
    const blocks::Family& f = s.large_motion->contacts.families[at(c.family)];
    for (std::size_t i = c.first; i < c.first + c.count; ++i) {
      const int of_a = place[at(f.point[i].a)], of_b = place[at(f.point[i].b)];  // block a of the pair may be b here
      const Vector place_of_point = place_of(*s.large_motion, f.point[i]);
      const Vector on_a = force_on_a(*s.large_motion, f, i);
      for (const auto& [side, sign] : {std::pair{of_a, 1.0}, std::pair{of_b, -1.0}}) {
        if (side >= 0) add_moment(sums[at(side)], place_of_point, sign * on_a);
      }
    }
  }
  return sums;
}

Vec3 force_on_whole(const Simulation::Impl& s, const Vec3& of_half) {
  const double whole = s.model.assembly.symmetry_factor;
  return {whole * of_half[0], whole * of_half[1], whole == 1.0 ? of_half[2] : 0.0};
}

Vec3 moment_on_whole(const Simulation::Impl& s, const Vec3& of_half) {
  const double whole = s.model.assembly.symmetry_factor;
  if (whole == 1.0) return of_half;
  return {0.0, 0.0, whole * of_half[2]};
}

std::vector<JointWrench> wrenches_of_supports(const Simulation::Impl& s) {
  const std::vector<int>& blocks = s.reactions.restrained_blocks;
  if (s.large_motion && (!s.parts.divided || has_all(s))) return sum_large_motion_wrenches(s, blocks);
  std::vector<JointWrench> wrenches;
  for (const int b : blocks) wrenches.push_back(s.large_motion ? s.reactions.wrench[at(b)] : joint_wrench(s, b));
  if (s.large_motion) return wrenches;
  // Joints lie where their support has carried them, against its centre at the start.
  for (JointWrench& of : wrenches) of.moment += cross(of.displacement, of.force);
  return wrenches;
}

void measure_reactions(const Simulation::Impl& s, std::span<const JointWrench> wrenches,
                       std::span<const std::uint8_t> held, HistoryRow& row) {
  const std::vector<int>& restrained = s.reactions.restrained_blocks;
  std::vector<Vector> centre(s.reactions.restraints.size());
  std::vector<double> count(s.reactions.restraints.size(), 0.0);
  for (std::size_t i = 0; i < restrained.size(); ++i) {
    const int r = s.reactions.restraint_of[at(restrained[i])];
    if (r >= 0) centre[at(r)] += geometry::vector(wrenches[i].centre), count[at(r)] += 1.0;
  }
  const auto add = [&](Reaction& sum, const Vector& given, const Vector& moment) {
    sum.force += force_on_whole(s, geometry::array(given));
    sum.moment += moment_on_whole(s, geometry::array(moment));
  };
  for (std::size_t i = 0; i < restrained.size(); ++i) {
    const JointWrench& of = wrenches[i];
    const unsigned bits = held[at(restrained[i])];
    Vector given, moment;
    for (std::size_t c = 0; c < 3; ++c) {
      const int k = static_cast<int>(c);
      if (bits >> c & 1u) given[k] = -of.force[c];
      if (bits >> (c + 3) & 1u) moment[k] = -of.moment[c];
    }
    add(row.reaction_sum, given, moment + cross(geometry::vector(of.centre), given));
    const int r = s.reactions.restraint_of[at(restrained[i])];
    if (r < 0) continue;
    Reaction& reaction = row.reactions[at(r)];
    add(reaction, given, moment + cross(geometry::vector(of.centre) - centre[at(r)] / count[at(r)], given));
    reaction.displacement += of.displacement / count[at(r)];
  }
}

}  // namespace quoin
