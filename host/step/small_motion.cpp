#include "step/small_motion.h"

#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <span>

#include "base/error.h"
#include "base/upright_axis.h"
#include "scene/brick_overlap.h"
#include "scene/from_bricks.h"
#include "scene/generate_blocks.h"
#include "step/actions/ground.h"
#include "step/findings.h"
#include "step/gather.h"
#include "step/lattice_motion.h"
#include "step/motion_bound.h"
#include "step/promotion.h"
#include "step/stages.h"
#include "step/state.h"

namespace quoin {

namespace {

// Whether two blocks that meet across this axis have contact. Scenes of blocks have rules; in walls and buildings
// joints without mortar have no contact.
bool have_contact(Simulation::Impl& s, int a, int b, int axis) {
  if (!s.small_motion.meeting_family) {
    if (s.scene.blocks)
      s.small_motion.meeting_family = blocks::assemble(s.scene).family_of;
    else
      s.small_motion.meeting_family = [family =
                                           blocks::FamilyOfBricks(s.model.assembly)](const blocks::Meeting& meeting) {
        return family(meeting.block_a, meeting.block_b);
      };
  }
  geometry::Vector normal;
  normal[axis] = 1.0;
  const auto origin = [&](int block) -> const Vec3& { return s.model.assembly.bricks[at(block)].origin; };
  const auto c = at(axis);
  if (origin(a)[c] > origin(b)[c]) std::swap(a, b);
  return !s.small_motion.meeting_family || s.small_motion.meeting_family({a, b, normal}) >= 0;
}

constexpr long kMostSteps = 1000;  // between two checks of how far blocks have moved

// Acceleration that checks assume, m/s2: usual of blocks that joints, weight and earthquakes move, or that of the
// stage's motions where it is larger.
double most_acceleration(const Simulation::Impl& s) {
  constexpr double kUsual = 20.0;           // m/s2
  constexpr double kSteepest = 15.0 / 8.0;  // largest rate of smooth_step
  double most = kUsual;
  if (s.progress.stage < 0) return most;
  const Stage& settings = current_stage(s);
  const bool ramps = stage_time(s) < settings.ramp_time;
  for (const Drive& d : ramps ? std::span(s.actions.drives) : std::span<const Drive>()) {
    const double change = norm(d.velocity_to - d.velocity_from) +
                          0.5 * norm_of(s.model.assembly.bricks[at(d.block)].size) * norm(d.omega_to - d.omega_from);
    most = std::max(most, kSteepest * change / settings.ramp_time);
  }
  if (settings.cycles)
    most = std::max(most, kSteepest * std::abs(settings.cycles->velocity) / settings.cycles->ramp_time);
  const auto look = [&](const GroundMotion& ground) {
    for (const GroundMotion::Component& c : ground.components)
      for (const double value : c.acceleration.value) most = std::max(most, std::abs(value));
  };
  if (settings.ground) {
    look(*settings.ground);
    std::ranges::for_each(settings.ground->supports, look);
  }
  return most;
}

// Checks the motion of blocks, and plans the next check. Neither depends on outputs.
void check_motion(Simulation::Impl& s) {
  if (has_all(s)) {  // else they are gathered: each rank computes those of its own blocks
    s.small_motion.whole_motions.resize(s.model.assembly.bricks.size());
    for (std::size_t i = 0; i < s.small_motion.whole_motions.size(); ++i)
      s.small_motion.whole_motions[i] = whole_motion_of(s, i);
  }
  // Relative to the ground: blocks that move with it have not moved.
  std::vector<WholeMotion> motions = s.small_motion.whole_motions;
  if (const int ground = ground_block(s); ground >= 0) {
    const Vec3 moved = s.small_motion.whole_motions[at(ground)].translation;
    for (WholeMotion& m : motions) m.translation -= moved;
  }
  s.small_motion.joint_sliding.look(motions, &s.small_motion.seen, upright_axis(s.data.gravity));
  s.small_motion.next_check = s.progress.step + kMostSteps;
  if (!past_motion_bound(s).empty()) return;
  const MotionBound& bound = s.scene.solver.motion_bound;
  const double acceleration = most_acceleration(s);
  const double until_near = s.small_motion.unjoined.look(
      motions, bound.sliding, acceleration, [&s](int a, int b, int axis) { return have_contact(s, a, b, axis); },
      &s.small_motion.seen);
  // Half of the remaining way to a bound, even if two blocks approach each other, but at least a sixteenth of the whole
  // way.
  double least = std::numeric_limits<double>::infinity(), fastest = 0.0;
  for (const Brick& brick : s.model.assembly.bricks) least = std::min(least, least_extent(brick));
  for (const WholeMotion& m : s.small_motion.whole_motions) fastest = std::max(fastest, m.speed);
  const double used =
      std::max({s.small_motion.seen.rotation / bound.rotation, s.small_motion.seen.sliding / bound.sliding,
                s.small_motion.seen.sway / (kSwayOverRotation * bound.rotation)});
  const double way = std::max(0.5 * (1.0 - used), 0.0625) * least * std::min(bound.rotation, bound.sliding);
  const double steps = std::min(until_near, time_for(way, 2.0 * fastest, acceleration)) / s.data.time_step;
  s.small_motion.next_check =
      s.progress.step + (steps < static_cast<double>(kMostSteps) ? std::max(1L, static_cast<long>(steps)) : kMostSteps);
}

}  // namespace

std::string past_motion_bound(const Simulation::Impl& s) {
  if (!s.large_motion) return past_bound(s.small_motion.seen, s.scene.solver.motion_bound, s.model.assembly);
  // A model of blocks in large motion leaves small displacements by itself, without a promotion.
  if (s.scene.solver.large_motion != LargeMotion::never || s.large_motion->is_small) return "";
  return "blocks have moved further than small displacements allow (contact.small_displacement)";
}

bool follow_motion(Simulation::Impl& s, bool stage_ends, std::vector<Warning>* warnings) {
  if (!s.large_motion) {
    if (s.progress.step < s.small_motion.next_check && !stage_ends) return false;
    gather(s, Part::row);
    const auto before = Clock::now();
    check_motion(s);
    s.timing.phases[Phase::watch] += seconds_since(before);
  }
  const std::string past = past_motion_bound(s);
  if (past.empty()) return false;
  const SolverSettings& solver = s.scene.solver;
  if (solver.large_motion == LargeMotion::never) {
    warn_once(s, "small_displacements",
              past +
                  ". The curve may be off by more than 1 % from here on; solver.large_motion = \"always\" follows "
                  "large motion",
              warnings);
    if (solver.motion_bound.stop)
      throw Error(
          Exit::numerical,
          fmt::format("step {} of stage '{}': {}. Choose {}", s.progress.stage_step, current_stage(s).name, past,
                      s.large_motion ? "a shorter stage, or leave out "
                                       "solver.large_motion = \"never\": large motion then follows"
                                     : "solver.large_motion = \"always\", a shorter stage, or "
                                       "solver.past_motion_bound = \"warn\" to go on all the same"));
  }
  if (s.large_motion || s.outcome.promotion || solver.large_motion != LargeMotion::automatic) return false;
  gather(s, Part::all);
  promote(s, past, s.progress.stage);
  return true;
}

void warn_of_unused_bounds(Simulation::Impl& s, std::vector<Warning>* warnings) {
  const MotionBound &bound = s.scene.solver.motion_bound, usual;
  const char* const given = bound.rotation != usual.rotation ? "rotation_bound"
                            : bound.sliding != usual.sliding ? "sliding_bound"
                                                             : nullptr;
  if (!given || !s.large_motion || s.outcome.promotion) return;
  warn_once(s, "motion_bound",
            fmt::format("solver.{} has no effect: it bounds small displacements on the lattice, and these blocks are "
                        "in the general kernels from the start; remove it",
                        given),
            warnings);
}

bool was_warned(const Simulation::Impl& s, const char* about) {
  return std::any_of(s.outcome.warnings.begin(), s.outcome.warnings.end(),
                     [&](const Warning& w) { return w.about == about; });
}

void warn_once(Simulation::Impl& s, const char* about, const std::string& text, std::vector<Warning>* warnings) {
  if (was_warned(s, about)) return;
  s.outcome.warnings.push_back({about, text, s.progress.stage, s.progress.step, time_now(s)});
  warnings->push_back(s.outcome.warnings.back());
}

}  // namespace quoin
