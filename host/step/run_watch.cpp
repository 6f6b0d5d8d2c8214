#include "step/run_watch.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "law/answers.h"
#include "members/members.h"
#include "model/world_results.h"
#include "scene/brick_overlap.h"
#include "scene/damping_text.h"
#include "scene/load_place.h"
#include "scene/stage_warnings.h"
#include "step/block_motion.h"
#include "step/borders.h"
#include "step/corner_bending.h"
#include "step/findings.h"
#include "step/gather.h"
#include "step/points_at_rest.h"
#include "step/rank_agreement.h"
#include "step/results.h"
#include "step/small_motion.h"
#include "step/stages.h"
#include "step/state.h"
#include "step/work_division.h"

namespace quoin {

using geometry::Vector;

namespace {

std::array<long, kConditionCount> conditions_now(Simulation::Impl& s) {
  return s.parts.divided && !has_all(s) ? conditions_of_all(s) : conditions_here(s);
}

void check_points(Simulation::Impl& s) {
  const auto see = [&](double opening, const auto& place) {
    if (!(-opening > s.watch.overlap)) return;
    s.watch.overlap = -opening;
    s.watch.overlap_at = place();
  };
  long crushed_out = 0;
  for (int c = 0; s.large_motion && c < s.large_motion->chunk_count(); ++c) {
    const blocks::Deepest deepest = deepest_of_chunk(*s.large_motion, c);
    see(deepest.opening, [&] { return geometry::array(deepest.at); });
  }
  if (!s.large_motion) {
    for (const ChunkSums& sums : s.contacts.sums) {
      see(sums.deepest, [&] { return s.model.point_position[static_cast<std::size_t>(sums.deepest_point)]; });
      crushed_out += sums.crushed_out;
    }
  }
  s.watch.crushed_out = std::max(s.watch.crushed_out, crushed_out);
}

// Compares tangents with the stiffness bounds of the laws, from which the time step follows.
void check_stiffness(Simulation::Impl& s) {
  LaneVector<double> normal(contact_point_count(s), 0.0), shear[2]{normal, normal};
  evaluate_points_at_rest(s, QUOIN_CAN_TANGENT, all_points(s), [&](quoin_batch& batch, std::size_t first) {
    batch.tangent[0] = {normal.data() + first, 1};
    batch.tangent[4] = {shear[0].data() + first, 1};
    batch.tangent[8] = {shear[1].data() + first, 1};
  });
  std::size_t point = 0;
  // family_normal, family_shear: bounds for the largest properties of a family, where they scatter.
  const auto hold = [&](const Material& material, double family_normal, double family_shear, std::size_t count) {
    quoin_stiffness_bounds bounds = material.stiffness_bounds();
    bounds.normal = std::max(bounds.normal, family_normal), bounds.shear = std::max(bounds.shear, family_shear);
    const auto ratio = [&](double stiffness, double bound) {
      if (bound > 0.0) s.watch.stiffness_ratio = std::max(s.watch.stiffness_ratio, stiffness / bound);
    };
    for (const std::size_t end = point + count; point < end; ++point) {
      ratio(normal[point], bounds.normal);
      for (const auto& column : shear) ratio(column[point], bounds.shear);
    }
  };
  if (s.large_motion) {
    for (const blocks::Family& f : s.large_motion->contacts.families) hold(*f.material, f.kn, f.ks, f.size());
    const auto counts = conditions_now(s);
    s.watch.crushed_out = std::max(s.watch.crushed_out, counts[static_cast<std::size_t>(Condition::crushed_out)]);
  } else {
    for (const ContactFamily& family : s.model.families)
      hold(*family.material, family.normal_stiffness, family.shear_stiffness,
           static_cast<std::size_t>(family.point_count));
  }
}

// Warning of a block that falls, slides or topples under damping or with scaled inertia; empty: none. Such a block has
// moved by kMoved of its least extent, and is as fast as after a fall of kFall of it. Its forces are not balanced. All
// this holds in two passes one after the other.
std::string damped_motion(Simulation::Impl& s) {
  constexpr double kMoved = 0.02, kFall = 0.01, kUnbalanced = 0.05;  // shares of the least extent and of the weight
  const auto now_in = static_cast<std::size_t>(s.progress.stage);
  const std::string damping = damping_in_space(s.scene, now_in);
  const double scaling = s.scene.solver.mass_scaling;
  if (!s.large_motion || (damping.empty() && scaling == 1.0)) return "";
  const double weight = norm(geometry::vector(s.data.gravity)), g = weight > 0.0 ? weight : 9.81;
  std::vector<bool> driven;
  for (const blocks::Block& b : s.large_motion->assembly.blocks) driven.push_back(b.fixed);
  for (const Drive& drive : s.actions.drives) driven[static_cast<std::size_t>(drive.block)] = (drive.held & 7) != 0;
  double most = 1.0, block = -1.0;
  for (int i = 0; i < s.large_motion->block_count(); ++i) {
    if (!s.large_motion->part.owns(i) || driven[static_cast<std::size_t>(i)] ||
        !(norm(s.large_motion->step_sums.of_block[i].net) > kUnbalanced * g * s.large_motion->blocks[i].mass))
      continue;
    const Vector v = velocity_of(*s.large_motion, i);
    const double extent = s.large_motion->blocks[i].least_extent;
    const double fall = scaling * dot(v, v) / (2.0 * g * kFall * extent);
    if (fall > most && norm(moved_by_now(*s.large_motion, i)) > kMoved * extent) most = fall, block = i;
  }
  if (s.parts.divided) block = largest_of_ranks(s, most == largest_of_ranks(s, most) ? block : -1.0);
  const int number = static_cast<int>(block);
  if (std::exchange(s.watch.falling, number) != number || number < 0) return "";
  const Vector place = blocks::centre_of(s.large_motion->assembly, number);  // units of buildings have no names
  const std::string which = fmt::format("{} at ({:.3f}, {:.3f}, {:.3f}) m",
                                        blocks::label(s.large_motion->assembly, number), place.x, place.y, place.z);
  if (scaling != 1.0)
    return fmt::format(
        "block {} falls, slides or topples with {:g} times its inertia (solver.mass_scaling), so that its "
        "accelerations are that much smaller; take mass_scaling = 1 where blocks move",
        which, scaling);
  return fmt::format("block {} falls, slides or topples, and the {} of stage '{}' brakes it: {}; {}", which, damping,
                     s.scene.stages[now_in].name,
                     local_damping_in(s.scene, now_in) > 0.0
                         ? "what is not balanced moves it with 1 - gamma of the acceleration that it has without"
                         : "without it such motion is not braked",
                     kDampingForMotion);
}

// Warning of blocks that no joint of the start holds, and that pull each other before they touch; empty: none.
std::string pull_over_gaps(const Simulation::Impl& s) {
  constexpr double kSome = 1.0;  // Pa, above rounding
  if (!s.large_motion) return "";
  const blocks::Model& m = *s.large_motion;
  const bool found_at_start = m.detection.count <= 1;
  std::vector<double> of_family(m.contacts.families.size(), 0.0);
  for (std::size_t i = 0; i < m.contacts.list.size(); ++i) {
    const blocks::Contact& c = m.contacts.list[i];
    if (c.count == 0 || !m.part.owns(c.pair)) continue;
    const bool is_apart =
        !c.initial || (found_at_start && m.contacts.place[i].separation.distance > m.detection.joint_tolerance);
    for (std::size_t p = c.first; is_apart && p < c.first + c.count; ++p) {
      const auto f = static_cast<std::size_t>(c.family);
      of_family[f] = std::max(of_family[f], m.contacts.families[f].traction[0][p]);
    }
  }
  for (std::size_t f = 0; f < of_family.size(); ++f) {
    double most = of_family[f];
    if (s.parts.divided) most = largest_of_ranks(s, most);
    if (most <= kSome) continue;
    return fmt::format(
        "joints '{}' pull blocks towards each other with {:.3g} Pa where no joint was at the start: the law has "
        "tension in a new contact, also over an open gap, and energy has no source there; take a law and properties "
        "without tension in its state dry, as coulomb_slip without tensile_strength_residual",
        m.assembly.families[f].name, most);
  }
  return "";
}

std::string motion_left_to_ground(const Simulation::Impl& s) {
  constexpr double kSlow = 1e-4;  // m/s
  const Stage& settings = current_stage(s);
  const bool fades = settings.ramp_time > 0.0;
  const auto stages = std::span(s.scene.stages).first(s.progress.at_stage());
  const bool was_shaken = std::ranges::any_of(stages, [](const Stage& stage) { return stage.ground.has_value(); });
  const auto was_of_ground = [&](int block) {
    if (!was_shaken || !is_fixed(s, block)) return false;
    const auto& controls = stages.back().controls;
    return std::ranges::find(controls, name_in_stages(s, block), &BodyControl::body) == controls.end();
  };
  double goes_on = norm(s.actions.ground_left), held = 0.0;  // m/s
  for (const Drive& drive : s.actions.drives) {
    if (drive.of_ground)
      goes_on = std::max(goes_on, norm(fades ? drive.velocity_from : drive.velocity_to));
    else if (was_of_ground(drive.block))
      held = std::max(held, norm(drive.velocity_from) - norm(drive.velocity_to));
  }
  if (settings.kind == "rest") held = 0.0;  // all comes to rest together
  if (std::max(goes_on, held) <= kSlow) return "";
  const bool brakes = held > kSlow || fades;
  const std::string then = fades ? fmt::format("comes to rest over its ramp_time of {:g} s", settings.ramp_time)
                           : held > kSlow
                               ? "what the stage holds of it stops at once"
                               : "goes on so, as the stage has no ramp_time over which it could come to rest";
  return fmt::format(
      "the ground still moves at {:.3g} m/s when stage '{}' begins, and {}{}", std::max(goes_on, held), settings.name,
      then, brakes ? ": that shakes what stands on it; after = \"rest\" in ground_motion stops it gently" : "");
}

// Energy below which a balance is rounding, J: a share of the weight times the least extent of a block.
double energy_of_rounding(const Simulation::Impl& s) {
  constexpr double kShare = 1e-9, kGravity = 9.81;  // m/s2
  return kShare * kGravity * s.time_step.model_mass * allowed_overlap(s) / Watch::kAllowedOverlap;
}

// Whether loads may have changed so recently that much of the energy is in vibrations of the highest frequencies. Their
// balance oscillates by (omega dt)^2/4.
bool is_just_loaded(const Simulation::Impl& s) {
  constexpr double kSpread = 20.0;  // of 2/omega_max; time after which a sudden load has spread over a block
  return stage_time(s) < kSpread * s.time_step.critical.value;
}

// Compares tangents and answers of the laws with what they state, each Watch::kStiffnessSteps.
std::optional<WrongAnswer> check_laws(Simulation::Impl& s) {
  if (s.progress.step < s.watch.next_stiffness) return std::nullopt;
  s.watch.next_stiffness = s.progress.step + Watch::kStiffnessSteps;
  if (s.parts.divided) {
    if (!s.large_motion) receive_whole_borders(s);
    check_stiffness(s);
    s.watch.stiffness_ratio = largest_of_ranks(s, s.watch.stiffness_ratio);
    if (any_rank(s, wrong_law(s).has_value())) gather(s, Part::all);  // then all ranks report the same point
  } else {
    gather(s, Part::all);
    check_stiffness(s);
  }
  return wrong_law(s);
}

// Where energies are written, their balance is that of the whole run; otherwise of the steps that check_energies saw.
void book_energy_balance(Simulation::Impl& s) {
  if (!s.energy.wanted || !s.energy.now || is_just_loaded(s) || !laws_give_energies(s)) return;
  const Energies& e = *s.energy.now;
  double moved =
      e.kinetic + e.strain + e.contact_stored + e.members_stored + e.members_dissipated + std::abs(e.damping);
  for (const double d : e.dissipated) moved += d;
  s.watch.energy_missing = e.balance_error();
  s.watch.energy_moved = std::max({s.watch.energy_moved, moved, std::abs(e.external)});
}

std::string deep_overlap(const Simulation::Impl& s) {
  if (!(s.watch.overlap > allowed_overlap(s))) return "";
  // That bound is of the smallest block of all. The blocks that overlap may be larger.
  double most = Watch::kAllowedOverlap;
  std::string text;
  for (const ContactPoint& p : contact_points(s, all_points(s), true)) {
    const double share = -p.jump[0] / std::min(least_extent(s, p.block_a), least_extent(s, p.block_b));
    if (!(share > most)) continue;
    most = share;
    text = fmt::format(
        "blocks overlap by {:.3g} mm at ({:.3f}, {:.3f}, {:.3f}) m, more than {:g} of the least extent of one of them: "
        "what they are there is no longer described; make the joints stiffer or stronger (normal_stiffness, "
        "compressive_strength, compressive_strength_residual), or read the results only until here",
        -p.jump[0] * 1e3, p.position[0], p.position[1], p.position[2], Watch::kAllowedOverlap);
  }
  return text;
}

std::string points_crushed_out(const Simulation::Impl& s) {
  if (s.watch.crushed_out == 0) return "";
  return fmt::format(
      "the first contact points ({}) are crushed out: they carry no more than the residual compressive strength, and "
      "blocks sink into each other there; where that matters, as in a collapse, give the joints a "
      "compressive_strength_residual > 0",
      s.watch.crushed_out);
}

bool presses_quickly(const Stage& stage) { return stage.kind == "pressure" && stage.ramp_time < Watch::kSlowRamp; }

long crushing_now(Simulation::Impl& s) {
  const auto counts = conditions_now(s);
  return counts[static_cast<std::size_t>(Condition::crushing)] +
         counts[static_cast<std::size_t>(Condition::crushed_out)];
}

// Warning at the end of a stage of pressure.
std::string crushed_in_ramp(Simulation::Impl& s) {
  const Stage& stage = current_stage(s);
  if (!presses_quickly(stage)) return "";
  const long crushing = crushing_now(s) - s.watch.crushing_before;
  if (crushing <= 0) return "";
  return fmt::format(
      "{} contact points have begun to crush in stage '{}': within its ramp_time of {:g} s the wall vibrates "
      "vertically, and joints carry up to some 30 % more than at rest; compare with ramp_time = {:g} or more, or with "
      "kind = \"rest\"",
      crushing, stage.name, stage.ramp_time, Watch::kSlowRamp);
}

// Warning of a stage that asks for equilibrium and ends without it, by its duration or otherwise.
std::string missed_equilibrium(const Simulation::Impl& s) {
  const Stage& stage = current_stage(s);
  const double ratio = s.progress.unbalanced_ratio;
  if (!stage.equilibrium_ratio || is_calm(s) || !(ratio > *stage.equilibrium_ratio)) return "";
  return fmt::format(
      "stage '{}' ends without the equilibrium that it asks for: the largest force that is not balanced is {:.3g} of "
      "the mean contact force (unbalanced_ratio), wanted {:g} (equilibrium_ratio): blocks still vibrate, slide or "
      "fall, and whether its loads are carried is open; see how far they have moved, and give it a longer duration",
      stage.name, ratio, *stage.equilibrium_ratio);
}

// Warning of forces that are not balanced at the end of a stage whose loads are constant at last. Eq. 1 slows what
// moves to a creep, in which a wall that fails can stand until the stage ends.
std::string creeping(const Simulation::Impl& s) {
  constexpr double kUnbalanced = 0.05;  // share of the mean contact force
  const double ratio = s.progress.unbalanced_ratio;
  if (!ends_by_duration(current_stage(s)) || !(ratio > kUnbalanced) || !std::isfinite(ratio) ||
      local_damping_in(s.scene, static_cast<std::size_t>(s.progress.stage)) == 0.0)
    return "";
  return fmt::format(
      "stage '{0}' ends while blocks still move: the largest force that is not balanced is {1:.3g} of the mean contact "
      "force (unbalanced_ratio), more than {2:g}, and local damping slows them; whether its loads are carried is open: "
      "give it equilibrium_ratio = 0.001 in place of its duration, or a longer duration",
      current_stage(s).name, ratio, kUnbalanced);
}

std::string turned_piece_of_beam(const Simulation::Impl& s) {
  const members::Members* const members = members_of(s);
  if (!members) return "";
  const auto beam = std::ranges::find_if(
      members->beams(), [](const members::Beam& b) { return !(b.largest_turn() <= Watch::kAllowedTurn); });
  if (beam == members->beams().end()) return "";
  return fmt::format(
      "a piece of beam '{}' is turned against its chord by more than {:g} rad, and rotations in a piece are taken as "
      "small: its moments lose or create energy; give smaller spacing, or more torsion where it buckles sideways",
      beam->name(), Watch::kAllowedTurn);
}

std::string uneven_floor(const Simulation::Impl& s) {
  const members::Members* const members = members_of(s);
  std::string all;
  for (std::size_t i = 0; members && i < members->floors().size(); ++i) {
    const std::string text = members->floors()[i].uneven_weight();
    all += (all.empty() || text.empty() ? "" : "; ") + text;
  }
  return all;
}

std::string beam_off_its_seat(const Simulation::Impl& s) {
  const members::Members* const members = members_of(s);
  if (!members) return "";
  for (const members::Beam& beam : members->beams()) {
    const members::Beam::Support* const support = beam.slid_off();
    if (!support) continue;
    const int block = members->nodes()[static_cast<std::size_t>(support->node)].block;
    return fmt::format(
        "beam '{}' has slid past the edge of block {} on which it rests, and is still carried there, as seats are not "
        "lost: read the results only until here",
        beam.name(), block_label(s, block));
  }
  return "";
}

std::string unbalanced_energies(const Simulation::Impl& s, bool stage_ends) {
  // The balance oscillates about 0 while little energy has been converted.
  const bool is_early = s.energy.wanted ? s.progress.step < Watch::kOutputSteps && !stage_ends
                                        : s.progress.step < 10 * Watch::kOutputSteps;
  // At rest no energy is moved but rounding.
  const double allowed = Watch::kAllowedMissing * std::max(s.watch.energy_moved, energy_of_rounding(s));
  if (is_early || std::abs(s.watch.energy_missing) <= allowed) return "";
  return fmt::format(
      "energies do not balance: {:+.3g} J of {:.3g} J that were moved{} have no source, {:.1f} %, allowed {:g} %; "
      "reduce solver.time_step_fraction, and see whether the law keeps the contract (quoin-check-law)",
      s.watch.energy_missing, s.watch.energy_moved, s.energy.wanted ? "" : " in the steps looked at",
      100 * s.watch.energy_missing / s.watch.energy_moved, 100 * Watch::kAllowedMissing);
}

std::string stiff_law(const Simulation::Impl& s) {
  if (!(s.watch.stiffness_ratio > Watch::kAllowedStiffness)) return "";
  const double fraction = s.data.time_step / s.time_step.critical.value;
  return fmt::format(
      "a law is {:.3g} times as stiff as the bounds that it states, from which the time step follows ({:g} of "
      "2/omega_max): set solver.time_step_fraction to {:.3g} at most, and tell the law's author",
      s.watch.stiffness_ratio, fraction, fraction / std::sqrt(s.watch.stiffness_ratio));
}

}  // namespace

void note_crushed(Simulation::Impl& s) {
  s.watch.crushing_before = presses_quickly(current_stage(s)) ? crushing_now(s) : 0;
}

bool begins_check(const Simulation::Impl& s) {
  return !s.energy.wanted && !s.watch.pending && s.progress.step >= s.watch.next_energies && !is_just_loaded(s) &&
         laws_give_energies(s);
}

bool laws_give_energies(const Simulation::Impl& s) {
  return std::all_of(s.model.families.begin(), s.model.families.end(), [](const ContactFamily& family) {
    return (family.material->api().capabilities & QUOIN_CAN_ENERGY) != 0;
  });
}

void end_check(Simulation::Impl& s) {
  s.watch.pending = false;
  if (s.large_motion && !s.energy.wanted) s.large_motion->book_energy(false);
}

void check_energies(Simulation::Impl& s, const Energies& now, double dissipated, double work_before,
                    double work_after) {
  const double kinds[3] = {now.kinetic, now.strain, now.contact_stored};
  const double stored = now.kinetic + now.strain + now.contact_stored;
  if (s.watch.pending) {
    const double work = s.watch.work_after + work_before;
    double moved = std::abs(work) + std::abs(dissipated);
    for (std::size_t k = 0; k < 3; ++k) moved += std::abs(kinds[k] - s.watch.kinds[k]);
    s.watch.energy_missing += stored - s.watch.stored + dissipated - work;
    s.watch.energy_moved += 0.5 * moved;  // each conversion is counted at its source and at its target
    s.watch.pending = false;
    return;
  }
  std::copy_n(kinds, 3, s.watch.kinds);
  s.watch.stored = stored, s.watch.work_after = work_after;
  s.watch.pending = true;
  s.watch.next_energies = Watch::after(s.progress.step);
}

double least_extent(const Simulation::Impl& s, int block) {
  const auto b = static_cast<std::size_t>(block);
  return s.large_motion ? s.large_motion->blocks[b].least_extent : least_extent(s.model.assembly.bricks[b]);
}

double allowed_overlap(const Simulation::Impl& s) {
  double least = std::numeric_limits<double>::infinity();
  for (const Brick& brick : s.model.assembly.bricks) {
    if (!brick.beam) least = std::min(least, least_extent(brick));
  }
  for (int i = 0; s.large_motion && i < s.large_motion->block_count(); ++i)
    least = std::min(least, s.large_motion->blocks[i].least_extent);
  return Watch::kAllowedOverlap * least;
}

std::optional<WrongAnswer> wrong_law(const Simulation::Impl& s) {
  const std::vector<int> chunks = chunks_with_results(s);
  if (s.large_motion) return s.large_motion->wrong_law(chunks);
  for (const int c : chunks) {
    const ContactChunk& chunk = s.model.chunks[at(c)];
    const ContactFamily& family = s.model.families[at(chunk.family)];
    auto wrong = wrong_answer(family.material->api(), answers_of(s.contacts.calls[at(c)]));
    if (!wrong) continue;
    const std::size_t p = at(chunk.first_point) + wrong->point;
    const Vec3& x = s.model.point_position[p];
    wrong->text += fmt::format(": joint {} (family '{}'), contact point at ({:.4f}, {:.4f}, {:.4f}) m",
                               s.model.point_joint[p], family.name, x[0], x[1], x[2]);
    return wrong;
  }
  return std::nullopt;
}

std::vector<Warning> new_warnings(Simulation::Impl& s, bool stage_ends) {
  const bool pass_is_due = stage_ends || s.progress.step >= s.watch.next_pass;
  if (pass_is_due) s.watch.next_pass = s.progress.step + Watch::kPassSteps;
  if (pass_is_due || !s.large_motion) check_points(s);  // on the lattice chunks have the sums
  // Seldom, as it lists all contact points.
  const bool bending_is_due = stage_ends || s.progress.step >= s.watch.next_stiffness;
  const std::optional<WrongAnswer> wrong = check_laws(s);
  book_energy_balance(s);

  std::vector<Warning> fresh;
  const auto warn = [&](const char* about, const auto& text) {
    if (was_warned(s, about)) return;
    if (const std::string words = text(); !words.empty()) warn_once(s, about, words, &fresh);
  };
  const auto warn_after_pass = [&](const char* about, const auto& text) {
    if (pass_is_due) warn(about, text);
  };
  for (const auto& [about, text] : stage_warnings(s.scene, static_cast<std::size_t>(s.progress.stage)))
    warn_once(s, about, text, &fresh);
  warn_after_pass("damping", [&] { return damped_motion(s); });
  warn("ground_motion", [&] { return motion_left_to_ground(s); });
  warn_after_pass("tension_in_new_contacts", [&] { return pull_over_gaps(s); });
  warn_after_pass("interpenetration", [&] { return deep_overlap(s); });
  warn("crushed_out", [&] { return points_crushed_out(s); });
  warn("bending", [&] { return bending_is_due ? bending_at_corners(s) : ""; });
  warn("pressure", [&] { return stage_ends ? crushed_in_ramp(s) : ""; });
  warn("equilibrium", [&] { return stage_ends ? missed_equilibrium(s) + creeping(s) : ""; });
  warn_after_pass("floor", [&] { return uneven_floor(s); });  // it does not change in a run
  warn("beam", [&] { return turned_piece_of_beam(s); });
  warn("seat", [&] { return beam_off_its_seat(s); });
  warn("energy_balance", [&] { return unbalanced_energies(s, stage_ends); });
  warn("time_step", [&] { return stiff_law(s); });
  warn("law_states", [&] {
    return wrong ? wrong->text + "; what follows is not to be relied on: tell its author, and see quoin-check-law" : "";
  });
  return fresh;
}

}  // namespace quoin
