#include "results/history.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/upright_axis.h"
#include "files/csv_text.h"
#include "files/file.h"
#include "results/plots.h"
#include "scene/driven.h"
#include "step/columns/columns.h"
#include "step/findings.h"

namespace quoin {

namespace {

using Value = std::function<double(const HistoryRow&, const Stage&)>;
constexpr auto kNumber = HistoryColumn::Kind::number;

Energies energies(const HistoryRow& row) { return row.energies.value_or(Energies{}); }

template <std::size_t mode>
double dissipated(const HistoryRow& row, const Stage&) {
  return energies(row).dissipated[mode];
}
template <double Energies::*part>
double energy(const HistoryRow& row, const Stage&) {
  return energies(row).*part;
}
template <double HistoryNumbers::*part>
double number(const HistoryRow& row, const Stage&) {
  return row.*part;
}
template <Vec3 HistoryNumbers::*part, std::size_t c>
double component(const HistoryRow& row, const Stage&) {
  return (row.*part)[c];
}

std::string text_of(const HistoryColumn& column, const HistoryRow& row, const Stage& stage) {
  if (column.kind == HistoryColumn::Kind::text) return csv_text(stage.name);
  const double value = column.value(row, stage);
  if (column.kind == HistoryColumn::Kind::integer) return fmt::format("{}", static_cast<long>(value));
  // Empty for values that do not exist, as an unbalanced force over contact forces of 0.
  return std::isfinite(value) ? fmt::format("{}", value) : "";
}

}  // namespace

namespace {

using Component = GroundMotion::Component;

void add_components(const GroundMotion& ground, std::vector<const Component*>& components) {
  for (const Component& c : ground.components) components.push_back(&c);
  for (const GroundMotion& support : ground.supports) add_components(support, components);
}

// Whether a component is horizontal, at least in part, and its largest acceleration: the order of strength.
std::pair<bool, double> strength_of(const Component* component, int upright) {
  double largest = 0.0;
  for (const double a : component->acceleration.value) largest = std::max(largest, std::abs(a));
  Vec3 horizontal = component->direction;
  horizontal[static_cast<std::size_t>(upright)] = 0.0;
  return {horizontal != Vec3{}, largest};
}

bool watches_nothing(const std::string& monitor_of_scene, const Stage& stage) {
  return stage.monitor.empty() && stage.roof.empty() && monitor_of_scene.empty();
}

}  // namespace

int axis_of_action(const Stage& stage) {
  std::vector<const Component*> components;
  if (stage.ground) add_components(*stage.ground, components);
  std::vector<Vec3> directions;
  for (const Component* component : components) directions.push_back(component->direction);
  if (stage.collapse) directions.push_back(stage.collapse->direction);
  for (const std::size_t c : {0u, 2u, 1u}) {
    if (std::ranges::any_of(directions, [c](const Vec3& d) { return d[c] != 0.0; })) return static_cast<int>(c);
  }
  return 0;
}

int axis_of(const Stage& stage) {
  if (stage.direction == 0 && axis_of_action(stage) == 2) return 2;
  if (stage.direction != 0 || stage.whiffletree || stage.cycles) return stage.direction;
  return only_axis(driven_along(stage));
}

ResponseAxis response_axis(const Stage& stage) {
  if (stage.direction == 2) return {{0.0, 0.0, 1.0}, "z"};
  std::vector<const Component*> components;
  if (stage.ground) add_components(*stage.ground, components);
  const int upright = upright_axis(stage.gravity);
  const auto strongest =
      std::ranges::max_element(components, {}, [upright](const Component* c) { return strength_of(c, upright); });
  if (strongest == components.end()) return {};
  // Horizontal, unless the ground moves along the vertical alone: a force along it has the weight.
  Vec3 d = (*strongest)->direction;
  Vec3 level = d;
  level[static_cast<std::size_t>(upright)] = 0.0;
  if (norm_of(level) > 0.0) d = level;
  d = d / norm_of(d);
  for (std::size_t c = 0; c < 3; ++c) {
    if (std::abs(d[c]) < 1.0) continue;
    ResponseAxis axis{{}, std::string(1, "xyz"[c])};
    axis.direction[c] = 1.0;
    return axis;
  }
  return {d, fmt::format("({:.3g}, {:.3g}, {:.3g})", d[0], d[1], d[2])};
}

std::string axis_name(const Stage& stage) {
  return stage.ground ? response_axis(stage).name : std::string(1, "xyz"[axis_of(stage)]);
}

bool watches_nothing(const Scene& scene, const Stage& stage) { return watches_nothing(scene.output.monitor, stage); }

const char* key_of_monitor(const Scene& scene) { return scene.blocks ? "output.monitor" : "monitor of a custom stage"; }

bool has_actions(const Scene& scene) {
  return scene.blocks ||
         std::ranges::any_of(scene.stages, [](const Stage& stage) { return !beyond_lattice(stage).empty(); });
}

bool is_vertical(const Stage& stage) { return axis_of(stage) == 1; }

namespace {

// Positive when the wall resists: minus the force on what moves it, in stages of a building that on the ground.
double resists(const HistoryRow& row, const Stage& stage, size_t axis) {
  return stage.roof.empty() ? -row.joint_force[axis] : row.joint_force[axis];
}

}  // namespace

Response response(const HistoryRow& row, const Stage& stage) {
  // A stage monitored along y has a horizontal response too, along the wall.
  const size_t axis = axis_of(stage) == 2 ? 2 : 0;
  return {row.monitor_displacement[axis], resists(row, stage, axis), row.vertical_force};
}

DissipatedEnergy dissipated_in_earthquake(const std::vector<HistoryRow>& rows, const Scene& scene) {
  DissipatedEnergy sum, before;
  for (const HistoryRow& row : rows) {
    if (!row.energies) continue;
    const Energies& e = *row.energies;
    const DissipatedEnergy now{e.damping, e.members_dissipated, e.dissipated_total()};
    // What was dissipated before the run whose end state this one starts from counts in its first row.
    if (&row == &rows.front() && !scene.start.empty()) before = now;
    if (scene.stages[static_cast<size_t>(row.stage)].ground) {
      sum.damping += now.damping - before.damping;
      sum.members += now.members - before.members;
      sum.joints += now.joints - before.joints;
    }
    before = now;
  }
  return sum;
}

const char* curve_kind(const Stage& stage) {
  if (stage.ground) return "earthquake";
  if (stage.collapse) return "collapse";
  const bool pushed = stage.whiffletree || stage.cycles || driven_along(stage) != std::array{false, false, false};
  return pushed ? "push" : "rest";
}

bool is_vertical(const Scene& scene) { return !scene.stages.empty() && is_vertical(stage_of_curve(scene)); }

Shown shown(const HistoryRow& row, const Scene& scene) {
  const Stage& stage = scene.stages[static_cast<size_t>(row.stage)];
  if (is_vertical(scene)) return {row.monitor_displacement[1], resists(row, stage, 1)};
  const Response r = response(row, stage);
  return {r.displacement, r.horizontal_force};
}

namespace {

// Value of the monitor: empty in rows of stages without one.
Value of_monitor(const Scene& scene, Value value) {
  return [monitor = scene.output.monitor, value = std::move(value)](const HistoryRow& row, const Stage& stage) {
    return watches_nothing(monitor, stage) ? std::nan("") : value(row, stage);
  };
}

// Adds the columns of blocks of any shape.
void add_block_columns(const Scene& scene, bool on_ground, const std::function<void(const std::string&, Value)>& add) {
  const auto add_of_monitor = [&](const std::string& name, const Value& value) { add(name, of_monitor(scene, value)); };
  add("multiplier", number<&HistoryRow::multiplier>);
  add_of_monitor("monitor_dx_m", component<&HistoryRow::monitor_displacement, 0>);
  add_of_monitor("monitor_dy_m", component<&HistoryRow::monitor_displacement, 1>);
  add_of_monitor("monitor_dz_m", component<&HistoryRow::monitor_displacement, 2>);
  if (on_ground) {
    add_of_monitor("monitor_relative_dx_m", component<&HistoryRow::monitor_relative, 0>);
    add_of_monitor("monitor_relative_dy_m", component<&HistoryRow::monitor_relative, 1>);
    add_of_monitor("monitor_relative_dz_m", component<&HistoryRow::monitor_relative, 2>);
    add("ground_dx_m", component<&HistoryRow::ground_displacement, 0>);
    add("ground_dy_m", component<&HistoryRow::ground_displacement, 1>);
    add("ground_dz_m", component<&HistoryRow::ground_displacement, 2>);
    add("base_shear_x_N", component<&HistoryRow::base_force, 0>);
    add("base_shear_z_N", component<&HistoryRow::base_force, 2>);
    add("base_vertical_N", component<&HistoryRow::base_force, 1>);
    add("overturning_moment_x_Nm", component<&HistoryRow::overturning_moment, 0>);
    add("overturning_moment_z_Nm", component<&HistoryRow::overturning_moment, 2>);
  }
  add_of_monitor("monitor_fx_N", component<&HistoryRow::joint_force, 0>);
  add_of_monitor("monitor_fy_N", component<&HistoryRow::joint_force, 1>);
  add_of_monitor("monitor_fz_N", component<&HistoryRow::joint_force, 2>);
  add("largest_displacement_m", number<&HistoryRow::largest_displacement>);
  if (!scene.output.energy) return;
  add("kinetic_J", energy<&Energies::kinetic>);
  add("strain_J", energy<&Energies::strain>);
  add("contact_stored_J", energy<&Energies::contact_stored>);
  add("damping_J", energy<&Energies::damping>);
  add("external_J", energy<&Energies::external>);
  add("detection_J", energy<&Energies::detection>);
}

void add_groups(const Scene& scene, const std::function<void(const std::string&, Value)>& add) {
  const std::vector<std::string> names = added_columns(scene);
  for (std::size_t i = 0; i < names.size(); ++i)
    add(names[i], [i](const HistoryRow& row, const Stage&) { return row.added[i]; });
  if (!scene.members || !scene.output.energy) return;
  add("members_stored_J", energy<&Energies::members_stored>);
  add("members_dissipated_J", energy<&Energies::members_dissipated>);
}

// Adds the columns of reactions: the sum, and that of each support with a name, with its displacement if it is driven.
void add_reaction_columns(const std::vector<Restraint>& restraints,
                          const std::function<void(const std::string&, Value)>& add) {
  constexpr const char* kAxes[] = {"x", "y", "z"};
  const auto add_each = [&](const std::string& name, const auto& reaction_of) {
    for (std::size_t c = 0; c < 3; ++c)
      add(name + kAxes[c] + "_N", [=](const HistoryRow& row, const Stage&) { return reaction_of(row).force[c]; });
    for (std::size_t c = 0; c < 3; ++c)
      add(name + "m" + kAxes[c] + "_Nm",
          [=](const HistoryRow& row, const Stage&) { return reaction_of(row).moment[c]; });
  };
  add_each("reaction_", [](const HistoryRow& row) -> const Reaction& { return row.reaction_sum; });
  for (std::size_t i = 0; i < restraints.size(); ++i) {
    const auto reaction_of = [i](const HistoryRow& row) -> const Reaction& { return row.reactions[i]; };
    add_each("reaction_" + restraints[i].name + "_", reaction_of);
    for (std::size_t c = 0; restraints[i].driven && c < 3; ++c)
      add(fmt::format("driven_{}_d{}_m", restraints[i].name, kAxes[c]),
          [=](const HistoryRow& row, const Stage&) { return reaction_of(row).displacement[c]; });
  }
}

}  // namespace

std::vector<HistoryColumn> history_columns(const Scene& scene, const std::vector<Restraint>& restraints) {
  using Kind = HistoryColumn::Kind;
  std::vector<HistoryColumn> columns{
      {"stage", Kind::integer, [](const HistoryRow& row, const Stage&) { return row.stage + 1.0; }},
      {"stage_name", Kind::text, nullptr},
      {"step", Kind::integer, [](const HistoryRow& row, const Stage&) { return static_cast<double>(row.step); }},
      {"time_s", kNumber, number<&HistoryRow::time>},
      {"displacement_m", kNumber,
       of_monitor(scene, [](const HistoryRow& row, const Stage& s) { return response(row, s).displacement; })},
      {"vertical_displacement_m", kNumber, of_monitor(scene, component<&HistoryRow::monitor_displacement, 1>)},
      {"horizontal_force_N", kNumber,
       of_monitor(scene, [](const HistoryRow& row, const Stage& s) { return response(row, s).horizontal_force; })},
      {"vertical_force_N", kNumber, of_monitor(scene, number<&HistoryRow::vertical_force>)},
      {"unbalanced_ratio", kNumber, number<&HistoryRow::unbalanced_ratio>},
      {"kinetic_energy_J", kNumber, number<&HistoryRow::kinetic_energy>}};
  const auto add = [&](const std::string& name, const Value& value) { columns.push_back({name, kNumber, value}); };
  if (scene.output.energy) {
    add("strain_energy_J", energy<&Energies::strain>);
    add("contact_energy_J", energy<&Energies::contact_stored>);
    add("dissipated_tension_J", dissipated<0>);
    add("dissipated_cohesion_J", dissipated<1>);
    add("dissipated_friction_J", dissipated<2>);
    add("dissipated_crushing_J", dissipated<3>);
    add("external_work_J", energy<&Energies::external>);
    add("damping_work_J", energy<&Energies::damping>);
    add("energy_balance_error_J", [](const HistoryRow& row, const Stage&) { return energies(row).balance_error(); });
  }
  const auto& stages = scene.stages;
  const bool on_ground = std::any_of(stages.begin(), stages.end(), [](const Stage& s) { return s.ground.has_value(); });
  add_groups(scene, add);
  if (has_actions(scene)) add_block_columns(scene, on_ground, add);
  add_reaction_columns(restraints, add);
  return columns;
}

History::History(const std::filesystem::path& path, const Simulation& simulation, const std::vector<HistoryRow>& before)
    : path_(path),
      scene_(simulation.scene()),
      columns_(history_columns(scene_, restraints_of(simulation))),
      stream_(begin_file(path), std::ios::trunc) {
  for (const HistoryColumn& column : columns_) {
    const bool plain = column.name.find_first_of(",\"\r\n") == std::string::npos;  // names may have separators
    stream_ << (&column == columns_.data() ? "" : ",") << (plain ? column.name : csv_text(column.name));
  }
  stream_ << '\n';
  for (const HistoryRow& row : before) add(row);
}

// Writes numbers as the shortest decimals that read back to the same double.
void History::add(const HistoryRow& row) {
  const Stage& stage = scene_.stages[static_cast<size_t>(row.stage)];
  std::string line;
  for (const HistoryColumn& column : columns_) {
    if (!line.empty()) line += ',';
    line += text_of(column, row, stage);
  }
  stream_ << line << '\n';
  if (!stream_) refuse();  // at once, not at the end of a long run
  rows_.push_back(row);
}

void History::finish() {
  stream_.close();
  if (!stream_) refuse();
  finish_file(path_);
}

void History::refuse() {
  stream_.close();
  abandon_file(path_);
  throw Error(Exit::bad_input, path_.string() +
                                   ": cannot be written; free space and go on with --resume, or choose another folder "
                                   "with --out");
}

}  // namespace quoin
