#include "cli/check_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "base/clock.h"
#include "base/duration_text.h"
#include "cli/law_seconds.h"
#include "cli/prepare.h"
#include "files/memory.h"
#include "law/at_rest.h"
#include "law/law_calls.h"
#include "law/law_trial.h"
#include "members/members.h"
#include "model/motion.h"
#include "model/time_step.h"
#include "results/checkpoint_file.h"
#include "results/monitors.h"
#include "results/surface.h"
#include "scene/collapse_load.h"
#include "scene/damping_text.h"
#include "scene/driven.h"
#include "scene/scatter_text.h"
#include "scene/size.h"
#include "scene/stage_warnings.h"
#include "scene/weight_axis.h"
#include "step/findings.h"
#include "step/large_motion.h"
#include "step/rest.h"
#include "step/results.h"
#include "step/simulation.h"

namespace quoin {

namespace {

void print_limit(const char* name, const TimeStepLimit& limit, const TimeStepReport& report) {
  fmt::print("  {:<44} {:.4g} s  ({:.2f} of 2/omega_max)\n", name, limit.value, limit.value / report.critical.value);
  if (!limit.where.empty())
    fmt::print("      set at ({:.3f}, {:.3f}, {:.3f}) m: {}\n", limit.position[0], limit.position[1], limit.position[2],
               limit.where);
}

void print_memory(const SceneSize& size) {
  fmt::print("  memory of the model about {:.0f} MB of {:.0f} MB here\n", std::ceil(size.bytes / 1e6),
             memory_here() / 1e6);
}

// Prints the kernels that move blocks, and the share of SIMD lanes in use.
void print_motion(const Model& model) {
  long lattice = 0, in_lanes = 0;
  for (const BlockGroup& group : model.groups) lattice += group.block_count;
  for (const BodyGroup& group : model.body_groups) in_lanes += group.body_count;
  std::string text;
  const auto add = [&](long blocks, const std::string& how) {
    if (blocks > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", blocks, how);
  };
  add(lattice, fmt::format("deformable on the lattice ({} groups of {} lanes)", model.groups.size(), kLanes));
  add(in_lanes, fmt::format("rigid in lanes ({} groups)", model.body_groups.size()));
  add(static_cast<long>(model.lone_bodies.size()), "rigid one by one");
  fmt::print("  motion in small displacement: {}\n", text);
}

// Time step of a stage. With impact damping it depends on blocks and joints, and always on inertia. It is that of a
// model that begins with the stage.
struct StageStep {
  double time_step = 0.0, critical = 0.0, in_use = 0.0;  // s; 2/omega_max, s; damping ratio in use
};
StageStep step_of_own_model(const Scene& scene, std::size_t stage) {
  Scene alone = scene;
  alone.solver = scene.solver_in(stage);
  alone.stages = {scene.stages[stage]};
  alone.stages.front().solver.reset();
  const Simulation simulation(std::move(alone), 0);
  const TimeStepReport& report = simulation.time_step_report();
  return {report.time_step, report.critical.value, report.impacts.in_use};
}

// Prints the end of each stage, and its number of steps if that is known. Returns the sum of the known numbers.
double print_stages(const Scene& scene, const TimeStepReport& report) {
  double steps = 0.0;
  fmt::print("stages\n");
  for (size_t i = 0; i < scene.stages.size(); ++i) {
    const Stage& stage = scene.stages[i];
    const std::string own = own_solver_text(scene, i);
    const SolverSettings& solver = scene.solver_in(i);
    const std::optional<ImpactTerms> impacts = damping_of(solver).impacts;
    const bool has_own_model = impacts || has_own_inertia(scene, i);
    const StageStep alone = has_own_model ? step_of_own_model(scene, i) : StageStep{};
    const double time_step = has_own_model ? alone.time_step
                             : own.empty()
                                 ? report.time_step
                                 : blocks::step_over_critical(solver, report.critical.value) * report.critical.value;
    double seconds = stage.duration.value_or(0.0);
    if (const double driven = driven_velocity(stage); stage.displacement && driven != 0.0)
      seconds = *stage.displacement / std::abs(driven) + stage.ramp_time / 2;
    if (const auto growth = stage.collapse ? seconds_of_growth(*stage.collapse) : std::nullopt)
      seconds = stage.ramp_time + *growth;
    steps += seconds / time_step;
    fmt::print("  {:<16} until {}{}\n", stage.name, end_of(stage),
               seconds > 0 ? fmt::format(", about {:.9g} steps", std::round(seconds / time_step)) : "");
    if (stage.ground) fmt::print("      ground motion, {}\n", ground_text(*stage.ground, stage.duration));
    if (!own.empty())
      fmt::print("      {}: time step {:.4g} s, {:.2f} of 2/omega_max{}\n", own, time_step,
                 time_step / (has_own_model ? alone.critical : report.critical.value),
                 impacts && alone.in_use < 0.99 * impacts->share
                     ? fmt::format(", at which {:.2g} of critical is in use", alone.in_use)
                     : "");
    for (const auto& [about, text] : stage_warnings(scene, i)) fmt::print("      warning: {}\n", text);
  }
  return steps;
}

// Prints supports of stages, and blocks that no support reaches. Stages with equal supports share a line.
void print_supports(const Simulation& simulation) {
  constexpr std::size_t kNamed = 5;
  std::vector<std::pair<std::string, std::string>> lines;  // text, stages
  for (std::size_t i = 0; i < simulation.scene().stages.size(); ++i) {
    const Supports supports = supports_in(simulation, static_cast<int>(i));
    std::string text = supports.held.empty() ? "nothing is held" : fmt::format("{}", fmt::join(supports.held, "; "));
    if (!supports.loose.empty()) {
      text += fmt::format("\n  {:<16} warning: {} of {} blocks may fall, as no joint ties them to what is held:", "",
                          supports.loose.size(), simulation.block_count());
      for (std::size_t k = 0; k < std::min(kNamed, supports.loose.size()); ++k)
        text += (k == 0 ? " " : ", ") + block_label(simulation, supports.loose[k]);
      if (supports.loose.size() > kNamed) text += ", ...";
    }
    const std::string& name = simulation.scene().stages[i].name;
    const auto same = std::find_if(lines.begin(), lines.end(), [&](const auto& line) { return line.first == text; });
    if (same == lines.end())
      lines.emplace_back(text, name);
    else
      same->second += ", " + name;
  }
  fmt::print("supports, and the axes that they hold or move\n");
  for (const auto& [text, stages] : lines) fmt::print("  {:<16} {}\n", stages, text);
}

// Warns of blocks in the lowest course without a support while others have one: probably the ground is too short.
void print_overhang(const Simulation& simulation) {
  constexpr std::size_t kNamed = 5;
  const int count = static_cast<int>(simulation.block_count());
  const Vec3 gravity = first_gravity(simulation.scene());
  const auto upright = static_cast<std::size_t>(upright_axis(gravity));
  const double sign = gravity[upright] > 0.0 ? -1.0 : 1.0;
  std::vector<double> foot(static_cast<std::size_t>(count), HUGE_VAL);
  std::vector<bool> fixed(foot.size()), stands(foot.size());
  double lowest = HUGE_VAL, highest = -HUGE_VAL;
  for (int b = 0; b < count; ++b) {
    const BlockMesh mesh = block_mesh(simulation, b);
    const auto block = static_cast<std::size_t>(b);
    fixed[block] = mesh.fixed;
    for (const Vec3& p : mesh.gridpoint) {
      const double height = sign * p[upright];
      foot[block] = std::min(foot[block], height);
      if (!mesh.fixed) highest = std::max(highest, height);
    }
    if (!mesh.fixed) lowest = std::min(lowest, foot[block]);
  }
  for (const JointPoint& p : Surfaces().joint_points(simulation)) {
    const auto a = static_cast<std::size_t>(p.contact.block_a), b = static_cast<std::size_t>(p.contact.block_b);
    stands[a] = stands[a] || fixed[b], stands[b] = stands[b] || fixed[a];
  }
  std::vector<int> hanging;
  bool others = false;
  for (int b = 0; b < count; ++b) {
    const auto block = static_cast<std::size_t>(b);
    if (fixed[block] || foot[block] > lowest + 1e-6 * (highest - lowest)) continue;
    if (stands[block])
      others = true;
    else
      hanging.push_back(b);
  }
  if (hanging.empty() || !others) return;
  std::string names;
  for (std::size_t k = 0; k < std::min(kNamed, hanging.size()); ++k)
    names += (k == 0 ? "" : ", ") + block_label(simulation, hanging[k]);
  fmt::print(
      "  {:<16} warning: {} blocks of the lowest course stand on no fixed block: {}{}; is the ground too short?\n", "",
      hanging.size(), names, hanging.size() > kNamed ? ", ..." : "");
}

// Prints the time of all steps, estimated by some steps of this model on this machine. Throws Error(bad_input) above
// kLongest.
void print_time(Simulation& simulation, const Scene& scene, double steps, bool force) {
  constexpr double kLook = 0.1, kLongest = 30.0 * 86400.0;  // s; longest measurement, longest run
  simulation.advance(1, false);                             // the first step touches memory for the first time
  long taken = 0;
  const auto begin = Clock::now();
  while (taken == 0 || (seconds_since(begin) < kLook && taken < 1000)) simulation.advance(1, false), ++taken;
  const double per_step = seconds_since(begin) / static_cast<double>(taken), all = per_step * steps;
  const bool settles = std::any_of(scene.stages.begin(), scene.stages.end(),
                                   [](const Stage& s) { return s.equilibrium_ratio.has_value(); });
  const bool grows = std::any_of(scene.stages.begin(), scene.stages.end(),
                                 [](const Stage& s) { return s.collapse && !seconds_of_growth(*s.collapse); });
  fmt::print("computing time about {}{}{} ({:.3g} ms a step, by {} steps with {} threads here)\n", duration_text(all),
             settles ? ", and what stages take to come to rest" : "",
             grows ? ", and that in which the load of a collapse grows" : "", per_step * 1e3, taken,
             simulation.thread_count());
  if (force || all <= kLongest) return;
  throw Error(
      Exit::bad_input,
      fmt::format("{}: about {:.3g} steps of {:.3g} ms, {}, and {} are taken for the longest that a run may last; "
                  "load faster (stage velocity, solver.quality), make the scene smaller, or go on with --force",
                  scene.file, steps, per_step * 1e3, duration_text(all), duration_text(kLongest)));
}

// Prints random properties of a family, and their range in the sample.
void print_scatter(const JointFamily& family, const std::vector<PropertyColumn>& columns) {
  const RandomSample& random = family.random;
  if (!family.is_random()) return;
  fmt::print("  joints.{:<10} {}\n", family.name,
             random.sample == 0 ? std::string("sample 0: everything at its mean")
                                : fmt::format("sample {} of seed {}", random.sample, random.seed));
  for (const PropertySetting& p : family.properties) {
    if (!p.scatter) continue;
    fmt::print("    {:<26} {}\n", p.id, text_of(*p.scatter));
    for (const PropertyColumn& c : columns) {
      if (c.id != p.id || c.values.empty()) continue;
      const auto [low, high] = std::minmax_element(c.values.begin(), c.values.end());
      const double mean = std::accumulate(c.values.begin(), c.values.end(), 0.0) / static_cast<double>(c.values.size());
      fmt::print("    {:<26} drawn for {} contact points: {:.4g} to {:.4g}, mean {:.4g}\n", "", c.values.size(), *low,
                 *high, mean);
    }
  }
  for (const PropertyCorrelation& c : family.correlation)
    fmt::print("    {} and {} correlated by {:g}\n", c.first, c.second, c.value);
  if (family.missing_mortar > 0.0 && random.sample != 0)
    fmt::print("    {:.1f} % of the joints without mortar, at random\n", 100 * family.missing_mortar);
}

// Prints a family of joints: its law and its random properties. Stiffness: upper bounds, Pa/m.
void print_family(const JointFamily& family, const Material& material, long points, double normal_stiffness,
                  double shear_stiffness, const std::vector<PropertyColumn>& columns) {
  fmt::print("  joints.{:<10} law {} {}, {} contact points, stiffness at most {:.4g} and {:.4g} Pa/m\n", family.name,
             material.api().id, law_text(material.api().version), points, normal_stiffness, shear_stiffness);
  if (!material.warnings().empty()) fmt::print("    warning: {}\n", material.warnings());
  print_scatter(family, columns);
}

// Warns about joints between rigid blocks with contact points at corners alone. Their second moment is A h^2/4, that of
// the joint's face A h^2/12. Dry joints turn about their edges, where corners are right. spaced: contact.point_spacing
// sets the points.
void print_rigid_joints(const JointFamily& family, const Material& material, long joints, bool spaced) {
  if (joints == 0 || spaced) return;
  if (family.rigid_points != RigidPoints::corners)
    fmt::print("    {} joints of rigid blocks have points that integrate bending exactly (contact.cubic_points)\n",
               joints);
  else if (!carries_tension(material, family.initial_state))
    fmt::print(
        "    {} joints of rigid blocks have points at corners alone, about which dry blocks turn; while closed they "
        "are 3 times too stiff in bending, and 1.8 to 2 times too strong in friction against twisting "
        "(contact.cubic_points)\n",
        joints);
  else
    fmt::print(
        "    warning: {} joints of rigid blocks that carry tension have contact points at their corners alone, which "
        "makes them 3 times too stiff and too strong in bending: remove contact.cubic_points = false\n",
        joints);
}

long rigid_joints(const blocks::Model& m, int family) {
  const auto is_rigid = [&](int block) { return m.blocks[block].body >= 0; };
  return std::count_if(m.contacts.list.begin(), m.contacts.list.end(), [&](const blocks::Contact& c) {
    return c.initial && c.family == family && is_rigid(c.pair.a) && is_rigid(c.pair.b) && c.count >= 3;
  });
}

long rigid_joints(const Assembly& assembly, int family) {
  const auto is_rigid = [&](int brick) { return assembly.bricks[static_cast<size_t>(brick)].rigid; };
  return std::count_if(assembly.joints.begin(), assembly.joints.end(), [&](const Joint& joint) {
    return joint.family == family && is_rigid(joint.block_a) && is_rigid(joint.block_b);
  });
}

void print_notes(const TimeStepReport& report) {
  if (!report.warning().empty()) fmt::print("  warning: {}\n", report.warning());
  constexpr double kRounding = 1e-9;  // of the model's mass
  if (report.added_mass > kRounding * report.model_mass)
    fmt::print("  inertia added by scaling {:.4g} kg, {:.1f} % of the model\n", report.added_mass,
               100 * report.added_mass / report.model_mass);
}

void print_what_sets_step(const blocks::Model& model) {
  const blocks::StepLimit limit = what_sets_time_step(model);
  if (limit.block < 0) return;
  std::string zone = "rigid";
  if (limit.height > 0.0)
    zone =
        fmt::format("its zone there is {:.3g} m high and has an edge of {:.3g} m", limit.height, limit.shortest_edge);
  fmt::print("      set at ({:.3f}, {:.3f}, {:.3f}) m: block {}, {}\n", limit.at.x, limit.at.y, limit.at.z,
             blocks::label(model.assembly, limit.block), zone);
}

void print_members(const members::Members& members, const blocks::Assembly& assembly) {
  fmt::print("members\n");
  for (const members::Tie& tie : members.ties()) {
    const members::Node &from = members.nodes()[static_cast<std::size_t>(tie.stops.front().front().first)],
                        &to = members.nodes()[static_cast<std::size_t>(tie.stops.back().front().first)];
    fmt::print("  tie {:<12} {:.3f} m from block {} to {}; {:.4g} N/m, {:.4g} N at first, yields at {:.4g} N\n",
               tie.name, tie.length, blocks::label(assembly, from.block), blocks::label(assembly, to.block),
               tie.law.stiffness, tie.law.pretension, tie.law.yield);
  }
  for (const members::Bed& bed : members.beds())
    fmt::print("  spring {:<9} {:.4g} m2 on the ground, {} points\n", bed.name, bed.area, bed.points.size());
  for (const members::Strip& strip : members.strips())
    fmt::print("  strip {:<10} {} nodes\n", strip.name(), strip.places().size());
  for (const members::Floor& floor : members.floors()) {
    fmt::print("  floor {:<10} {:.4g} m2, {} x {} panels, {} connectors to walls, {:.4g} kg\n", floor.name(),
               floor.area(), floor.grid().pieces[0], floor.grid().pieces[1], floor.connectors().size(),
               floor.membrane().mass * floor.area());
    if (const std::string text = floor.uneven_weight(); !text.empty()) fmt::print("    warning: {}\n", text);
  }
  for (const members::Beam& beam : members.beams())
    fmt::print("  beam {:<11} {:.3f} m in {} pieces, {} springs to blocks, {:.4g} kg\n", beam.name(), beam.length(),
               beam.pieces().size(), beam.supports().size(), beam.section().mass * beam.length());
  for (const members::Dowel& dowel : members.dowels())
    fmt::print("  dowel {:<10} joins blocks {} and {}; yields at {:.4g} N along and {:.4g} N across\n", dowel.name,
               blocks::label(assembly, members.nodes()[static_cast<std::size_t>(dowel.first)].block),
               blocks::label(assembly, members.nodes()[static_cast<std::size_t>(dowel.second)].block),
               dowel.law.yield_force, dowel.law.yield_shear);
  for (const members::Fill& fill : members.fills())
    fmt::print("  fill {:<11} {:.4g} m2 of faces, {} points\n", fill.name, fill.area, fill.points.size());
}

// How many blocks move in which way.
void print_motion(const blocks::World& world) {
  using Kind = blocks::Piece::Kind;
  std::vector<std::string> parts;
  for (const auto& [kind, text] :
       {std::pair{Kind::rigid, "rigid"}, std::pair{Kind::congruent, "deformable by the stiffness of their shape"},
        std::pair{Kind::distinct, "deformable by a stiffness of their own"},
        std::pair{Kind::by_zone, "deformable zone by zone"}}) {
    if (const auto count = count_of(world, kind); count > 0) parts.push_back(fmt::format("{} {}", count, text));
  }
  fmt::print("  motion in large displacement{}: {}\n", world.is_small ? ", small at first" : "",
             fmt::join(parts, ", "));
}

// The scene with numbers in place of those that limit analysis finds before a run.
Scene with_some_collapse(Scene scene) {
  for (Stage& stage : scene.stages) {
    if (stage.collapse && !stage.collapse->start) stage.collapse->start = 0.0;
    if (stage.collapse && !stage.collapse->limit) stage.collapse->limit = Collapse{}.limit;
  }
  return scene;
}

void check_blocks(const SceneOptions& options, const Scene& scene, const std::string& why_not_lattice) {
  Simulation simulation(with_some_collapse(scene), 0);
  monitor_places(simulation);  // throws for a monitor of a block that does not exist
  const TimeStepReport& step = simulation.time_step_report();
  fmt::print("{}: {}\n  blocks {}  zones {}  contact points {}  mass {:.4g} kg\n", options.scene,
             scene.title.empty() ? "(no title)" : scene.title, simulation.block_count(), simulation.zone_count(),
             simulation.point_count(), step.model_mass);
  const auto& families = simulation.large_motion()->contacts.families;
  for (std::size_t f = 0; f < families.size(); ++f) {
    print_family(simulation.large_motion()->assembly.families[f], *families[f].material,
                 static_cast<long>(families[f].size()), families[f].kn, families[f].ks, families[f].columns);
    print_rigid_joints(simulation.large_motion()->assembly.families[f], *families[f].material,
                       rigid_joints(*simulation.large_motion(), static_cast<int>(f)),
                       simulation.large_motion()->assembly.contact.point_spacing > 0.0);
  }
  print_memory(size_of(scene));
  print_motion(*simulation.large_motion());
  if (!why_not_lattice.empty()) fmt::print("  not on the lattice: {}\n", why_not_lattice);
  for (const std::string& note : simulation.large_motion()->assembly.notes) fmt::print("  {}\n", note);
  fmt::print("time step {:.4g} s, {:.2f} of 2/omega_max ({:.4g} s)\n", step.time_step,
             step.time_step / step.critical.value, step.critical.value);
  print_what_sets_step(*simulation.large_motion());
  print_notes(step);
  print_supports(simulation);
  print_overhang(simulation);
  if (const members::Members* const members = simulation.large_motion()->held_by.members.get())
    print_members(*members, simulation.large_motion()->assembly);
  print_time(simulation, scene, print_stages(scene, step), options.force);
}

// Throws where a run refuses the start of the scene. Limit analysis before a run may set numbers of its stages, on
// which the start depends too: then only the file is required.
void check_start(const Scene& scene) {
  require_start(scene);
  const bool is_complete = std::none_of(scene.stages.begin(), scene.stages.end(), [](const Stage& s) {
    return s.collapse && (!s.collapse->start || !s.collapse->limit);
  });
  if (scene.start.empty() || !is_complete) return;
  Simulation simulation(scene, 0);
  take_start(&simulation);
  require_coming_stages(simulation);
}

void check(const SceneOptions& options) {
  const Scene scene = prepare_scene(options);
  check_start(scene);
  for (const Derivation& d : scene.derivation)
    fmt::print("  from tests: {} {:.4g} {}: {}\n", d.name, d.value, d.unit, d.from);
  const SceneSize scene_size = size_of(scene);
  Motion motion = choose_motion(scene);
  if (motion.shapes) return check_blocks(options, scene, motion.why_not_lattice);
  auto materials = make_materials(motion.bricks);
  const Model model(std::move(motion.bricks), std::move(materials));
  Inertia inertia;
  const TimeStepReport report = choose_time_step(model, scene.solver, &inertia, Limits::all, motion.scene.stages);
  Simulation simulation(scene, 0);
  monitor_places(simulation);

  const auto& bricks = model.assembly.bricks;
  const auto beams = std::count_if(bricks.begin(), bricks.end(), [](const Brick& b) { return b.beam; });
  fmt::print("{}: {}\n", options.scene, scene.title.empty() ? "(no title)" : scene.title);
  fmt::print("  blocks {}  beams {}  zones {}  contact points {}  joints {}  mass {:.4g} kg\n",
             static_cast<long>(bricks.size()) - beams, beams, model.zone_count(), model.point_count,
             model.assembly.joints.size(), report.model_mass);
  for (std::size_t f = 0; f < model.families.size(); ++f) {
    const ContactFamily& family = model.families[f];
    print_family(model.assembly.families[f], *family.material, family.point_count, family.normal_stiffness,
                 family.shear_stiffness, family.columns);
    print_rigid_joints(model.assembly.families[f], *family.material, rigid_joints(model.assembly, static_cast<int>(f)),
                       false);
  }
  const auto lacks_mortar = [&](const auto& pair) {  // not a cut of the bottom beam
    return !model.assembly.bricks[static_cast<std::size_t>(pair[0])].beam;
  };
  if (const auto count = std::ranges::count_if(model.assembly.apart, lacks_mortar); count > 0)
    fmt::print("  {} joints without mortar\n", count);
  print_memory(scene_size);
  print_motion(model);
  fmt::print("time step\n");
  print_limit("2/omega_max of the assembled system", report.critical, report);
  print_limit("Gershgorin row sums (guaranteed)", report.gershgorin, report);
  print_limit("nodal 2 sqrt(m/k), eq. 3 (not safe)", report.nodal, report);
  fmt::print("  {:<44} {:.4g} s  ({:.2f} of 2/omega_max)\n", "in use", report.time_step,
             report.time_step / report.critical.value);
  print_notes(report);
  print_supports(simulation);
  print_time(simulation, scene, print_stages(scene, report), options.force);
}

}  // namespace

void add_check_command(CLI::App& app, int&) {
  CLI::App* command = app.add_subcommand(
      "check", "Validate a scene; print sizes, time steps, memory and computing time without running");
  auto options = std::make_shared<SceneOptions>();
  auto law_seconds = std::make_shared<double>(kLawSeconds);
  command->add_option("scene", options->scene, "Scene file")->required()->type_name("SCENE.toml");
  command->add_option("--law", options->law, "Law for all joints in place of the scene's")->type_name("NAME_OR_PATH");
  command->add_option("--set", options->overrides, "Set a key of the scene; may be repeated")
      ->type_name("dotted.key=value")
      ->allow_extra_args(false);
  command->add_flag("--force", options->force, "Go on where the model seems too large or too slow for this machine");
  add_law_seconds(*command, *law_seconds);
  command->footer(
      "Examples:\n"
      "  quoin check host/scenes/solid_wall_030.toml\n"
      "  quoin check host/scenes/solid_wall_030.toml --set wall.zones=[8,4,2]");
  command->callback([options, law_seconds] {
    const LawWatchdog watchdog = limit_laws(*law_seconds);
    check(*options);
  });
}

}  // namespace quoin
