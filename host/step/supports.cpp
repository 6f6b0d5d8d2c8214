#include "step/supports.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "base/error.h"
#include "base/joined_items.h"
#include "members/members.h"
#include "model/world_results.h"
#include "scene/driven.h"
#include "step/actions/ground.h"
#include "step/block_motion.h"
#include "step/findings.h"
#include "step/small_motion.h"
#include "step/stages.h"
#include "step/state.h"

namespace quoin {

namespace {

std::uint8_t imposed_by(const BodyControl& control) { return static_cast<std::uint8_t>(prescribed_by(control) & 7u); }

// Held components by block; bits 0..2: x, y, z.
std::vector<std::uint8_t> held_in(const Simulation::Impl& s, const Stage& settings) {
  std::vector<std::uint8_t> held;
  for (int block = 0; block < block_count(s); ++block) held.push_back(is_fixed(s, block) ? 7 : 0);
  for (const BodyControl& control : settings.controls) {
    for (const int block : blocks_named(s, control.body, settings.source.text)) held[at(block)] = imposed_by(control);
  }
  return held;
}

// First block of the group of joined blocks, by block.
std::vector<int> groups_of_joined_blocks(const Simulation::Impl& s) {
  JoinedItems joined(at(block_count(s)));
  const auto join = [&](int a, int b) { joined.join(a, b); };
  for (const Joint& j : s.model.assembly.joints) join(j.block_a, j.block_b);
  for (std::size_t i = 0; s.large_motion && i < s.large_motion->contacts.list.size(); ++i) {
    const blocks::Contact& c = s.large_motion->contacts.list[i];
    if (c.count > 0) join(c.pair.a, c.pair.b);
  }
  const members::Members* const members = members_of(s);
  if (members) members->each_joint(join);
  std::vector<int> first;
  for (int i = 0; i < block_count(s); ++i) first.push_back(joined.first_of(i));
  return first;
}

std::vector<int> loose_blocks(const Simulation::Impl& s, const Stage& settings) {
  const std::vector<std::uint8_t> held = held_in(s, settings);
  const std::vector<int> group = groups_of_joined_blocks(s);
  unsigned along = 0;
  for (unsigned c = 0; c < 3; ++c) along |= settings.gravity[c] != 0.0 ? 1u << c : 0u;
  std::map<int, unsigned> imposed;
  for (std::size_t i = 0; i < held.size(); ++i) imposed[group[i]] |= held[i];
  for (const members::Bed& bed : beds_of(s)) {
    for (const members::SpringPoint& p : bed.points)
      imposed[group[at(members_of(s)->nodes()[at(p.node)].block)]] |= along;
  }
  std::vector<int> loose;
  for (std::size_t i = 0; i < held.size(); ++i) {
    if ((imposed[group[i]] & along) != along) loose.push_back(static_cast<int>(i));
  }
  return loose;
}

// Whether only equilibrium, or the limit of steps, can end the stage; in free fall there is no equilibrium.
bool ends_at_rest_alone(const Stage& stage) {
  return stage.equilibrium_ratio && !stage.duration && !stage.displacement && !stage.collapse;
}

constexpr std::size_t kNamed = 5;  // most blocks that a message names

}  // namespace

void require_moving_ground(const Simulation::Impl& s) {
  if (!beds_of(s).empty()) return;
  std::vector<std::size_t> fixed;
  for (int block = 0; block < block_count(s); ++block)
    if (is_fixed(s, block)) fixed.push_back(at(block));
  for (const Stage& each : s.scene.stages) {
    if (!each.ground) continue;
    const auto refuse = [&](const char* why) {
      throw Error(Exit::bad_input,
                  fmt::format("{}: stage '{}' has ground_motion, {}", each.source.text, each.name, why));
    };
    if (fixed.empty())
      refuse("which moves the fixed blocks, and none is fixed; give the ground fixed = true, a wall its bottom_beam");
    const std::vector<std::int32_t> group = support_groups(s, each);
    const bool moves = std::ranges::any_of(each.ground->components, [](const GroundMotion::Component& c) {
      return std::ranges::any_of(c.acceleration.value, [](double value) { return value != 0.0; });
    });
    if (moves && std::ranges::none_of(fixed, [&](std::size_t block) { return group[block] == 0; }))
      refuse("which moves nothing: all fixed blocks are in its supports; leave the motion of the ground itself out");
  }
}

// Warns where all blocks are loose. Single loose blocks are no error: they may fall onto others. `quoin check` names
// them.
void warn_of_loose_blocks(Simulation::Impl& s, std::vector<Warning>* warnings) {
  const Stage& settings = current_stage(s);
  s.small_motion.held_blocks = held_in(s, settings);
  if (settings.gravity == Vec3{} || loose_blocks(s, settings).size() < s.small_motion.held_blocks.size()) return;
  warn_once(
      s, "free_fall",
      fmt::format("stage '{}' holds nothing against gravity: all blocks fall freely; give a block fixed = true, or "
                  "a body of the stage a velocity (0 holds it)",
                  settings.name),
      warnings);
}

// A block has left all supports where it has moved farther than any of them by more than the diagonal of the model.
void find_falling_block(Simulation::Impl& s, std::vector<Warning>* warnings) {
  const Stage& settings = current_stage(s);
  if (s.small_motion.held_blocks.empty()) s.small_motion.held_blocks = held_in(s, settings);
  const auto way_of = [&](std::size_t i) {
    geometry::Vector way;
    if (s.large_motion)
      way = moved(*s.large_motion, static_cast<int>(i));
    else if (i < s.small_motion.whole_motions.size())
      way = geometry::vector(s.small_motion.whole_motions[i].translation);
    const unsigned held = s.small_motion.held_blocks[i];
    for (unsigned c = 0; held != 7 && c < 3; ++c) {
      if ((held >> c & 1u) != 0) way[c] = 0.0;  // the stage moves the block that way
    }
    return norm(way);
  };
  // Springs to the ground are supports that have moved with it.
  double of_supports = beds_of(s).empty() ? 0.0 : norm(members_of(s)->ground()), farthest = 0.0;
  int falling = -1;
  for (std::size_t i = 0; i < s.small_motion.held_blocks.size(); ++i) {
    const bool supports = s.small_motion.held_blocks[i] == 7;  // a beam that is held along the wall may fall, too
    double& largest = supports ? of_supports : farthest;
    const double way = way_of(i);
    if (way <= largest) continue;
    largest = way;
    if (!supports) falling = static_cast<int>(i);
  }
  if (falling < 0 || farthest <= of_supports + s.small_motion.extent) return;
  const std::string what =
      fmt::format("block {} has moved by {:.3g} m, farther than the model is large ({:.3g} m): nothing holds it",
                  block_label(s, falling), farthest, s.small_motion.extent);
  warn_once(s, "free_fall", what + "; quoin check lists what holds blocks in each stage", warnings);
  if (!ends_at_rest_alone(settings)) return;
  throw Error(
      Exit::numerical,
      fmt::format("stage '{}' ends when all is at rest, and cannot: {}. Give a block below fixed = true, hold a "
                  "body by velocity = 0, or give the stage a duration. Where joints have failed under a load that they "
                  "carry at rest, give a longer ramp_time",
                  settings.name, what));
}

std::string block_label(const Simulation::Impl& s, int block) {
  if (s.large_motion) return blocks::label(s.large_motion->assembly, block);
  const Brick& brick = s.model.assembly.bricks[at(block)];
  const std::string& name = brick.body.empty() ? brick.name : brick.body;
  return name.empty() ? fmt::format("#{}", block) : fmt::format("#{} '{}'", block, name);
}

Supports supports_in(const Simulation::Impl& s, int stage) {
  const Stage& settings = s.scene.stages[at(stage)];
  Supports supports;
  std::map<unsigned, std::vector<std::string>> names;  // by held components
  const std::vector<std::uint8_t> held = held_in(s, settings);
  for (std::size_t i = 0; i < held.size(); ++i) {
    if (held[i] == 0) continue;
    std::vector<std::string>& with_axes = names[held[i]];
    std::string name = name_in_stages(s, static_cast<int>(i));
    if (name.empty()) name = block_label(s, static_cast<int>(i));
    if (with_axes.empty() || with_axes.back() != name) with_axes.push_back(std::move(name));
  }
  for (auto& [bits, with_axes] : names) {
    const std::size_t more = with_axes.size() > kNamed ? with_axes.size() - kNamed : 0;
    with_axes.resize(with_axes.size() - more);
    std::string axes;
    for (unsigned c = 0; c < 3; ++c) axes += (bits >> c & 1u) != 0 ? std::string(" ") + "xyz"[c] : "";
    supports.held.push_back(
        fmt::format("{}{}:{}", fmt::join(with_axes, ", "), more > 0 ? fmt::format(" and {} more", more) : "", axes));
  }
  if (settings.gravity != Vec3{}) supports.loose = loose_blocks(s, settings);
  return supports;
}

}  // namespace quoin
