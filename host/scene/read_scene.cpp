#include "scene/read_scene.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "base/error.h"
#include "base/input_file.h"
#include "base/toml_text.h"
#include "scene/generate.h"
#include "scene/quality.h"
#include "scene/read_actions.h"
#include "scene/read_blocks.h"
#include "scene/read_building.h"
#include "scene/read_cycles.h"
#include "scene/read_damage.h"
#include "scene/read_masses.h"
#include "scene/read_members.h"
#include "scene/read_monitors.h"
#include "scene/read_opening.h"
#include "scene/read_scatter.h"
#include "scene/read_tests.h"
#include "scene/reader.h"

namespace quoin {

namespace reader {

namespace {

DampingKind read_damping(Table& t, DampingKind damping) {
  const std::map<std::string, DampingKind> kinds = {{"none", DampingKind::none},
                                                    {"local", DampingKind::local},
                                                    {"viscous", DampingKind::viscous},
                                                    {"block", DampingKind::block},
                                                    {"impact", DampingKind::impact}};
  std::vector<std::string> names;
  for (const auto& [name, kind] : kinds) names.push_back(name);
  std::string chosen;
  t.choice("damping", chosen, names);
  return kinds.contains(chosen) ? kinds.at(chosen) : damping;
}

void read_large_motion(Table& t, SolverSettings* s) {
  const std::map<std::string, LargeMotion> kinds = {
      {"automatic", LargeMotion::automatic}, {"never", LargeMotion::never}, {"always", LargeMotion::always}};
  std::string chosen;
  t.choice("large_motion", chosen, {"automatic", "never", "always"});
  if (kinds.contains(chosen)) s->large_motion = kinds.at(chosen);
  t.number("rotation_bound", s->motion_bound.rotation, kPositive, "rad");
  t.number("sliding_bound", s->motion_bound.sliding, kPositive, "of the length of a joint");
  std::string past = "stop";
  if (t.choice("past_motion_bound", past, {"stop", "warn"}) && s->large_motion != LargeMotion::never)
    t.refuse("past_motion_bound", "only with large_motion = \"never\"; remove it, or change large_motion");
  s->motion_bound.stop = past == "stop";
}

void read_kernels(Table& t, SolverSettings* s) {
  const std::map<std::string, Kernels> kinds = {
      {"automatic", Kernels::automatic}, {"lattice", Kernels::lattice}, {"general", Kernels::general}};
  std::string chosen;
  t.choice("kernels", chosen, {"automatic", "lattice", "general"});
  if (kinds.contains(chosen)) s->kernels = kinds.at(chosen);
  if (s->kernels == Kernels::lattice && s->large_motion == LargeMotion::always)
    t.refuse("kernels", "\"automatic\" or \"general\" with large_motion = \"always\", which the lattice does not have");
}

}  // namespace

namespace {

// What a stage may change: damping and the fraction of the time step.
void read_damping_keys(Table& t, SolverSettings& s) {
  const auto only_with = [&](const char* key, std::initializer_list<DampingKind> allowed, const char* text) {
    if (std::find(allowed.begin(), allowed.end(), s.damping) == allowed.end())
      t.refuse(key, fmt::format("only with damping = {}; remove it, or change damping", text));
  };
  if (t.number("local_damping", s.local_damping, between(0, 0.99), "(gamma of eq. 1)"))
    only_with("local_damping", {DampingKind::local, DampingKind::block}, "\"local\" or \"block\"");
  if (t.has("settling_damping")) {
    s.settling_damping = s.local_damping;
    t.number("settling_damping", *s.settling_damping, between(0, 0.99), "(gamma of stages that run to equilibrium)");
    only_with("settling_damping", {DampingKind::local, DampingKind::block}, "\"local\" or \"block\"");
  }
  if (t.number("mass_damping", s.mass_damping, kNotNegative, "1/s"))
    only_with("mass_damping", {DampingKind::viscous}, "\"viscous\"");
  if (t.number("stiffness_damping", s.stiffness_damping, kNotNegative, "s"))
    only_with("stiffness_damping", {DampingKind::viscous}, "\"viscous\"");
  if (t.number("impact_damping", s.impact_damping, between(0, 2), "(of critical, of a block that lands on an edge)"))
    only_with("impact_damping", {DampingKind::impact}, "\"impact\"");
  const bool flat =
      t.number("maxwell_damping", s.maxwell_damping, between(0, 0.05), "(damping ratio within maxwell_band)");
  if (flat) only_with("maxwell_damping", {DampingKind::impact}, "\"impact\"");
  if (t.boolean("implicit_contacts", s.implicit_contacts) && s.implicit_contacts) {
    only_with("implicit_contacts", {DampingKind::impact}, "\"impact\"");
    if (s.maxwell_damping > 0.0) t.refuse("implicit_contacts", "false with maxwell_damping, or that without this");
  }
  constexpr double kNarrowest = 10.0, kWidest = 100.0;  // where three elements keep the ratio flat
  if (t.numbers("maxwell_band", s.maxwell_band, kPositive, "Hz (lowest and highest frequency)")) {
    const double width = s.maxwell_band[1] / s.maxwell_band[0];
    if (!(width >= kNarrowest && width <= kWidest))
      t.refuse("maxwell_band",
               fmt::format("two frequencies, the second {:g} to {:g} times the first, Hz", kNarrowest, kWidest));
    if (s.maxwell_damping == 0.0) t.refuse("maxwell_band", "only with maxwell_damping; remove it, or give that");
  }
  if (t.number("deformation_damping", s.deformation_damping, between(0, 1), "(damping ratio at omega_max)"))
    only_with("deformation_damping", {DampingKind::block}, "\"block\"");
  t.number("time_step_fraction", s.time_step_fraction, above_to(0, 1),
           "of the critical time step (0.6 of 2/omega_max is sound)");
}

void read_inertia(Table& t, SolverSettings& s) {
  t.number("mass_scaling", s.mass_scaling, between(1, 1e9), "times the true inertia");
  t.number("selective_time_step", s.selective_time_step, kNotNegative, "s (0: none)");
  t.number("deformation_inertia", s.deformation_inertia, between(1, 1e6), "times the true inertia against deformation");
  t.number("unit_inertia", s.unit_inertia, between(1, 1e6),
           "times the true inertia against motion of the halves of a unit on each other");
  for (const auto& [key, factor] :
       {std::pair{"deformation_inertia", s.deformation_inertia}, std::pair{"unit_inertia", s.unit_inertia}}) {
    if (factor == 1.0) continue;
    if (s.selective_time_step > 0.0)
      t.refuse(key, "1 with selective_time_step, which has its own way to raise the step; use one");
    if (s.damping == DampingKind::local)
      t.refuse(key,
               "1 with damping = \"local\": slow vibrations inside units would brake their motion (a wall came out "
               "15 % too strong); use damping = \"block\"");
  }
}

}  // namespace

SolverSettings read_solver(Table t, const Quality* quality) {
  SolverSettings s;
  const DampingKind usual = quality ? quality->solver.damping : s.damping;
  const DampingKind damping = read_damping(t, usual);
  // The settings of a quality go together; with another damping, or another way to raise the step, they prove nothing.
  if (quality && damping == usual && !t.has("selective_time_step")) s = quality->solver;
  s.damping = damping;
  read_damping_keys(t, s);
  read_inertia(t, s);
  read_large_motion(t, &s);
  read_kernels(t, &s);
  std::string critical = "assembled";
  t.choice("critical_time_step", critical, {"assembled", "nodal"});
  if (critical == "nodal") {
    s.critical_time_step = CriticalTimeStep::nodal;
    if (s.selective_time_step > 0.0 || s.deformation_inertia != 1.0 || s.unit_inertia != 1.0)
      t.refuse("critical_time_step",
               "\"assembled\" where inertia is raised, of which eq. 3 knows nothing; for \"nodal\" take damping = "
               "\"local\", or deformation_inertia = 1 and unit_inertia = 1, and no selective_time_step");
  }
  const std::map<std::string, InternalForces> ways = {{"automatic", InternalForces::automatic},
                                                      {"assembled", InternalForces::assembled},
                                                      {"zones", InternalForces::zones}};
  std::string way = "automatic";
  t.choice("internal_forces", way, {"automatic", "assembled", "zones"});
  if (ways.contains(way)) s.internal_forces = ways.at(way);
  t.boolean("skip_resting_bodies", s.skip_resting_bodies);
  t.finish();
  return s;
}

SolverSettings read_solver_of_stage(Table t, const SolverSettings& before, bool moves_ground) {
  SolverSettings s = before;
  s.damping = read_damping(t, before.damping);
  read_damping_keys(t, s);
  if (moves_ground) {
    t.number("deformation_inertia", s.deformation_inertia, between(1, 1e6), "times the true inertia");
    t.number("unit_inertia", s.unit_inertia, between(1, 1e6), "times the true inertia");
    double scaling = before.mass_scaling;
    if (t.number("mass_scaling", scaling, kPositive, "") && scaling != before.mass_scaling)
      t.refuse("mass_scaling", fmt::format("that of [solver], {:g}: it is of the whole run", before.mass_scaling));
  }
  for (const char* key : {"mass_scaling", "selective_time_step", "deformation_inertia", "unit_inertia"}) {
    t.accept(key);
    if (t.has(key) && (!moves_ground || key == std::string_view("selective_time_step")))
      t.refuse(key, "not in a stage: inertia is of the whole run; give it in [solver]");
  }
  if (s.damping == DampingKind::local && (s.deformation_inertia != 1.0 || s.unit_inertia != 1.0))
    t.refuse("damping",
             "damping other than \"local\" with solver.deformation_inertia or unit_inertia above 1: slow vibrations of "
             "blocks would brake their motion");
  t.finish();
  return s;
}

namespace {

// What a stage that moves the ground has for what it does not say: damping of impacts, true inertia. What [solver]
// writes against that is refused unless the stage repeats it.
SolverSettings settings_on_ground(Table& t, const toml::table* own, const SolverSettings& before) {
  SolverSettings s = before;
  const auto written = [&](const char* key) {
    const bool given = t.context().solver && t.context().solver->contains(key) && !(own && own->contains(key));
    if (given)
      t.context().fault(
          fmt::format("{}: the stage moves the ground, and solver.{} = {} would falsify its motion; remove "
                      "it there, or repeat it in the solver table of the stage",
                      t.where(), key, text_of(*t.context().solver->get(key))));
    return given;
  };
  const bool on_motion = s.damping == DampingKind::local || s.damping == DampingKind::block;
  const bool says = own && own->contains("damping");
  if (on_motion && !says && s.local_damping > 0.0 && !written("damping") && !written("local_damping"))
    s.damping = DampingKind::impact;
  if (s.deformation_inertia != 1.0 && !written("deformation_inertia")) s.deformation_inertia = 1.0;
  if (s.unit_inertia != 1.0 && !written("unit_inertia")) s.unit_inertia = 1.0;
  if (s.mass_scaling != 1.0) written("mass_scaling");
  return s;
}

}  // namespace

void read_stage_solver(Table& t, Stage& stage, const Scene& scene) {
  const auto* own = t.table("solver", "a table: damping and time_step_fraction from this stage on");
  const SolverSettings& before = scene.solver_in(scene.stages.size());
  const SolverSettings base = stage.ground ? settings_on_ground(t, own, before) : before;
  const bool differs = base.damping != before.damping || base.deformation_inertia != before.deformation_inertia ||
                       base.unit_inertia != before.unit_inertia;
  if (own)
    stage.solver = read_solver_of_stage({t.context(), *own, t.path("solver")}, base, stage.ground.has_value());
  else if (differs)
    stage.solver = base;
}

BlockMaterial read_material(const std::string& name, Table t, bool rigid) {
  BlockMaterial m;
  m.name = name;
  t.number("young_modulus", m.young_modulus, kPositive, "Pa", !rigid);
  t.number("poisson_ratio", m.poisson_ratio, between(0, 0.49), "", !rigid);
  t.number("density", m.density, kPositive, "kg/m3", true);
  t.finish();
  return m;
}

// Everything but the host's own keys is a property of the law, which alone can judge it.
JointFamily read_joint(const std::string& name, Table t) {
  JointFamily family;
  family.name = name;
  family.source = {t.where()};
  t.text("law", family.law, "the name of a law (see `quoin models`) or the path of a library", true);
  t.text("initial_state", family.initial_state, "an initial state of the law, as bonded or dry");
  family.initial_state_source = {t.has("initial_state") ? t.where("initial_state") : t.where() + ".initial_state"};
  t.number("missing_mortar", family.missing_mortar, between(0, 1), "(share of the joints)");
  for (auto&& [key, node] : t.toml()) {
    PropertySetting p;
    p.id = std::string(key.str());
    if (p.id == "law" || p.id == "initial_state" || p.id == "missing_mortar" || p.id == "correlation") continue;
    t.accept(p.id);
    p.source = {t.where(p.id)};
    const char* allowed = "a number (not nan), a list of numbers, a word, or a distribution";
    const toml::node& given = node;  // a lambda captures no structured binding
    // What is allowed is for the law to say; not a number is allowed nowhere.
    const auto add = [&](const toml::node& number) {
      const std::optional<double> value = number_of(number);
      if (!value)
        t.wrong_type(p.id, given, allowed);
      else if (std::isnan(*value))
        t.refuse(p.id, allowed);
      else
        p.numbers.push_back(*value);
    };
    if (node.is_number()) {
      add(node);
    } else if (const auto word = node.template value<std::string>()) {
      p.text = *word;
    } else if (const toml::table* table = node.as_table()) {
      p.scatter = read_scatter(Table(t.context(), *table, t.path(p.id)));
      if (p.scatter->distribution.fault().empty()) p.numbers = {random::Sampler(p.scatter->distribution).mean()};
    } else if (const toml::array* list = node.as_array()) {
      for (const toml::node& element : *list) {
        // Pairs may be written flat, [0, 1, 1, 0], or nested, [[0, 1], [1, 0]].
        const toml::array* pair = element.as_array();
        if (!pair) {
          add(element);
        } else if (pair->size() == 2) {
          for (const toml::node& number : *pair) add(number);
        } else {
          t.wrong_type(p.id, node, "a list of pairs, as [[0, 1], [0.3, 0.5], [1, 0]]");
        }
      }
    } else {
      t.wrong_type(p.id, node, allowed);
    }
    family.properties.push_back(std::move(p));
  }
  read_correlation(t, family);
  t.finish();
  return family;
}

void read_stage_basics(Table& t, Stage& stage, const Stage* previous) {
  t.text("name", stage.name, "text, as \"precompression\"");
  if (previous) stage.gravity = previous->gravity;
  t.numbers("gravity", stage.gravity, kAny, "m/s2");
  t.number("ramp_time", stage.ramp_time, kNotNegative, "s");
  t.number("duration", stage.duration, kPositive, "s");
  t.integer("max_steps", stage.max_steps, 1, 1000000000000L);
  t.integer("record_interval", stage.record_interval, 0, 1000000000L);
  if (int frames = 0; t.integer("frames", frames, 0, 100000)) stage.frames = frames;
  t.number("equilibrium_ratio", stage.equilibrium_ratio, above_to(0, 1), "(unbalanced/mean contact force)");
}

void read_rest(Table& t, Stage& stage) {
  if (t.has("ramp_time")) t.refuse("ramp_time", "none with kind = \"rest\": its loads act at once, and nothing swings");
  if (t.has("duration"))
    t.refuse("duration", "none with kind = \"rest\": it ends in equilibrium, by equilibrium_ratio");
  stage.ramp_time = 0.0;
  if (!t.has("equilibrium_ratio")) stage.equilibrium_ratio = 1e-4;
  if (!t.has("max_steps")) stage.max_steps = 1000000;
}

void read_monitor(Table& t, Stage& stage, const std::vector<std::string>* bodies) {
  t.number("displacement", stage.displacement, kPositive, "m");
  if (bodies)
    t.choice("monitor", stage.monitor, *bodies);
  else
    t.text("monitor", stage.monitor, "the name of a block");
  std::string direction = "x";
  t.choice("direction", direction, {"x", "y", "z"});
  stage.direction = direction[0] - 'x';
}

void read_law_swaps(Table& t, const Scene& scene, Stage& stage) {
  const std::string allowed = "a law for all joint families, or a table { family = \"law\" }";
  const toml::node* law = t.find("law", allowed, false);
  if (!law) return;
  if (const toml::table* swaps = law->as_table()) {
    Table s(t.context(), *swaps, t.path("law"));
    for (const auto& [family, settings] : scene.joints) {
      std::string name;
      if (s.text(family, name, "the name or path of a law")) stage.law_swaps[family] = name;
    }
    s.finish();
  } else if (const auto name = law->value<std::string>()) {
    for (const auto& [family, settings] : scene.joints) stage.law_swaps[family] = *name;
  } else {
    t.wrong_type("law", *law, allowed);
  }
}

namespace {

// What an element of a list answers to: its name; a stage without one has that of its kind, others that of their list.
std::string called(const toml::node& element, const std::string& list) {
  const toml::table* table = element.as_table();
  if (!table) return "";
  if (const auto name = (*table)["name"].value<std::string>()) return *name;
  if (list == "stage") return (*table)["kind"].value_or(std::string("stage"));
  return list == "dry_wall" ? "wall" : list == "arch" ? "arch" : "";
}

bool is_called(const toml::node& element, const std::string& list, const std::string& name) {
  return called(element, list) == name;
}

std::string names_in(const toml::array& elements, const std::string& list) {
  std::string names;
  for (const toml::node& element : elements) {
    if (const std::string name = called(element, list); !name.empty())
      names += fmt::format("{}'{}'", names.empty() ? " (" : ", ", name);
  }
  return names.empty() ? "" : names + ")";
}

}  // namespace

void apply_override(toml::table& root, const std::string& setting, Context& context) {
  const size_t equals = setting.find('=');
  const std::string path = setting.substr(0, equals);
  auto fail = [&](const std::string& why) {
    throw Error(Exit::bad_input, fmt::format("--set {}: {}; write --set dotted.key=value", setting, why));
  };
  if (equals == std::string::npos || path.empty()) fail("no key or no value");

  std::vector<std::string> keys;
  for (std::stringstream stream(path); stream.good();) std::getline(stream, keys.emplace_back(), '.');
  if (keys.size() > static_cast<size_t>(kMostKeyParts))
    fail(fmt::format("the key has more than {} parts", kMostKeyParts));
  toml::node* node = &root;
  std::string resolved;
  for (size_t i = 0; i < keys.size(); ++i) {
    const bool last = i + 1 == keys.size();
    if (keys[i].empty()) fail("an empty key");
    if (toml::array* list = node->as_array()) {
      size_t index = list->size();
      for (size_t j = 0; j < list->size(); ++j) {
        const bool named = is_called(*list->get(j), keys[i - 1], keys[i]);
        if (std::to_string(j + 1) != keys[i] && !named) continue;
        if (index < list->size())
          fail(fmt::format("'{}' fits elements {} and {} of the list {}; use the number", keys[i], index + 1, j + 1,
                           resolved));
        index = j;
      }
      if (index == list->size() || last)
        fail(fmt::format(
            "'{}' is no element of the list {}, which has {}{}; count from 1 or use its name, and add a key", keys[i],
            resolved, list->size(), names_in(*list, keys[i - 1])));
      resolved += "." + std::to_string(index + 1);
      node = list->get(index);
      continue;
    }
    toml::table* table = node->as_table();
    if (!table) fail(fmt::format("{} is not a table", resolved));
    resolved += (resolved.empty() ? "" : ".") + keys[i];
    if (!last) {
      node = table->get(keys[i]);
      if (!node) node = &table->insert(keys[i], toml::table{}).first->second;
      continue;
    }
    const std::string value = setting.substr(equals + 1);
    try {
      refuse_unfit_toml(value, keys[i]);
      toml::table parsed = toml::parse("value = " + value);
      if (parsed.size() != 1) throw Error(Exit::bad_input, "");
      parsed.get("value")->visit([&](auto& v) { table->insert_or_assign(keys[i], std::move(v)); });
    } catch (const std::exception&) {
      table->insert_or_assign(keys[i], value);  // not TOML: a plain word
    }
    context.overridden.insert(resolved);
  }
}

toml::table parse(const std::string& text, const std::string& path) {
  refuse_unfit_toml(text, path);
  try {
    return toml::parse(text, path);
  } catch (const toml::parse_error& error) {
    throw Error(Exit::bad_input, fmt::format("{}:{}:{}: not valid TOML: {}", path, error.source().begin.line,
                                             error.source().begin.column, error.description()));
  }
}

}  // namespace reader

using namespace reader;

namespace {

WallSpec read_wall(Table t, const Scene& scene) {
  WallSpec w;
  t.choice("bond", w.bond, {"running", "stack"});
  t.choice("first_course", w.first_course, {"whole", "half"});
  const bool has_courses = t.integer("courses", w.courses, 1, 10000, true);
  bool has_units = t.number("units_per_course", w.units_per_course, between(0.5, 10000), "units, in halves", true);
  if (has_units && 2 * w.units_per_course != std::floor(2 * w.units_per_course)) {
    t.refuse("units_per_course", "a multiple of 0.5, as units are cut in half at most");
    has_units = false;
  }
  const bool has_unit = t.numbers("unit", w.unit, above_to(0, 100), "m (length, height, thickness)", true);
  t.numbers("zones", w.zones, between(1, 64), "hexahedra per half unit along x, y, z");
  t.boolean("mid_unit_joints", w.mid_unit_joints);
  t.boolean("rigid_units", w.rigid_units);
  if (w.rigid_units && t.has("zones")) t.refuse("zones", "only with deformable units; remove it, or rigid_units");
  t.boolean("half_thickness", w.half_thickness);
  if (w.half_thickness && w.zones[2] % 2 != 0)
    t.refuse("half_thickness", "true only with an even number of zones along z");
  t.boolean("bottom_beam", w.bottom_beam);
  t.boolean("top_beam", w.top_beam);
  t.number("beam_height", w.beam_height, kPositive, "m");
  t.number("load_height", w.load_height, kNotNegative, "m above the foot of the wall");
  if (w.load_height && !w.top_beam) t.refuse("load_height", "only with top_beam = true, on which it acts");
  if (w.load_height &&
      (scene.solver.large_motion != LargeMotion::never || scene.solver.kernels == Kernels::general || scene.blocks))
    t.refuse("load_height",
             "only in small displacements, without blocks of other shapes: solver.large_motion = \"never\", "
             "solver.kernels = \"automatic\"");
  t.number("beam_density", w.beam_density, kPositive, "kg/m3");

  // Names of materials and families must exist.
  auto name_of = [&](const char* key, std::string& name, const auto& known, const char* kind, bool required) {
    std::vector<std::string> names;
    for (const auto& [known_name, value] : known) names.push_back(known_name);
    const std::string allowed = fmt::format("a name among [{}.*]: {}", kind, names.empty() ? "none yet" : join(names));
    if (t.text(key, name, allowed, required) && !known.contains(name))
      t.refuse(key, allowed + did_you_mean(name, names));
  };
  std::vector<double> cuts;
  const std::string inside = has_units ? fmt::format("1 to {:g}", 2 * w.units_per_course - 1) : "1 on";
  if (t.numbers("bottom_beam_cuts", cuts, kPositive, "half units from the left")) {
    for (const double cut : cuts) {
      const int last = w.bottom_beam_cuts.empty() ? 0 : w.bottom_beam_cuts.back();
      if (cut == std::floor(cut) && cut > last && (!has_units || cut < 2 * w.units_per_course))
        w.bottom_beam_cuts.push_back(static_cast<int>(cut));
      else
        t.refuse("bottom_beam_cuts", fmt::format("whole half units that grow, {}, where the beam is cut", inside));
    }
    if (!w.bottom_beam) t.refuse("bottom_beam_cuts", "only with bottom_beam = true");
  }
  const bool beams = w.bottom_beam || w.top_beam;
  name_of("unit_material", w.unit_material, scene.materials, "materials", true);
  name_of("bed_joint", w.bed_joint, scene.joints, "joints", true);
  name_of("head_joint", w.head_joint, scene.joints, "joints", true);
  name_of("unit_joint", w.unit_joint, scene.joints, "joints", w.mid_unit_joints);
  name_of("beam_joint", w.beam_joint, scene.joints, "joints", beams);

  w.openings = read_openings(t,
                             {has_units ? static_cast<int>(2 * w.units_per_course) : 0, has_courses ? w.courses : 0,
                              has_unit ? w.unit[0] / 2 : 0},
                             scene.materials);
  const Lattice lattice{has_units ? static_cast<int>(2 * w.units_per_course) : 0, has_courses ? w.courses : 0, 0};
  w.changed = read_changed(t, lattice, w.openings, scene.materials);
  t.finish();
  return w;
}

// Deformable blocks that can be loaded.
std::vector<std::string> loaded_names(const Scene& scene) {
  std::vector<std::string> names;
  if (!scene.building) return names;
  for (const BuildingSpec::Floor& floor : scene.building->floors) {
    if (floor.rigid) continue;
    for (const std::string& body : floor.bodies()) names.push_back(body);
  }
  return names;
}

// What the wall offers to be moved.
std::vector<std::string> body_names(const Scene& scene) {
  std::vector<std::string> names;
  if (scene.building) {
    names.push_back("bottom_beam");
    for (const BuildingSpec::Floor& floor : scene.building->floors) {
      if (!floor.rigid) continue;
      for (const std::string& body : floor.bodies()) names.push_back(body);
    }
  }
  if (scene.wall) names = scene.wall->bottom_beams();
  if (scene.wall && scene.wall->top_beam) names.push_back("top_beam");
  if (scene.wall && scene.wall->rigid_units) names.insert(names.end(), {"bottom_course", "top_course"});
  return names;
}

BodyControl read_control(Table t, std::vector<std::string> bodies, const std::vector<std::string>& loaded) {
  BodyControl c;
  bodies.insert(bodies.end(), loaded.begin(), loaded.end());
  t.choice("body", c.body, bodies, true);
  t.velocity(c, false);
  bool held = true;
  t.boolean("rotation_held", held);
  c.may_turn = !held;
  if (t.numbers("force", c.force, kAny, "N")) {
    for (size_t i = 0; i < 3; ++i) {
      if (c.force[i] != 0.0 && c.kind[i] == DofKind::velocity)
        t.refuse("force", "0 along components whose velocity is prescribed; make them \"free\" in velocity");
    }
  }
  if (std::find(loaded.begin(), loaded.end(), c.body) != loaded.end() &&
      std::find(c.kind.begin(), c.kind.end(), DofKind::velocity) != c.kind.end())
    t.refuse("body",
             "a rigid body, or velocity = [\"free\", \"free\", \"free\"]: half units of a floor without "
             "rigid_beams can be loaded but not moved");
  t.finish();
  return c;
}

void read_controls(Table& t, Stage& stage, const std::vector<std::string>& bodies, const Scene& scene) {
  for (size_t i = 0; const toml::table* table : t.tables("control", "tables [[stage.control]]"))
    stage.controls.push_back(read_control(Table(t.context(), *table, fmt::format("{}.{}", t.path("control"), ++i)),
                                          bodies, loaded_names(scene)));
}

// The controls that the short kinds of stage stand for: bottom beam held, top beam pressed or moved.
void add_beam_controls(Stage& stage, const std::vector<std::string>& bodies, double top_force, bool top_free,
                       double top_velocity) {
  for (const std::string& body : bodies) {
    if (!body.starts_with("bottom_beam")) continue;
    BodyControl bottom;
    bottom.body = body;
    stage.controls.push_back(bottom);
  }
  BodyControl top;
  top.body = "top_beam";
  if (top_free) {
    top.kind[1] = DofKind::free;
    top.force[1] = -top_force;
  }
  top.velocity[0] = top_velocity;
  stage.controls.push_back(top);
}

// What holds and loads the bodies of a stage with forces, pressures, ground motion or collapse that no table of it
// controls. The lower beam is the ground, the upper one is free under the pressure of the stages before, floors have
// their loads.
void add_loads_of_before(Stage& stage, const Scene& scene, const std::vector<std::string>& bodies, double top_force) {
  const auto controlled = [&](const std::string& body) {
    return std::any_of(stage.controls.begin(), stage.controls.end(),
                       [&](const BodyControl& c) { return c.body == body; });
  };
  const bool top = std::find(bodies.begin(), bodies.end(), "top_beam") != bodies.end();
  if (top && top_force > 0.0 && !controlled("top_beam")) {
    BodyControl& control = stage.controls.emplace_back();
    control.body = "top_beam";
    control.kind.fill(DofKind::free);
    control.may_turn = true;
    control.force[1] = -top_force;
  }
  if (scene.building) add_floor_loads(stage, *scene.building);
}

// A custom stage: controls and actions.
void read_custom(Table& t, Stage& stage, const Scene& scene, std::vector<std::string> bodies, double top_force,
                 const std::string& folder) {
  read_controls(t, stage, bodies, scene);
  const std::vector<std::string> held = bodies, loaded = loaded_names(scene);
  bodies.insert(bodies.end(), loaded.begin(), loaded.end());
  read_actions(t, stage, folder, bodies);
  const bool acts = !stage.beyond_lattice().empty();
  if (acts) read_stage_solver(t, stage, scene);
  if (acts && stage.monitor.empty() && scene.building && !scene.building->floors.empty()) {
    const std::vector<std::string> beams = scene.building->floors.back().bodies();
    if (!beams.empty()) stage.monitor = beams.front();  // none where half_units was refused
  }
  read_monitor(t, stage, acts ? &bodies : &held);
  if (acts) add_loads_of_before(stage, scene, held, top_force);
  if (!stage.equilibrium_ratio && !stage.displacement && !stage.duration && !stage.collapse &&
      !t.has("equilibrium_ratio") && !t.has("displacement") && !t.has("duration") && !t.has("collapse"))
    t.context().fault(t.where() +
                      ": the stage never ends; give equilibrium_ratio, displacement (m), duration (s) or collapse");
  if (stage.displacement && stage.monitor.empty())
    t.refuse("displacement", "only with a monitor body to measure; give monitor");
}

Stage read_stage(Table t, Scene& scene, const Stage* previous, double& pressure, const std::string& folder) {
  const Quality& quality = quality_named(scene.quality);
  Stage stage;
  stage.source = {t.where()};
  const std::vector<std::string> bodies = body_names(scene);
  std::string kind = "custom";
  const std::vector<std::string> kinds =
      scene.building ? std::vector<std::string>{"weight", "rest", "push", "cycles", "custom"}
                     : std::vector<std::string>{"pressure", "rest", "shear", "cycles", "custom"};
  const bool acts = has_actions(t) && !t.has("kind");
  const bool kind_known = t.choice("kind", kind, kinds, !acts) || acts;
  stage.name = stage.kind = kind;
  read_stage_basics(t, stage, previous);

  const bool top = std::find(bodies.begin(), bodies.end(), "top_beam") != bodies.end();
  stage.monitor = top ? "top_beam" : "";
  if (kind == "pressure" || kind == "shear" || (kind == "rest" && t.has("pressure"))) {
    if (!top && scene.wall) t.refuse("kind", "pressure and shear need a top beam to act on: wall.top_beam = true");
  }
  const double area = scene.wall ? bed_area(*scene.wall) / (scene.wall->half_thickness ? 2.0 : 1.0) : 0.0;
  if (kind == "pressure") {
    t.number("pressure", pressure, kNotNegative, "Pa (downwards on the gross bed area)", true);
    if (!t.has("ramp_time")) stage.ramp_time = 0.005;
    if (!t.has("equilibrium_ratio") && !stage.duration) stage.equilibrium_ratio = quality.equilibrium_ratio;
    if (!t.has("max_steps")) stage.max_steps = 1000000;
    add_beam_controls(stage, bodies, pressure * area, true, 0.0);
  } else if (kind == "shear") {
    double velocity = quality.velocity;
    std::string vertical = "held";
    const bool velocity_known = !t.has("velocity") || t.number("velocity", velocity, kAny, "m/s");
    scene.quality_as_is = scene.quality_as_is && velocity == quality.velocity;
    t.number("displacement", stage.displacement, kPositive, "m");
    t.choice("vertical", vertical, {"held", "pressure"});
    if (!t.has("ramp_time")) stage.ramp_time = 0.05;
    if (!t.has("displacement") && !t.has("duration") && !t.has("equilibrium_ratio"))
      t.find("displacement", "a number, more than 0 m (or give duration)", true);
    if (velocity_known && velocity == 0.0 && stage.displacement)
      t.refuse("velocity", "not 0: the stage would never reach its displacement");
    add_beam_controls(stage, bodies, pressure * area, vertical == "pressure", velocity);
  } else if (kind == "weight") {
    read_weight(t, stage, *scene.building);
  } else if (kind == "rest") {
    if (scene.building) read_weight(t, stage, *scene.building);
    if (!scene.building) t.number("pressure", pressure, kNotNegative, "Pa (downwards on the gross bed area)");
    if (!scene.building) add_beam_controls(stage, bodies, pressure * area, true, 0.0);
    read_rest(t, stage);
  } else if (kind == "push") {
    read_push(t, stage, *scene.building);
  } else if (kind == "cycles" && (t.has("body") || t.has("control"))) {
    read_cycles(t, stage);
    read_controls(t, stage, bodies, scene);
    read_cycled_body(t, "body", &bodies, stage);
  } else if (kind == "cycles" && scene.building) {
    read_cycles(t, stage);
    read_whiffletree(t, stage, *scene.building);
  } else if (kind == "cycles") {
    if (!top) t.refuse("kind", "cycles move the top beam, which the wall does not have: wall.top_beam = true, or body");
    read_cycles(t, stage);
    std::string vertical = "held";
    t.choice("vertical", vertical, {"held", "pressure"});
    add_beam_controls(stage, bodies, pressure * area, vertical == "pressure", stage.cycles->velocity);
    stage.controls.back().in_cycles = 0;
  } else if (kind_known) {
    read_custom(t, stage, scene, bodies, pressure * area, folder);
  }

  if (stage.cycles) scene.quality_as_is = scene.quality_as_is && std::abs(stage.cycles->velocity) == quality.velocity;
  read_law_swaps(t, scene, stage);
  if (!kind_known) return stage;  // which keys are allowed depends on the kind
  t.finish();
  return stage;
}

// Names under the keys material, unit_material and lintel_material of a table and what it holds, as deep as scenes go.
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

// Materials of deformable blocks: rigid ones need no stiffness.
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

}  // namespace

Scene read_scene(const std::string& path, const std::vector<std::string>& overrides) {
  return read_scene_text(read_input_file(path), path, overrides);
}

Scene read_scene_text(const std::string& text, const std::string& path, const std::vector<std::string>& overrides) {
  Scene scene = reader::read_scene(parse(text, path), path, overrides);
  scene.text = text;
  return scene;
}

namespace {

// After the scene's blocks and its wall.
void read_contact_table(Table c, Scene* scene) {
  if (bool cubic = false; c.boolean("cubic_points", cubic)) scene->cubic_points = cubic;
  if (scene->cubic_points && !scene->blocks && !(scene->wall && scene->wall->rigid_units))
    c.refuse("cubic_points", "only with wall.rigid_units = true: deformable units have their gridpoints; remove it");
  if (scene->blocks) read_contact(c, scene->solver, &scene->blocks->contact);
  c.finish();
}

// Returns the quality that the table names, or the given one; null: none, of blocks.
const Quality* read_solver_table(Table solver, const Quality* quality, bool of_blocks, Scene* scene) {
  if (!of_blocks || solver.has("quality")) {
    std::vector<std::string> names;
    for (const Quality& q : qualities()) names.push_back(q.name);
    std::string name = "standard";
    solver.choice("quality", name, names);
    quality = &quality_named(name);
  }
  // What a run does past the bound of small displacements changes no number before it.
  const toml::table& keys = solver.toml();
  scene->quality_as_is = std::all_of(keys.begin(), keys.end(), [](const auto& entry) {
    const std::string_view key = entry.first.str();
    return key == "quality" || key == "large_motion" || key == "past_motion_bound" || key == "rotation_bound" ||
           key == "sliding_bound";
  });
  scene->solver = read_solver(std::move(solver), quality);
  // Its errors were measured with small displacements.
  if (scene->solver.large_motion == LargeMotion::always) scene->quality_as_is = false;
  return quality;
}

void read_output(Table o, bool of_blocks, OutputSettings* output) {
  o.integer("frames", output->frames, 0, 100000);
  std::string of = output->all_stages ? "all" : "last";
  o.choice("frames_of", of, {"all", "last"});
  output->all_stages = of == "all";
  o.boolean("plots", output->plots);
  o.boolean("picture", output->plots);
  o.boolean("energy", output->energy);
  o.boolean("pieces", output->pieces);
  o.boolean("end_state", output->end_state);
  o.number("record_interval", output->record_interval, kNotNegative, "s");
  if (of_blocks) o.text("monitor", output->monitor, "the name of a block");
  o.finish();
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
  fill_in_from_tests(root, context);

  const bool of_blocks = root.contains("block") || root.contains("dry_wall") || root.contains("arch");
  const std::string folder = path.substr(0, path.rfind('/') == std::string::npos ? 0 : path.rfind('/') + 1);

  Scene scene;
  scene.file = path;
  Table t(context, root, "");
  t.text("title", scene.title, "text");
  read_monitors(t);
  const Quality* quality = of_blocks ? nullptr : &quality_named("standard");
  if (of_blocks) scene.output.energy = true;
  if (quality) scene.solver = quality->solver;
  if (const auto* table = t.table("solver", "a table [solver]")) {
    context.solver = table;
    quality = read_solver_table({context, *table, "solver"}, quality, of_blocks, &scene);
  }
  if (of_blocks) scene.quality_as_is = false;  // its errors were measured on walls
  if (quality) scene.quality = quality->name;

  auto each = [&](const char* kind, bool required, auto&& read) {
    const toml::table* all = t.table(kind, fmt::format("tables [{}.NAME]", kind), required);
    if (!all) return;
    if (all->empty()) t.refuse(kind, fmt::format("at least one table [{}.NAME]", kind));
    Table outer(context, *all, kind);
    for (auto&& [key, node] : *all) {
      const std::string name(key.str());
      if (const auto* table = outer.table(name, fmt::format("a table [{}.{}]", kind, name)))
        read(name, Table(context, *table, outer.path(name)));
    }
    outer.finish();
  };
  const std::set<std::string> zoned = zoned_materials(root);
  each("materials", true, [&](const std::string& name, Table m) {
    scene.materials[name] = read_material(name, m, !zoned.contains(name));
  });
  each("joints", true, [&](const std::string& name, Table j) { scene.joints[name] = read_joint(name, j); });
  if (const auto* table = t.table("random", "a table [random]"))
    scene.random = read_random({context, *table, "random"});
  for (auto& [name, family] : scene.joints) family.random = scene.random;
  if (const auto* table = t.table("building", "a table [building]"))
    scene.building = read_building({context, *table, "building"}, scene);
  if (scene.building) scene.quality_as_is = false;  // its errors were measured on walls
  if (of_blocks) scene.blocks = read_blocks(t, scene, folder);
  if (const auto* table = t.table("wall", "a table [wall]", !scene.building && !scene.blocks))
    scene.wall = read_wall({context, *table, "wall"}, scene);
  if (const auto* table = t.table("contact", "a table [contact]"))
    read_contact_table({context, *table, "contact"}, &scene);
  if (of_blocks && scene.solver.large_motion == LargeMotion::always) scene.blocks->contact.small_displacement = 0.0;
  if (of_blocks && scene.blocks->contact.small_displacement == 0.0) scene.solver.large_motion = LargeMotion::always;
  if (scene.wall && scene.building) t.refuse("wall", "one of [wall] and [building]; remove the other");

  scene.masses = read_masses(t);
  if (scene.building) {
    for (AddedMass& of_floor : masses_of_floors(*scene.building)) scene.masses.push_back(std::move(of_floor));
  }
  if (!scene.masses.empty()) scene.quality_as_is = false;  // its errors were measured without them
  if (t.has("mass") && scene.wall && scene.wall->half_thickness)
    t.refuse("mass", "none with wall.half_thickness = true: masses have no half; make that false");
  scene.members = read_members(t, scene);
  if (scene.members) scene.quality_as_is = false;  // its errors were measured without them
  for (size_t i = 0; const auto* table : t.tables("damage", "tables [[damage]]"))
    scene.damage.push_back(read_damage({context, *table, fmt::format("damage.{}", ++i)}, scene));
  if (t.text("start", scene.start, "the folder of a run with output.end_state = true")) {
    if (!scene.start.starts_with('/')) scene.start = folder + scene.start;
    if (!scene.damage.empty()) t.refuse("start", "without [[damage]], which belongs to the run that ends there");
  }

  double pressure = 0.0;  // of the last pressure stage: what a shear stage may keep
  int index = 0;
  for (const auto* table : t.tables("stage", "tables [[stage]]", true)) {
    const Stage* previous = scene.stages.empty() ? nullptr : &scene.stages.back();
    Table stage_table(context, *table, fmt::format("stage.{}", ++index));
    Stage stage = of_blocks ? read_block_stage(std::move(stage_table), scene, previous, folder)
                            : read_stage(std::move(stage_table), scene, previous, pressure, folder);
    if (of_blocks && scene.building) add_floor_loads(stage, *scene.building);
    scene.stages.push_back(std::move(stage));
  }
  if (const auto* table = t.table("output", "a table [output]"))
    read_output({context, *table, "output"}, of_blocks, &scene.output);
  t.finish();
  scene.inputs = std::move(context.inputs);
  if (const std::string faults = context.faults(); !faults.empty()) throw SceneFaults(faults, std::move(scene));
  return scene;
}

}  // namespace quoin
