#include "cli/limit_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "analysis/limit.h"
#include "analysis/without_dilation.h"
#include "base/error.h"
#include "cli/prepare.h"
#include "files/csv_text.h"
#include "files/file.h"
#include "geometry/polyhedron.h"
#include "law/law_library.h"
#include "results/json_file.h"
#include "results/virtual_motion.h"
#include "step/large_motion.h"
#include "step/simulation.h"

namespace quoin {
namespace {

using geometry::Vector;

struct Options {
  SceneOptions scene;
  std::vector<double> direction;
  std::string out;
  int facets = 32;
  bool associated = false;
};

// Weight and the direction of what is multiplied: of the first collapse stage, or of the first stage with gravity.
struct Loads {
  Vector gravity, direction;  // m/s2, unit
};

Loads loads_of(const Scene& scene, const std::vector<double>& wanted) {
  Loads loads;
  bool found = false;
  for (const Stage& stage : scene.stages) {
    if (norm(geometry::vector(stage.gravity)) > 0.0 && (stage.collapse || norm(loads.gravity) == 0.0))
      loads.gravity = geometry::vector(stage.gravity);
    if (!stage.collapse || found) continue;
    loads.direction = geometry::vector(stage.collapse->direction), found = true;
  }
  if (norm(loads.gravity) == 0.0)
    throw Error(Exit::bad_input,
                fmt::format("{}: no stage has gravity; give one stage gravity = [0, -9.81, 0]", scene.file));
  if (!wanted.empty()) loads.direction = {wanted[0], wanted[1], wanted[2]}, found = true;
  if (!found || !(norm(loads.direction) > 0.0))
    throw Error(Exit::bad_input, fmt::format("{}: no collapse stage says in which direction the load acts; give "
                                             "--direction X Y Z, not all 0",
                                             scene.file));
  loads.direction = normalized(loads.direction);
  return loads;
}

// Brittle strength of a joint family, from the law's own properties; 0, or no crushing, where a law has none.
struct Strength {
  double friction = 0.0, tension = 0.0, cohesion = 0.0;  // -, Pa, Pa
  double crushing = std::numeric_limits<double>::infinity();
};

Strength strength_of(const JointFamily& family, const std::string& file) {
  const Material material(Law::find(family.law), family.properties);
  const auto has = [&](const char* id) {
    const quoin_law& api = material.api();
    return std::any_of(api.properties, api.properties + api.property_count,
                       [&](const quoin_property_info* p) { return std::string(law_text(p->id)) == id; });
  };
  if (!has("friction_angle"))
    throw Error(Exit::bad_input,
                fmt::format("{}: joints.{}: law '{}' has no friction_angle, so its joints have no limit; "
                            "choose coulomb_slip, fracture_energy or cyclic_joint (--law)",
                            file, family.name, family.law));
  constexpr double degree = std::numbers::pi / 180.0;
  Strength s;
  s.friction = std::tan(degree * material.number("friction_angle"));
  const bool dry = family.initial_state == "dry";
  if (!dry && has("tensile_strength")) s.tension = material.number("tensile_strength");
  if (has(dry ? "cohesion_residual" : "cohesion")) s.cohesion = material.number(dry ? "cohesion_residual" : "cohesion");
  if (has("compressive_strength")) s.crushing = material.number("compressive_strength");
  return s;
}

struct Assembled {
  LimitProblem problem;
  std::vector<StillBlock> drawn;
  std::vector<std::string> names;  // of the blocks
};

// Each block is rigid, each contact point a force. Weights from the outlines of the blocks.
Assembled assemble(const Simulation& simulation, const Loads& loads) {
  const Scene& scene = simulation.scene();
  const blocks::Model* const shapes = simulation.riding();
  Assembled result;
  for (int i = 0; i < static_cast<int>(simulation.block_count()); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Simulation::BlockMesh mesh = simulation.block_mesh(i);
    std::vector<Vector> corners;
    for (const Vec3& x : mesh.gridpoint) corners.push_back(geometry::vector(x));
    std::string name;
    double density = 0.0;
    LimitBlock block;
    if (shapes) {
      const blocks::Block& input = shapes->assembly().blocks[k];
      name = input.name, density = shapes->assembly().materials[static_cast<std::size_t>(input.material)].density;
      block.fixed = input.fixed;
    } else {
      const Brick& brick = simulation.assembly().bricks[k];
      name = brick.body, density = simulation.assembly().materials[static_cast<std::size_t>(brick.material)].density;
      block.fixed = brick.fixed || brick.body.starts_with("bottom_beam");
    }
    const geometry::MassProperties mass = mass_properties(geometry::from_vertices(corners, name));
    block.centre = mass.centroid;
    block.dead.force = density * mass.volume * loads.gravity;
    block.live.force = density * mass.volume * norm(loads.gravity) * loads.direction;
    result.problem.blocks.push_back(block);
    result.drawn.push_back({corners, mesh.zone, mesh.face});
    result.names.push_back(name);
  }
  std::map<std::string, Strength> strengths;
  for (const auto& [name, family] : scene.joints) strengths[name] = strength_of(family, scene.file);
  const std::vector<JointFamily>& families = shapes ? shapes->assembly().families : simulation.assembly().families;
  for (const ContactPoint& p : simulation.contact_points()) {
    const Strength& s = strengths.at(families[static_cast<std::size_t>(p.family)].name);
    result.problem.points.push_back({p.block_a, p.block_b, geometry::vector(p.position), geometry::vector(p.normal),
                                     geometry::vector(p.s), geometry::vector(p.t), s.friction, s.tension * p.area,
                                     s.cohesion * p.area, s.crushing * p.area, p.area});
  }
  return result;
}

std::string label(const Assembled& assembled, int block) {
  const std::string& name = assembled.names[static_cast<std::size_t>(block)];
  const Vector& x = assembled.problem.blocks[static_cast<std::size_t>(block)].centre;
  return fmt::format("#{}{} at ({:.3f}, {:.3f}, {:.3f}) m", block, name.empty() ? "" : " '" + name + "'", x.x, x.y,
                     x.z);
}

[[noreturn]] void refuse(const std::string& file, const Assembled& assembled, const LimitResult& result) {
  std::string blocks;
  for (std::size_t i = 0; i < std::min<std::size_t>(5, result.blocks_concerned.size()); ++i)
    blocks += "\n  block " + label(assembled, result.blocks_concerned[i]);
  if (result.blocks_concerned.size() > 5) blocks += fmt::format("\n  and {} more", result.blocks_concerned.size() - 5);
  switch (result.status) {
    case LimitStatus::no_equilibrium:
      throw Error(Exit::numerical,
                  fmt::format("{}: the weight alone cannot be carried; out of balance:{}", file, blocks));
    case LimitStatus::unbounded:
      throw Error(Exit::numerical, fmt::format("{}: no multiple of the load moves a block; is its direction right, and "
                                               "is anything free to move?",
                                               file));
    default:
      throw Error(Exit::numerical, fmt::format("{}: the linear programme was not solved: residuals are left", file));
  }
}

void write_mechanism(const std::filesystem::path& file, const Assembled& assembled, const LimitResult& result) {
  VirtualMotion motion{"velocity", {}};
  for (std::size_t k = 0; k < assembled.drawn.size(); ++k) {
    const Wrench& v = result.velocity[k];
    auto& of_block = motion.displacement.emplace_back();
    for (const Vector& p : assembled.drawn[k].point)
      of_block.push_back(v.force + cross(v.moment, p - assembled.problem.blocks[k].centre));
  }
  write_motions(file, assembled.drawn, {motion});
}

void print(const LimitWithoutDilation& without) {
  if (without.settled)
    fmt::print("multiplier {:.5f} without dilation\n", without.multiplier);
  else
    fmt::print("no multiplier without dilation: iterations have not settled\n");
  for (const SettledLimit& start : without.start)
    fmt::print(
        "  from {}: {:.5f}, {} after {} problems; shear at most {:.2g} of the mean normal force beyond friction\n",
        start.from == "weight" ? "elastic forces under weight" : "associated forces", start.multiplier,
        start.settled ? "settled" : "not settled", start.problems, std::max(0.0, start.beyond));
  if (without.start.size() == 2 &&
      std::all_of(without.start.begin(), without.start.end(), [](const SettledLimit& s) { return s.settled; }) &&
      std::abs(without.start[0].multiplier - without.start[1].multiplier) > 0.01 * without.multiplier)
    fmt::print("  Both are states of the same masonry: normal forces hang on what has happened before\n");
}

nlohmann::ordered_json json_of(const LimitWithoutDilation& without) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const SettledLimit& start : without.start)
    json.push_back({{"from", start.from},
                    {"settled", start.settled},
                    {"multiplier", start.multiplier},
                    {"beyond_friction", start.beyond},
                    {"problems", start.problems}});
  return json;
}

void run(const Options& options) {
  const Scene scene = prepare_scene(options.scene);
  const Loads loads = loads_of(scene, options.direction);
  const Simulation simulation(scene, 1);
  const Assembled assembled = assemble(simulation, loads);
  const auto& blocks = assembled.problem.blocks;
  if (std::none_of(blocks.begin(), blocks.end(), [](const LimitBlock& b) { return b.fixed; }))
    throw Error(Exit::bad_input,
                fmt::format("{}: no block is fixed, so nothing holds the others; give one fixed = true", scene.file));

  const auto begin = std::chrono::steady_clock::now();
  LimitSettings settings;
  settings.facets = options.facets;
  const LimitResult result = limit_multiplier(assembled.problem, settings);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (result.status != LimitStatus::solved) refuse(scene.file, assembled, result);

  const std::size_t points = assembled.problem.points.size();
  fmt::print("{}: {} blocks, {} contact points, cones of {} facets\n", scene.file, blocks.size(), points,
             options.facets);
  fmt::print("multiplier {:.5f} of the weight along ({:g}, {:g}, {:g}), associated flow; gap {:.1e}; {:.2g} s\n",
             result.multiplier, loads.direction.x, loads.direction.y, loads.direction.z, result.gap, seconds);
  fmt::print("Sliding lifts by the friction angle here: an upper bound of what a run without dilation gives\n");
  std::optional<LimitWithoutDilation> without;
  if (!options.associated) without = limit_without_dilation(assembled.problem, settings);
  if (without) print(*without);
  if (options.out.empty()) return;

  const std::filesystem::path folder = options.out;
  make_folder(folder);
  nlohmann::ordered_json json;
  json["scene"] = scene.file;
  json["multiplier"] = result.multiplier;
  if (without && without->settled)
    json["multiplier_without_dilation"] = without->multiplier;
  else
    json["multiplier_without_dilation"] = nullptr;
  json["gap"] = result.gap;
  if (without) json["without_dilation"] = json_of(*without);
  json["direction"] = geometry::array(loads.direction);
  json["gravity_m_s2"] = geometry::array(loads.gravity);
  json["blocks"] = blocks.size(), json["contact_points"] = points, json["facets"] = options.facets;
  write_json(folder / "limit.json", json);
  std::string mechanism = "block,name,x_m,y_m,z_m,vx,vy,vz,spin_x,spin_y,spin_z\n";
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    const auto& [v, w] = result.velocity[k];
    const Vector& x = blocks[k].centre;
    mechanism += fmt::format("{},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}\n", k,
                             csv_text(assembled.names[k]), x.x, x.y, x.z, v.x, v.y, v.z, w.x, w.y, w.z);
  }
  write_file(folder / "mechanism.csv", mechanism);
  write_mechanism(folder / "mechanism.vtu", assembled, result);
  std::string forces = "point,block_a,block_b,x_m,y_m,z_m,normal_N,shear_s_N,shear_t_N\n";
  for (std::size_t i = 0; i < points; ++i) {
    const LimitPoint& p = assembled.problem.points[i];
    forces += fmt::format("{},{},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}\n", i, p.a, p.b, p.position.x,
                          p.position.y, p.position.z, result.force[i][0], result.force[i][1], result.force[i][2]);
  }
  write_file(folder / "forces.csv", forces);
  fmt::print("{}\n", (folder / "limit.json").string());
}

}  // namespace

void add_limit_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("limit", "Load multiplier at collapse by limit analysis, without a run");
  const auto options = std::make_shared<Options>();
  command->add_option("scene", options->scene.scene, "Scene file")->type_name("SCENE.toml")->required();
  command->add_option("--direction", options->direction, "Of the load that is multiplied, a share of the weight")
      ->type_name("X Y Z")
      ->expected(3);
  command->add_option("--facets", options->facets, "Of each friction cone, inscribed")->capture_default_str();
  command->add_flag("--associated", options->associated, "No search for the multiplier without dilation");
  command->add_option("--law", options->scene.law, "Law for all joints in place of the scene's");
  command->add_option("--set", options->scene.overrides, "dotted.key=value: set a key of the scene; may be repeated");
  command->add_option("--out", options->out, "Folder for limit.json, mechanism.csv, mechanism.vtu and forces.csv")
      ->type_name("DIR");
  command->footer(
      "Static theorem on the contact points of the scene: rigid blocks, brittle strength from the properties of the "
      "laws,\n"
      "associated flow; and by Gilbert's iteration without dilation, from two starts, of which the lower one counts.\n"
      "Gravity and direction are those of the first collapse stage.\n"
      "Examples:\n"
      "  quoin limit host/scenes/ferris_tin_loi_2.toml --out out/limit\n"
      "  quoin limit host/scenes/arch.toml --direction -1 0 0");
  command->callback([options] { run(*options); });
}

}  // namespace quoin
