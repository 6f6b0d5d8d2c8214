// Control of a simulation from outside, between two steps.
#include "step/steer.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.h"
#include "step/block_motion.h"
#include "step/controls.h"
#include "step/results.h"
#include "step/stages.h"
#include "step/state.h"

namespace quoin {

using geometry::Vector;

namespace {

constexpr const char* kAxis[3] = {"x", "y", "z"};

Error refusal(const char* what, const std::string& body, std::size_t component, const char* reason) {
  return {Exit::bad_input, fmt::format("{}: the stage {} '{}' along {}; give None (NaN in C++) there, or another stage",
                                       what, reason, body, kAxis[component])};
}

// Throws unless prescribed components are given velocities, and free ones forces; NaN components pass.
void require_kind(const char* what, const std::string& body, const Vec3& value, bool of_prescribed,
                  const std::array<bool, 3>& prescribed) {
  for (std::size_t c = 0; c < 3; ++c) {
    if (std::isinf(value[c]))
      throw Error(Exit::bad_input, fmt::format("{}[{}] is {}: allowed: a finite number, or not a number for what stays",
                                               what, c, value[c]));
    if (std::isnan(value[c]) || prescribed[c] == of_prescribed) continue;
    throw refusal(what, body, c, of_prescribed ? "leaves free" : "holds or moves");
  }
}

// Adds the pressures on a block that a force of these components replaces. One on a face that is inclined to these and
// to others cannot go in part.
void add_replaced(Simulation::Impl& s, const std::string& name, int block, const Vec3& force,
                  std::vector<blocks::Pressure*>* replaced) {
  constexpr double kAlong = 1e-9;  // rounding of a normal
  for (blocks::Pressure& pressure : s.large_motion->actions.pressures) {
    if (pressure.block != block || pressure.value == 0.0) continue;
    const Vector normal = matrix(s.large_motion->assembly.blocks[at(block)].orientation) *
                          s.large_motion->blocks[block].shape->normals[at(pressure.face)];
    bool goes = false, stays = false;
    for (std::size_t c = 0; c < 3; ++c) {
      if (std::abs(normal[static_cast<int>(c)]) > kAlong) (std::isnan(force[c]) ? stays : goes) = true;
    }
    if (goes && stays)
      throw Error(Exit::bad_input, fmt::format("force: a pressure of the stage acts on an inclined face of '{}', and "
                                               "would go along some components and stay along others; give all three",
                                               name));
    if (goes) replaced->push_back(&pressure);
  }
}

Error no_such_body(const std::string& body, const std::vector<std::string>& names) {
  return {Exit::bad_input, fmt::format("body: nothing is called '{}' that can be moved or loaded; there are {}", body,
                                       names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", ")))};
}

std::vector<std::string> names_of(const Model& model) {
  std::vector<std::string> names;
  for (const Brick& brick : model.assembly.bricks) {
    if (!brick.body.empty() && std::find(names.begin(), names.end(), brick.body) == names.end())
      names.push_back(brick.body);
  }
  return names;
}

// Sets velocities, or forces, of the blocks of this name; NaN components keep theirs.
void steer_drives(Simulation::Impl& s, const char* what, const std::string& name, const Vec3& value, bool velocities) {
  const std::vector<int> steered = blocks_named(s, name, "body");
  if (steered.empty()) throw no_such_body(name, names_of(s.model));
  std::vector<blocks::Pressure*> replaced;
  for (const int block : steered) {
    const Drive* const drive = s.actions.drive_of(block);
    const bool fixed = !drive && is_fixed(s, block);
    std::array<bool, 3> prescribed{};
    for (std::size_t c = 0; c < 3; ++c) prescribed[c] = drive ? (drive->held >> c & 1) != 0 : fixed;
    require_kind(what, name, value, velocities, prescribed);
    if (!velocities && s.large_motion) add_replaced(s, name, block, value, &replaced);
  }
  for (const int block : steered) {
    Drive* drive = s.actions.drive_of(block);
    if (!drive)
      drive = &s.actions.drives.emplace_back(Drive{block, is_fixed(s, block) ? kAllPrescribed : std::uint8_t{0}});
    for (std::size_t k = 0; k < 3; ++k) {
      const int c = static_cast<int>(k);
      if (std::isnan(value[k])) continue;
      if (velocities) {
        drive->velocity_from[c] = drive->velocity_to[c] = value[k];
        drive->in_cycles = static_cast<std::uint8_t>(drive->in_cycles & ~(1 << c));
        drive->of_ground = static_cast<std::uint8_t>(drive->of_ground & ~(1 << c));
      } else {
        drive->force_from[c] = drive->force_to[c] = drive->force_now[c] = value[k];
      }
    }
    if (velocities) continue;
    for (std::size_t i = 0; s.large_motion && i < s.large_motion->actions.loads.size(); ++i) {
      blocks::Load& load = s.large_motion->actions.loads[i];
      for (std::size_t c = 0; c < 3; ++c) {
        if (load.block == block && !std::isnan(value[c])) load.force[static_cast<int>(c)] = 0.0;
      }
    }
    apply_force(s, block, drive->force_to, drive->moment_now);
  }
  for (blocks::Pressure* pressure : replaced) pressure->value = 0.0;
  s.controls.settled = false;  // the next step applies the drives
  find_bodies_at_rest(s);
  s.small_motion.next_check = s.progress.step;
}

// The next stage begins with its own drives and loads, which would replace those set after the end of a stage.
void require_stage(Simulation::Impl& s, const char* what) {
  if (s.progress.stage < 0) return begin_stage(s, 0);
  if (s.progress.in_stage) return;
  const auto stage = s.progress.at_stage();
  const bool last = stage + 1 == s.scene.stages.size();
  throw Error(Exit::bad_input,
              fmt::format("{}: stage '{}' has ended, and {}", what, s.scene.stages[stage].name,
                          last ? "no other one follows"
                               : fmt::format("'{}' would begin without it; take a step of that first, as step(1)",
                                             s.scene.stages[stage + 1].name)));
}

// Three consecutive doubles a row, as in vectors of blocks in large motion.
ArrayView view_of(Vector* first, std::size_t rows) { return {&first->x, rows, 3, 3, 1}; }

}  // namespace

void set_velocity(Simulation::Impl& s, const std::string& body, const Vec3& velocity) {
  require_stage(s, "velocity");
  steer_drives(s, "velocity", body, velocity, true);
}

void set_force(Simulation::Impl& s, const std::string& body, const Vec3& force) {
  require_stage(s, "force");
  steer_drives(s, "force", body, force, false);
}

LawSwap exchange_law(Simulation::Impl& s, const std::string& family, const std::string& law) {
  const auto& families = s.model.assembly.families;
  if (std::none_of(families.begin(), families.end(), [&](const JointFamily& f) { return f.name == family; })) {
    std::vector<std::string> names;
    for (const JointFamily& f : families) names.push_back(f.name);
    throw Error(Exit::bad_input,
                fmt::format("joint: there is no joint family '{}'; there are {}", family, fmt::join(names, ", ")));
  }
  if (s.progress.stage < 0) begin_stage(s, 0);
  swap_law(s, family, law);
  s.watch.pending = false;  // the jump of the stored energy is no part of the energy balance of two steps
  s.scene.stages[s.progress.at_stage()].law_swaps[family] = law;  // for later checkpoints
  return s.laws.swaps.back();
}

ArrayView view(Simulation::Impl& s, BlockArray what, int block) {
  if (s.large_motion) {
    if (what == BlockArray::displacement) return {};
    const blocks::ModelBlock& b = s.large_motion->blocks[block];
    if (b.body >= 0) return view_of(&body_of(*s.large_motion, block).v, 1);
    change_node_velocities(*s.large_motion);
    s.large_motion->velocities_lent = true;
    return view_of(s.large_motion->nodes.v.data() + b.first_node, at(b.node_count));
  }
  const Model::BlockPlace& place = s.model.place[at(block)];
  if (place.body >= 0) {
    const auto [index, lane] = s.lattice.place[at(place.body)];
    BodyLanes& lanes = s.lattice.bodies[at(index)];
    BodyLanes::Quantity& quantity = what == BlockArray::displacement ? lanes.displacement : lanes.velocity;
    return {&quantity[0][lane], 1, 3, 1, kLanes};
  }
  const BlockGroup& group = s.model.groups[at(place.group)];
  LaneVector<double>& values = what == BlockArray::displacement ? s.lattice.displacement : s.lattice.velocity;
  return {values.data() + at(group.first_line) * kLine + at(place.lane),
          s.model.templates[at(group.brick_template)].node_mass.size(), 3, kLine, kLanes};
}

ArrayView view(Simulation::Impl& s, PointArray what, int family) {
  const auto k = static_cast<std::size_t>(what);
  if (s.large_motion) {
    auto& f = const_cast<blocks::Family&>(s.large_motion->contacts.families[at(family)]);
    if (what == PointArray::position) return {nullptr, f.size(), 3};
    return {what == PointArray::area ? f.area.data() : f.traction[k].data(), f.size()};
  }
  const ContactFamily& f = s.model.families[at(family)];
  const std::size_t first = at(f.first_point), count = at(f.point_count);
  if (what == PointArray::area) return {s.model.area.data() + first, count};
  if (what == PointArray::position)
    return {count == 0 ? nullptr : s.model.point_position[first].data(), count, 3, 3, 1};
  return {s.lattice.traction[k].data() + first, count};
}

ArrayView view_state(Simulation::Impl& s, int family, const std::string& id) {
  const Law& law = s.model.families[at(family)].material->law();
  const int k = law.state_index(id);
  if (k < 0 || !keeps_state(s, *law.law, at(k))) {
    std::vector<std::string> ids;
    for (std::uint64_t i = 0; i < law.law->state_count; ++i) {
      if (keeps_state(s, *law.law, i)) ids.push_back(law.law->states[i]->id);
    }
    throw Error(Exit::bad_input, fmt::format("state: law {} keeps no state '{}' here; it keeps: {}", law.law->id, id,
                                             ids.empty() ? "none" : fmt::format("{}", fmt::join(ids, ", "))));
  }
  return {const_cast<double*>(state_column(s, family, at(k))), at(points_of_family(s, family))};
}

void velocities_changed(Simulation::Impl& s) { find_bodies_at_rest(s); }

}  // namespace quoin
