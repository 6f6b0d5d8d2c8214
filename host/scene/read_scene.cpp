#include "scene/read_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "base/input_file.h"
#include "base/toml_text.h"
#include "scene/driven.h"
#include "scene/inline_toml.h"
#include "scene/quality.h"
#include "scene/read_masses.h"
#include "scene/read_scatter.h"
#include "scene/read_tables.h"
#include "scene/read_tests.h"
#include "scene/reader.h"

namespace quoin {

toml::table reader::parse(const std::string& text, const std::string& path) {
  refuse_unfit_toml(text, path);
  try {
    return toml::parse(text, path);
  } catch (const toml::parse_error& error) {
    throw Error(Exit::bad_input, fmt::format("{}:{}:{}: not valid TOML: {}", path, error.source().begin.line,
                                             error.source().begin.column, error.description()));
  }
}

using namespace reader;

Scene read_scene(const std::string& path, const std::vector<std::string>& overrides) {
  return read_scene_text(read_input_file(path), path, overrides);
}

Scene read_scene_text(const std::string& text, const std::string& path, const std::vector<std::string>& overrides) {
  Scene scene = reader::read_scene(parse(text, path), path, overrides);
  scene.text = text;
  return scene;
}

namespace {

// Adds the names under the keys material, unit_material and lintel_material of a table and of all tables in it.
void add_materials(const toml::node& node, std::set<std::string>& names, int depth = 0) {
  constexpr int kDeepest = 6;
  if (depth > kDeepest) return;
  if (const toml::table* table = node.as_table()) {
    for (auto&& [key, value] : *table) {
      const toml::node& below = value;
      const auto name = below.value<std::string>();
      if (name && key.str().ends_with("material")) names.insert(*name);
      add_materials(below, names, depth + 1);
    }
  } else if (const toml::array* list = node.as_array()) {
    for (const toml::node& element : *list) add_materials(element, names, depth + 1);
  }
}

// Materials of deformable blocks. Materials of rigid blocks alone need no stiffness.
std::set<std::string> zoned_materials(const toml::table& root) {
  std::set<std::string> names;
  if (const toml::node* building = root.get("building")) add_materials(*building, names);
  if (const toml::node* wall = root.get("wall"); wall && !root["wall"]["rigid_units"].value_or(false))
    add_materials(*wall, names);
  for (const char* kind : {"block", "dry_wall", "arch"}) {
    const toml::array* list = root[kind].as_array();
    for (std::size_t i = 0; list && i < list->size(); ++i) {
      const toml::table* table = list->get(i)->as_table();
      if (table && !(*table)["rigid"].value_or(true)) add_materials(*table, names);
    }
  }
  return names;
}

// Reads [contact], after the scene's blocks and its wall.
void read_contact_table(Table& c, Scene* scene) {
  if (bool cubic = false; c.boolean("cubic_points", cubic)) scene->cubic_points = cubic;
  if (scene->cubic_points && !scene->blocks && !(scene->wall && scene->wall->rigid_units))
    c.refuse("cubic_points", "only with wall.rigid_units = true: deformable units have their gridpoints; remove it");
  if (scene->blocks) read_contact(c, scene->solver, &scene->blocks->contact);
}

std::vector<Monitor> read_monitors(Table& scene) {
  std::vector<Monitor> monitors;
  scene.each("monitor", [&](Table& t) {
    Monitor m;
    t.text("name", m.name, "letters, digits, _ and -", true);
    t.text("block", m.block, "a block, body or floor", true);
    Vec3 point{};
    if (t.numbers("point", point, kPlace, "m")) m.point = point;
    t.text("below", m.below, "the name of another monitor, from which drifts count");
    m.source = {t.where("block")};
    const auto called = [&](const std::string& name) {
      return std::any_of(monitors.begin(), monitors.end(), [&](const Monitor& other) { return other.name == name; });
    };
    if (t.has("name") && !is_plain_name(m.name)) t.refuse("name", "letters, digits, _ and -, for columns");
    if (called(m.name) || m.name == "ground") t.refuse("name", "a name that no other monitor has, and not \"ground\"");
    if (std::ranges::any_of(monitors, [&](const Monitor& other) { return differ_by("_relative", m.name, other.name); }))
      t.refuse("name", "not NAME_relative beside NAME: columns of both would have the same names");
    if (!m.below.empty() && !called(m.below)) t.refuse("below", "the name of a monitor that is given before this one");
    monitors.push_back(m);
  });
  return monitors;
}

// Returns the quality named in the table, or the given one; null: none, for blocks of any shape.
const Quality* read_solver_table(Table solver, const Quality* quality, bool of_blocks, Scene* scene) {
  if (!of_blocks || solver.has("quality")) {
    std::vector<std::string> names;
    for (const Quality& q : qualities()) names.push_back(q.name);
    std::string name = "standard";
    solver.choice("quality", name, names);
    quality = &quality_named(name);
  }
  // Settings for motion beyond the bound of small displacements do not change results before it.
  const toml::table& keys = solver.toml();
  scene->quality_as_is = std::all_of(keys.begin(), keys.end(), [](const auto& entry) {
    const std::string_view key = entry.first.str();
    return key == "quality" || key == "large_motion" || key == "past_motion_bound" || key == "rotation_bound" ||
           key == "sliding_bound";
  });
  scene->solver = read_solver(std::move(solver), quality);
  // The errors of the quality were measured with small displacements.
  if (scene->solver.large_motion == LargeMotion::always) scene->quality_as_is = false;
  return quality;
}

void read_output(Table& o, bool of_blocks, OutputSettings* output) {
  o.integer("frames", output->frames, 0, 100000);
  o.choice("frames_of", output->all_stages, {{"all", true}, {"last", false}});
  o.number("frames_at_damage", output->frames_at_damage, between(0, 1), "");
  o.boolean("plots", output->plots);
  o.boolean("picture", output->plots);
  o.boolean("energy", output->energy);
  o.boolean("pieces", output->pieces);
  o.boolean("end_state", output->end_state);
  o.number("record_interval", output->record_interval, kNotNegative, "s");
  if (of_blocks) o.text("monitor", output->monitor, "the name of a block");
}

// Visits each table [kind.NAME], with its name.
template <class Read>
void each_named(Table& t, const char* kind, const Read& read) {
  t.within(
      kind, fmt::format("tables [{}.NAME]", kind),
      [&](Table& outer) {
        if (outer.toml().empty()) t.refuse(kind, fmt::format("at least one table [{}.NAME]", kind));
        for (auto&& [key, node] : outer.toml()) {
          const std::string name(key.str());
          outer.within(name, fmt::format("a table [{}.{}]", kind, name), [&](Table& inner) { read(name, inner); });
        }
      },
      true);
}

void read_settings(Table& t, bool of_blocks, Scene* scene) {
  const Quality* quality = of_blocks ? nullptr : &quality_named("standard");
  if (of_blocks) scene->output.energy = true;
  if (quality) scene->solver = quality->solver;
  if (const auto* table = t.table("solver", "a table [solver]")) {
    t.context().solver = table;
    quality = read_solver_table({t.context(), *table, "solver"}, quality, of_blocks, scene);
  }
  if (of_blocks) scene->quality_as_is = false;  // its errors were measured for walls
  if (quality) scene->quality = quality->name;
}

void read_materials_and_joints(Table& t, Scene* scene) {
  const std::set<std::string> zoned = zoned_materials(t.toml());
  each_named(t, "materials", [&](const std::string& name, Table& m) {
    scene->materials[name] = read_material(name, m, !zoned.contains(name));
  });
  each_named(t, "joints", [&](const std::string& name, Table& j) { scene->joints[name] = read_joint(name, j); });
  t.within("random", "a table [random]", [&](Table& r) { scene->random = read_random(r); });
  for (auto& [name, family] : scene->joints) family.random = scene->random;
}

// Reads a building, a wall, or blocks of any shape.
void read_masonry(Table& t, bool of_blocks, const std::string& folder, Scene* scene) {
  t.within("building", "a table [building]", [&](Table& b) { scene->building = read_building(b, *scene); });
  if (scene->building) scene->quality_as_is = false;  // its errors were measured for walls
  if (of_blocks) scene->blocks = read_blocks(t, *scene, folder);
  t.within(
      "wall", "a table [wall]", [&](Table& w) { scene->wall = read_wall(w, *scene); },
      !scene->building && !scene->blocks);
  t.within("contact", "a table [contact]", [&](Table& c) { read_contact_table(c, scene); });
  if (of_blocks && scene->solver.large_motion == LargeMotion::always) scene->blocks->contact.small_displacement = 0.0;
  if (of_blocks && scene->blocks->contact.small_displacement == 0.0) scene->solver.large_motion = LargeMotion::always;
  if (scene->wall && scene->building) t.refuse("wall", "one of [wall] and [building]; remove the other");
}

// Reads the initial state of masonry: masses, members, damage, end state of another run.
void read_start(Table& t, const std::string& folder, Scene* scene) {
  scene->masses = read_masses(t);
  if (scene->building) {
    for (AddedMass& of_floor : masses_of_floors(*scene->building)) scene->masses.push_back(std::move(of_floor));
  }
  if (!scene->masses.empty()) scene->quality_as_is = false;  // its errors were measured without them
  if (t.has("mass") && scene->wall && scene->wall->half_thickness)
    t.refuse("mass", "none with wall.half_thickness = true: masses have no half; make that false");
  scene->members = read_members(t, *scene);
  if (scene->members) scene->quality_as_is = false;  // its errors were measured without them
  t.each("damage", [&](Table& d) { scene->damage.push_back(read_damage(d, *scene)); });
  if (t.text("start", scene->start, "the folder of a run with output.end_state = true")) {
    if (!scene->start.starts_with('/')) scene->start = folder + scene->start;
    if (!scene->damage.empty()) t.refuse("start", "without [[damage]], which belongs to the run that ends there");
  }
}

void read_stages(Table& t, bool of_blocks, const std::string& folder, Scene* scene) {
  double pressure = 0.0;
  int index = 0;
  for (const auto* table : t.tables("stage", "tables [[stage]]", true)) {
    const Stage* previous = scene->stages.empty() ? nullptr : &scene->stages.back();
    Table stage_table(t.context(), *table, fmt::format("stage.{}", ++index));
    Stage stage = of_blocks ? read_block_stage(std::move(stage_table), *scene, previous, folder)
                            : read_stage(std::move(stage_table), *scene, previous, pressure, folder);
    if (!table->contains("direction") && !stage.cycles) stage.direction = default_direction(stage, *scene);
    if (stage.duration && scene->solver.selective_time_step > 0.1 * *stage.duration)
      t.context().fault(fmt::format(
          "{}: solver.selective_time_step = {:g} s: allowed: at most a tenth of the duration of each stage, "
          "here {:g} s",
          stage.source.text, scene->solver.selective_time_step, *stage.duration));
    if (of_blocks && scene->building) add_floor_loads(stage, *scene->building);
    scene->stages.push_back(std::move(stage));
  }
}

// Makes 1 and 1.0 equal.
void make_numbers_real(toml::node& node) {
  if (toml::table* const table = node.as_table()) {
    for (auto&& [key, value] : *table) {
      if (const auto* number = value.as_integer())
        table->insert_or_assign(key, static_cast<double>(number->get()));
      else
        make_numbers_real(value);
    }
  }
  toml::array* const array = node.as_array();
  for (std::size_t i = 0; array && i < array->size(); ++i) {
    if (const auto* number = (*array)[i].as_integer())
      array->replace(array->cbegin() + static_cast<std::ptrdiff_t>(i), static_cast<double>(number->get()));
    else
      make_numbers_real((*array)[i]);
  }
}

// Keys of a table, and of those within it, that name joint families.
std::string named_joints(const toml::node& node) {
  std::string text;
  if (const toml::array* const array = node.as_array()) {
    for (const toml::node& element : *array) text += named_joints(element);
  }
  if (const toml::table* const table = node.as_table()) {
    for (auto&& [key, value] : *table) {
      const bool is_name = key.str().ends_with("_joint") && value.is_string();
      text += is_name ? fmt::format("{} = {}, ", key.str(), inline_toml(value)) : named_joints(value);
    }
  }
  return text;
}

std::map<std::string, std::string> arrangement_of(const toml::table& root) {
  std::map<std::string, std::string> text;
  for (const char* name :
       {"contact", "joint_rule", "default_joint", "tie", "spring", "strip", "floor", "beam", "dowel", "fill"}) {
    text[name] = "none";
    const toml::node* const node = root.get(name);
    if (!node) continue;
    toml::table alone;
    node->visit([&](const auto& value) { alone.insert(name, value); });
    make_numbers_real(alone);
    text[name] = inline_toml(*alone.get(name));
  }
  std::string& fixed = text["list of fixed blocks"];
  if (const toml::array* blocks = root["block"].as_array()) {
    for (const toml::node& block : *blocks) {
      const toml::table* const table = block.as_table();
      fixed += table && (*table)["fixed"].value_or(false) ? "fixed " : "free ";
    }
  }
  for (const char* name : {"wall", "building", "dry_wall", "arch"}) {
    const toml::node* const node = root.get(name);
    text[fmt::format("choice of joints in {}", name)] = node ? named_joints(*node) : "none";
  }
  return text;
}

}  // namespace

Scene reader::read_scene(toml::table root, const std::string& path, const std::vector<std::string>& overrides) {
  Context context;
  context.file = path;
  for (const std::string& setting : overrides) {
    try {
      apply_override(root, setting, context);
    } catch (const Error& error) {
      context.fault(error.what());
    }
  }
  Scene scene;
  scene.file = path;
  scene.derivation = fill_in_from_tests(root, context);
  scene.arrangement = arrangement_of(root);
  const bool of_blocks = root.contains("block") || root.contains("dry_wall") || root.contains("arch");
  const std::string folder = path.substr(0, path.rfind('/') == std::string::npos ? 0 : path.rfind('/') + 1);
  Table t(context, root, "");
  t.text("title", scene.title, "text");
  scene.monitors = read_monitors(t);
  read_settings(t, of_blocks, &scene);
  read_materials_and_joints(t, &scene);
  read_masonry(t, of_blocks, folder, &scene);
  read_start(t, folder, &scene);
  t.within("output", "a table [output]", [&](Table& o) { read_output(o, of_blocks, &scene.output); });
  read_stages(t, of_blocks, folder, &scene);
  t.finish();
  scene.inputs = std::move(context.inputs);
  if (const std::string faults = context.faults(); !faults.empty()) throw SceneFaults(faults, std::move(scene));
  return scene;
}

}  // namespace quoin
