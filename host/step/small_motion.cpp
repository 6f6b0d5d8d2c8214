// Whether a run may go on in small displacements: when that is checked, and what follows.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "scene/from_bricks.h"
#include "scene/generate_blocks.h"
#include "step/large_motion.h"
#include "step/state.h"
#include "step/time_for.h"

namespace quoin {

namespace {

constexpr long kMostSteps = 1000;  // between two looks at how far blocks have moved

double norm_of(const Vec3& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

}  // namespace

// Lattice blocks by their corner gridpoints, rigid bodies by their own rotation.
WholeMotion Simulation::Impl::whole_motion_of(std::size_t brick) const {
  const Model::BlockPlace& where = model.place[brick];
  const double radius = 0.5 * norm_of(model.assembly.bricks[brick].size);
  const int ground = ground_body();
  // What is prescribed is known to all ranks.
  const Vec3 of_ground = ground >= 0 ? of_body(ground, &BodyLanes::prescribed_velocity) : Vec3{};
  const auto speed = [&](Vec3 linear, const Vec3& spin) {
    for (std::size_t c = 0; c < 3; ++c) linear[c] -= of_ground[c];
    return norm_of(linear) + radius * norm_of(spin);
  };
  if (where.body >= 0)
    return {of_body(where.body, &BodyLanes::displacement), of_body(where.body, &BodyLanes::rotation),
            speed(of_body(where.body, &BodyLanes::velocity), of_body(where.body, &BodyLanes::spin))};
  const BlockGroup& group = model.groups[static_cast<std::size_t>(where.group)];
  const BrickTemplate& shape = model.templates[static_cast<std::size_t>(group.brick_template)];
  std::array<Vec3, 8> moved, rate;
  for (int k = 0; k < 8; ++k) {
    const int node =
        shape.node_index(k & 1 ? shape.zones[0] : 0, k & 2 ? shape.zones[1] : 0, k & 4 ? shape.zones[2] : 0);
    const std::size_t at =
        static_cast<std::size_t>(group.first_line + node) * kLine + static_cast<std::size_t>(where.lane);
    for (std::size_t c = 0; c < 3; ++c) {
      moved[static_cast<std::size_t>(k)][c] = displacement[at + c * kLanes];
      rate[static_cast<std::size_t>(k)][c] = velocity[at + c * kLanes];
    }
  }
  WholeMotion motion = whole_motion(shape.size, moved);
  const WholeMotion of_rate = whole_motion(shape.size, rate);
  motion.speed = speed(of_rate.translation, of_rate.rotation);
  return motion;
}

// By the rules of the scene, where its blocks were given as such; of walls and buildings joints without mortar have
// none.
bool Simulation::Impl::have_contact(int a, int b, int axis) {
  if (!meeting_family) {
    if (scene.blocks)
      meeting_family = blocks::assemble(scene).family_of;
    else
      meeting_family = blocks::from_bricks(model.assembly).family_of;
  }
  geometry::Vector normal;
  normal[axis] = 1.0;
  const auto origin = [&](int block) -> const Vec3& {
    return model.assembly.bricks[static_cast<std::size_t>(block)].origin;
  };
  const auto c = static_cast<std::size_t>(axis);
  if (origin(a)[c] > origin(b)[c]) std::swap(a, b);
  return !meeting_family || meeting_family({a, b, normal}) >= 0;
}

void Simulation::Impl::check_motion() {
  if (has_all()) {  // else gathered: each rank computes those of its own blocks
    whole_motions.resize(model.assembly.bricks.size());
    for (std::size_t i = 0; i < whole_motions.size(); ++i) whole_motions[i] = whole_motion_of(i);
  }
  // Against the ground: what moves along with it has not moved.
  std::vector<WholeMotion> motions = whole_motions;
  if (const int ground = ground_body(); ground >= 0) {
    const Vec3 moved =
        whole_motions[static_cast<std::size_t>(model.bodies[static_cast<std::size_t>(ground)].block)].translation;
    for (WholeMotion& m : motions) {
      for (std::size_t c = 0; c < 3; ++c) m.translation[c] -= moved[c];
    }
  }
  joint_sliding.look(motions, &motion_seen);
  next_motion_check = step_count + kMostSteps;
  if (!past_motion_bound().empty()) return;
  const MotionBound& bound = scene.solver.motion_bound;
  const double until_near = unjoined.look(
      motions, bound.sliding, [this](int a, int b, int axis) { return have_contact(a, b, axis); }, &motion_seen);
  // Half of what is left of the way to a bound, even if two blocks go against each other. It is a sixteenth of all of
  // it at least.
  double least = std::numeric_limits<double>::infinity(), fastest = 0.0;
  for (const Brick& brick : model.assembly.bricks)
    least = std::min(least, *std::min_element(brick.size.begin(), brick.size.end()));
  for (const WholeMotion& m : whole_motions) fastest = std::max(fastest, m.speed);
  const double used = std::max(motion_seen.rotation / bound.rotation, motion_seen.sliding / bound.sliding);
  const double way = std::max(0.5 * (1.0 - used), 0.0625) * least * std::min(bound.rotation, bound.sliding);
  const double steps = std::min(until_near, time_for(way, 2.0 * fastest)) / data.time_step;
  next_motion_check =
      step_count + (steps < static_cast<double>(kMostSteps) ? std::max(1L, static_cast<long>(steps)) : kMostSteps);
}

std::string Simulation::Impl::past_motion_bound() const {
  if (!large_motion) return past_bound(motion_seen, scene.solver.motion_bound, model.assembly);
  // Blocks of any shape leave small displacements by themselves.
  if (scene.solver.large_motion != LargeMotion::never || large_motion->is_small) return "";
  return "blocks have moved further than small displacements allow (contact.small_displacement)";
}

bool Simulation::Impl::follow_motion(bool stage_ends, std::vector<Warning>* warnings) {
  if (!large_motion) {
    if (step_count < next_motion_check && !stage_ends) return false;
    gather(Part::row);
    const auto before = Clock::now();
    check_motion();
    times[Phase::watch] += seconds_since(before);
  }
  const std::string past = past_motion_bound();
  if (past.empty()) return false;
  const SolverSettings& solver = scene.solver;
  if (solver.large_motion == LargeMotion::never) {
    warn_once("small_displacements",
              past +
                  ". The curve may be off by more than 1 % from here on; solver.large_motion = \"always\" follows "
                  "large motion",
              warnings);
    if (solver.motion_bound.stop)
      throw Error(Exit::numerical,
                  fmt::format("step {} of stage '{}': {}. Choose solver.large_motion = \"always\", a shorter stage, or "
                              "solver.past_motion_bound = \"warn\" to go on all the same",
                              stage_step, scene.stages[static_cast<std::size_t>(stage)].name, past));
  }
  if (large_motion || outcome.promotion || solver.large_motion != LargeMotion::automatic) return false;
  gather(Part::all);
  promote(past);
  return true;
}

bool Simulation::Impl::was_warned(const char* about) const {
  return std::any_of(outcome.warnings.begin(), outcome.warnings.end(),
                     [&](const Warning& w) { return w.about == about; });
}

void Simulation::Impl::warn_once(const char* about, const std::string& text, std::vector<Warning>* warnings) {
  if (was_warned(about)) return;
  outcome.warnings.push_back({about, text, stage, step_count, now()});
  warnings->push_back(outcome.warnings.back());
}

}  // namespace quoin
