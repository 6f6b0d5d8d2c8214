#include "cli/limit_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "analysis/limit_of_scene.h"
#include "base/clock.h"
#include "base/error.h"
#include "cli/prepare.h"
#include "cli/print_results.h"
#include "files/csv_text.h"
#include "files/file.h"
#include "files/notice.h"
#include "files/result_folder.h"
#include "results/json_file.h"
#include "results/virtual_motion.h"
#include "scene/stage_named.h"
#include "step/results.h"
#include "step/simulation.h"

namespace quoin {
namespace {

using geometry::Vector;

struct Options {
  SceneOptions scene;
  LimitOptions limit;
  std::string multiply = "weight", stage;
  std::string out;
};

void write_mechanism(const std::filesystem::path& folder, const Simulation& simulation, const SceneLimit& limit) {
  std::vector<StillBlock> drawn;
  VirtualMotion motion{"velocity", {}};
  std::string table = "block,name,x_m,y_m,z_m,vx,vy,vz,spin_x,spin_y,spin_z\n";
  for (std::size_t k = 0; k < limit.block_count; ++k) {
    const auto& [v, w] = limit.limit->velocity[k];
    const Vector& x = limit.problem.blocks[k].centre;
    table += fmt::format("{},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}\n", k,
                         csv_text(limit.names[k]), x.x, x.y, x.z, v.x, v.y, v.z, w.x, w.y, w.z);
    const BlockMesh mesh = block_mesh(simulation, static_cast<int>(k));
    StillBlock& block = drawn.emplace_back();
    block.zone = mesh.zone, block.face = mesh.face;
    auto& of_block = motion.displacement.emplace_back();
    for (const Vec3& point : mesh.gridpoint) {
      block.point.push_back(geometry::vector(point));
      of_block.push_back(v + cross(w, block.point.back() - x));
    }
  }
  for (const LimitBody& body : limit.bodies) {
    StillBlock& member = drawn.emplace_back();
    member.face = body.faces;
    auto& of_member = motion.displacement.emplace_back();
    for (int n = body.first; n < body.end; ++n) {
      member.point.push_back(limit.problem.blocks[static_cast<std::size_t>(n)].centre);
      of_member.push_back(limit.limit->velocity[static_cast<std::size_t>(n)].force);
    }
  }
  write_file(folder / "mechanism.csv", table);
  write_motions(folder / "mechanism.vtu", drawn, {motion});
}

void write_forces(const std::filesystem::path& file, const SceneLimit& limit) {
  std::string forces = "point,block_a,block_b,x_m,y_m,z_m,normal_N,shear_s_N,shear_t_N\n";
  for (std::size_t i = 0; i < limit.point_count; ++i) {
    const LimitPoint& p = limit.problem.points[i];
    const auto& f = limit.limit->force[i];
    forces += fmt::format("{},{},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}\n", i, p.a, p.b, p.position.x,
                          p.position.y, p.position.z, f[0], f[1], f[2]);
  }
  write_file(file, forces);
}

// Writes the multiplier by position. It is empty where no multiple causes collapse.
void write_moving(const std::filesystem::path& file, const SceneLimit& limit) {
  std::string table = "position,x_m,y_m,z_m,block,at_x_m,at_y_m,at_z_m,multiplier\n";
  for (std::size_t k = 0; k < limit.moving.size(); ++k) {
    const MovingLimit& here = limit.moving[k];
    table += fmt::format("{},{:.6g},{:.6g},{:.6g},{},{:.6g},{:.6g},{:.6g},{}\n", k + 1, here.position.x,
                         here.position.y, here.position.z, here.block, here.at.x, here.at.y, here.at.z,
                         here.multiplier ? fmt::format("{:.6g}", *here.multiplier) : "");
  }
  write_file(file, table);
}

void write_page(const std::filesystem::path& mechanism, const Scene& scene, Multiplied multiplied, double multiplier) {
  const std::string at = multiplied == Multiplied::motion ? fmt::format("a force of {:.6g} N", multiplier)
                                                          : fmt::format("the multiplier {:.4f}", multiplier);
  print_motion_report(mechanism, "Mechanism", scene, {{"velocity", "mechanism at " + at + ", associated flow"}}, true);
}

const char* in_time(const LimitWithoutDilation& without) {
  return without.late ? " within their time (--seconds)" : "";
}

void print(const LimitWithoutDilation& without) {
  for (const SettledLimit& start : without.start)
    fmt::print(
        "  from {}: {:.5f}{}, {} after {} problems; shear beyond friction: at most {:.2g} of the mean normal force{}\n",
        start.from == "weight" ? "elastic forces under weight" : "associated forces", start.multiplier,
        start.spread > 0.0 ? fmt::format(" +- {:.2g} %", 100.0 * start.spread) : "",
        start.settled ? "settled" : "not settled", start.problems, start.beyond,
        start.share_beyond < 1.0 ? fmt::format(", {:.2g} of the friction of all that slides", start.share_beyond) : "");
  if (without.start.size() == 2 &&
      std::all_of(without.start.begin(), without.start.end(), [](const SettledLimit& s) { return s.settled; }) &&
      std::abs(without.start[0].multiplier - without.start[1].multiplier) > 0.01 * std::abs(without.multiplier))
    fmt::print("  Both are states of the same masonry: normal forces hang on what has happened before\n");
}

std::string direction_text(const Vector& d) { return fmt::format("({:g}, {:g}, {:g})", d.x, d.y, d.z); }

void print_stands(const SceneLimit& limit) {
  const Stands& s = limit.stands;
  if (limit.halved)
    fmt::print("half of the thickness is modelled: nothing moves along z, and no load along z is tried\n");
  if (!s.stands)
    fmt::print("does not stand: {:.4f} of the given loads can be carried\n", s.carried);
  else if (!limit.moving.empty() || (limit.limit && !limit.direction))
    fmt::print("stands\n");
  else if (limit.margin)
    fmt::print("stands, with {:.5f} of the weight to go along {}, associated\n", *limit.margin,
               direction_text(limit.margin_direction));
  else
    fmt::print("stands, and no horizontal load moves a block\n");
  if (s.friction)
    fmt::print("smallest scale of friction with which it stands: {:.4f}, associated\n", *s.friction);
  else
    fmt::print("no friction makes it stand\n");
  if (!limit.friction) return;
  if (limit.friction->settled)
    fmt::print("smallest scale of friction without dilation: {:.4f}\n", limit.friction->multiplier);
  else
    fmt::print("no smallest scale of friction without dilation: iterations have not settled{}\n",
               in_time(*limit.friction));
  print(*limit.friction);
}

void print_joints(const SceneLimit& limit) {
  const std::vector<JointMotion> joints = joint_motions(limit);
  const auto count = [&](auto does) { return std::ranges::count_if(joints, does); };
  fmt::print(
      "mechanism: {} joints move; {} open, {} of them as hinges, {} slide, {} crush (moving_joints of limit.json)\n",
      joints.size(), count([](const JointMotion& j) { return j.opening > 0.0; }),
      count([](const JointMotion& j) { return j.hinges; }), count([](const JointMotion& j) { return j.sliding > 0.0; }),
      count([](const JointMotion& j) { return j.crushing > 0.0; }));
}

void print_multiplier(const SceneLimit& limit, Multiplied multiplied) {
  const int facets = limit.limit->facets;
  const std::string cones =
      facets > 0 ? fmt::format("friction cones as pyramids of {} facets, with up to {:.2g} % less friction", facets,
                               100.0 * (1.0 - std::cos(std::numbers::pi / facets)))
                 : "whole friction cones";
  if (!limit.moving.empty()) {
    const MovingLimit& worst = limit.moving[limit.worst];
    fmt::print(
        "multiplier {:.5f} of the moving load ({:g}, {:g}, {:g}) N where it is worst, at ({:.3f}, {:.3f}, "
        "{:.3f}) m on block {}, position {} of {}; associated flow, {}; gap {:.1e}\n",
        limit.limit->multiplier, limit.moving_force.x, limit.moving_force.y, limit.moving_force.z, worst.at.x,
        worst.at.y, worst.at.z, limit.labels[static_cast<std::size_t>(worst.block)], limit.worst + 1,
        limit.moving.size(), cones, limit.limit->gap);
  } else if (multiplied == Multiplied::motion) {
    fmt::print("force {:.6g} N along the motion of stage '{}', associated flow, {}; gap {:.1e}\n",
               limit.limit->multiplier, limit.stage, cones, limit.limit->gap);
  } else if (!limit.direction) {
    const Vector& sum = limit.live_force;
    fmt::print(
        "multiplier {:.5f} of the {} of stage '{}', ({:g}, {:g}, {:g}) N in sum, associated flow, {}; gap {:.1e}\n",
        limit.limit->multiplier, name_of(multiplied), limit.stage, sum.x, sum.y, sum.z, cones, limit.limit->gap);
  } else {
    fmt::print("multiplier {:.5f} of the weight along {}, associated flow, {}; gap {:.1e}\n", limit.limit->multiplier,
               direction_text(*limit.direction), cones, limit.limit->gap);
  }
  fmt::print("Sliding lifts by the friction angle here: an upper bound of what a run without dilation gives\n");
  print_joints(limit);
  for (std::size_t i = 0; i < limit.tie_names.size(); ++i)
    fmt::print("tie {:<12} {:.4g} N of {:.4g} N\n", limit.tie_names[i], limit.limit->member_force[i],
               limit.problem.forces[i].high);
  for (const LimitMember& member : limit.members) {
    const MemberForce force = largest_force(member, *limit.limit);
    if (!std::isfinite(force.strength)) continue;
    fmt::print("{} {}: at most {:.4g} of {:.4g}; at its strength in {} of {} places\n", member.label, member.what,
               force.largest, force.strength, force.at_strength, member.of.size());
  }
  if (!limit.without_dilation) return;
  if (limit.without_dilation->settled)
    fmt::print("multiplier {:.5f} without dilation\n", limit.without_dilation->multiplier);
  else
    fmt::print("no multiplier without dilation: iterations have not settled{}\n", in_time(*limit.without_dilation));
  print(*limit.without_dilation);
}

const std::vector<std::string> kFiles{"limit.json", "mechanism.csv", "mechanism.vtu", "forces.csv", "moving.csv"};

// Removes the results of an earlier analysis, which would be taken for those of one that fails.
void remove_results(const std::filesystem::path& folder) {
  refuse_folder_of_run(folder);
  refuse_files_of_others(folder, kFiles);
  if (!exists(folder / "limit.json")) return;
  refuse_page_of_others(folder / "report.html");
  for (const std::string& name : kFiles) remove(folder / name);
  remove(folder / "report.html");
}

void run(const Options& options) {
  LimitOptions asked = options.limit;
  asked.multiplied = multiplied_named(options.multiply);
  if (!options.out.empty()) remove_results(options.out);
  const Scene scene = for_limit(prepare_scene(options.scene), asked.multiplied);
  const Simulation simulation(scene, 1);
  if (!options.stage.empty()) asked.stage = &scene.stages[static_cast<std::size_t>(stage_named(scene, options.stage))];
  const auto begin = Clock::now();
  const SceneLimit limit = limit_of(simulation, asked);
  const double seconds = seconds_since(begin);
  fmt::print("{}: {} blocks, {} contact points; {:.2g} s\n", scene.file, limit.block_count, limit.point_count, seconds);
  if (limit.edge_count > 0)
    fmt::print("{} pairs of blocks meet along edges alone, and carry nothing there (analysis/README.md)\n",
               limit.edge_count);
  print_stands(limit);
  if (limit.limit) print_multiplier(limit, asked.multiplied);
  if (const std::vector<int> blocks = moving_without_load(limit); !blocks.empty())
    notice(fmt::format("quoin: {}: a mechanism that needs no load: nothing resists the motion of {} block(s):{}",
                       scene.file, blocks.size(), blocks_text(limit, blocks)));
  if (!options.out.empty()) {
    const std::filesystem::path folder = options.out;
    std::vector<std::string> files(kFiles.begin(), kFiles.begin() + (limit.limit ? 4 : 1));
    if (!limit.moving.empty()) files.push_back(kFiles.back());
    list_own_files(folder, files);
    write_json(folder / "limit.json", json_of(scene.file, limit, asked));
    if (limit.limit) write_mechanism(folder, simulation, limit), write_forces(folder / "forces.csv", limit);
    if (!limit.moving.empty()) write_moving(folder / "moving.csv", limit);
    fmt::print("{}\n", (folder / "limit.json").string());
    if (limit.limit) write_page(folder / "mechanism.vtu", scene, asked.multiplied, limit.limit->multiplier);
  }
  if (!limit.stands.stands)
    throw Error(Exit::numerical, fmt::format("{}: the given loads cannot be carried; out of balance:{}", scene.file,
                                             blocks_text(limit, limit.stands.out_of_balance)));
}

}  // namespace

void add_limit_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("limit", "Load multiplier at collapse by limit analysis, without a run");
  const auto options = std::make_shared<Options>();
  command->add_option("scene", options->scene.scene, "Scene file")->type_name("SCENE.toml")->required();
  command->add_option("--direction", options->limit.direction, "Of the load that is multiplied, a share of the weight")
      ->type_name("X Y Z")
      ->expected(3);
  command->add_option("--given", options->limit.given, "Multiple of that load which acts beside the weight")
      ->capture_default_str();
  command
      ->add_option(
          "--multiply", options->multiply,
          "What is multiplied: weight; forces, pressures or loads (both, and forces on bodies) of a stage; motion: "
          "a force of 1 N along its motion")
      ->capture_default_str();
  command
      ->add_option("--stage", options->stage,
                   "Whose gravity and loads count; else the first that collapses or has what is multiplied")
      ->type_name("NAME");
  command
      ->add_option("--facets", options->limit.settings.facets, "Of pyramids within the friction cones; 0: whole cones")
      ->capture_default_str();
  command->add_flag("--moving", options->limit.moving,
                    "Multiply the moving load of the first stage that has one, at each of its positions");
  command->add_flag("--associated", options->limit.associated, "No search for answers without dilation");
  command
      ->add_option("--seconds", options->limit.seconds,
                   "Time for the associated answers, and for each search without dilation")
      ->capture_default_str();
  command->add_option("--law", options->scene.law, "Law for all joints in place of the scene's");
  command->add_option("--set", options->scene.overrides, "dotted.key=value: set a key of the scene; may be repeated");
  command
      ->add_option(
          "--out", options->out,
          "Folder for limit.json, mechanism.csv, mechanism.vtu, forces.csv and report.html, where the mechanism moves; "
          "moving.csv")
      ->type_name("DIR");
  command->footer(
      "Static theorem on the contact points of the scene: rigid blocks, brittle strength from the properties of the "
      "laws,\n"
      "associated flow; and by Gilbert's iteration without dilation, from two starts, of which the lower one counts.\n"
      "Gravity and direction are those of the first collapse stage. Told, too: whether the given loads are carried,\n"
      "with what margin (without a direction: the least of four horizontal ones) and with how much of the friction.\n"
      "Examples:\n"
      "  quoin limit host/scenes/ferris_tin_loi_2.toml --out out/limit\n"
      "  quoin limit host/scenes/arch.toml --direction -1 0 0\n"
      "  quoin limit my_scene.toml --multiply forces --stage push");
  command->callback([options] { run(*options); });
}

}  // namespace quoin
