#include "ensemble/study.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "base/input_file.h"
#include "ensemble/run_sample.h"
#include "scene/inline_toml.h"
#include "scene/read_scatter.h"

namespace quoin::ensemble {

using namespace reader;

namespace {

// Adds each value in the tables below [set] as an override.
void add_overrides(Context& context, const toml::table& table, const std::string& path, Study& study) {
  for (auto&& [key, node] : table) {
    const std::string name = (path.empty() ? "" : path + ".") + key_part(std::string(key.str()));
    const toml::table* below = node.as_table();
    if (below && !below->contains("distribution"))
      add_overrides(context, *below, name, study);
    else
      study.overrides.push_back(name + "=" + inline_toml(node));
    if (!below || !below->contains("distribution")) continue;
    const Scatter scatter = read_scatter(Table(context, *below, "set." + name));
    study.scattered.push_back({name, name, scatter.distribution});
  }
}

void read_quantities(Table& t, Study& study) {
  t.each("quantity", [&](Table& q) {
    StudyQuantity& quantity = study.quantities.emplace_back();
    q.text("key", quantity.key, "a key of the scene, as \"materials.brick.young_modulus\"", true);
    quantity.name = quantity.key;
    q.text("name", quantity.name, "text, for columns");
    quantity.distribution = read_distribution(q);
  });
}

// Reads a limit of a study with records: collapse, or a displacement.
void read_limit_of_records(Table& f, LimitState& limit) {
  f.number("displacement", limit.displacement, kPositive, "m, against the ground");
  limit.name = limit.displacement > 0.0 ? fmt::format("{:g} m", limit.displacement) : "collapse";
  f.text("name", limit.name, "text");
}

void read_limits(Table& t, Study& study) {
  t.each("fragility", [&](Table& f) {
    LimitState& limit = study.limits.emplace_back();
    if (study.suite.any()) {
      read_limit_of_records(f, limit);
    } else {
      f.text("output", limit.output, "a column of samples.csv", true);
      limit.where = f.where("output");
      limit.name = limit.output;
      f.text("name", limit.name, "text");
    }
  });
  if (!study.limits.empty()) return;
  if (study.suite.any())
    study.limits = {{"collapse", "", "", 0.0}};
  else
    study.limits = {{"peak", "displacement_at_peak_m", "", 0.0},
                    {"a loss of 20 % of the peak", "displacement_at_20_percent_loss_m", "", 0.0}};
}

}  // namespace

Study read_study(const std::string& file) {
  Context context;
  context.file = file;
  const toml::table root = parse(read_input_file(file), file);
  Study study;
  study.file = file;
  Table t(context, root, "");
  t.text("title", study.title, "text");
  if (t.text("scene", study.scene, "the path of a scene, from the folder of this file", true))
    study.scene = (std::filesystem::path(file).parent_path() / study.scene).lexically_normal().string();
  study.suite = read_record_suite(t, (std::filesystem::path(file).parent_path() / "").string());
  if (study.suite.any()) study.samples = 1;
  t.integer("samples", study.samples, 1, 1000000);
  t.integer("seed", study.seed, 0, 1L << 53);
  using random::Method;
  t.choice(
      "method", study.method,
      {{"monte_carlo", Method::monte_carlo}, {"latin_hypercube", Method::latin_hypercube}, {"sobol", Method::sobol}});
  t.number("crack_opening", study.crack_opening, kPositive, "m");
  if (const toml::table* set = t.table("set", "a table [set] of keys of the scene"))
    add_overrides(context, *set, "", study);
  read_quantities(t, study);
  std::vector<std::string> names;
  for (const StudyQuantity& quantity : study.quantities) names.push_back(quantity.name);
  study.mix = read_correlation(t, names, "names of quantities", study.correlation);
  if (study.method != Method::monte_carlo && study.quantities.empty())
    t.refuse("method", "\"monte_carlo\" where there is no [[quantity]]: fields of joints are drawn independently");
  if (study.method == Method::sobol && study.quantities.size() > random::kMostSobolDimensions)
    t.refuse("method", fmt::format("\"sobol\" with at most {} quantities", random::kMostSobolDimensions));
  read_limits(t, study);
  t.finish();
  context.throw_faults();
  return study;
}

namespace {

// Columns of samples.csv: inputs and outputs of every sample.
std::vector<std::string> columns_of(const Study& study, const Scene& scene) {
  std::vector<std::string> columns = output_names();
  for (const StudyQuantity& quantity : study.quantities) columns.push_back(quantity.name);
  for (const auto& [name, family] : scene.joints) {
    for (const PropertySetting& p : family.properties) {
      if (!p.scatter) continue;
      for (const std::string& column : drawn_columns(name, p.id)) columns.push_back(column);
    }
  }
  return columns;
}

// Whether records replace this key of the scene: motion and duration of the shaken stage, by its name or its number.
bool is_of_record(const std::string& key, const Study& study, std::size_t shaken) {
  for (const std::string& stage : {key_part(study.suite.stage), std::to_string(shaken + 1)}) {
    for (const char* replaced : {"ground_motion", "duration"}) {
      const std::string begin = fmt::format("stage.{}.{}", stage, replaced);
      if (key == begin || key.starts_with(begin + ".")) return true;
    }
  }
  return false;
}

template <class Add>
void check_suite(const Study& study, const Scene& scene, const Add& add) {
  const auto shakes = [&](const Stage& stage) { return stage.name == study.suite.stage; };
  const auto found = std::find_if(scene.stages.begin(), scene.stages.end(), shakes);
  if (found == scene.stages.end() || !found->ground)
    add(fmt::format("{}: shaking.stage = \"{}\": {} has no such stage that moves the ground", study.file,
                    study.suite.stage, study.scene));
  else if (!found->ground->supports.empty())
    add(
        fmt::format("{}: shaking.stage = \"{}\": its supports have records of their own, and [[record]] would drop "
                    "them; take a stage without ground_motion.support",
                    study.file, study.suite.stage));
  const auto shaken = static_cast<std::size_t>(found - scene.stages.begin());
  const auto refuse = [&](const std::string& key, const std::string& where) {
    if (is_of_record(key, study, shaken))
      add(
          fmt::format("{}: no effect, as [shaking] gives stage '{}' the motion and duration of each record; remove it, "
                      "or give scale to [[record]]",
                      where, study.suite.stage));
  };
  for (const std::string& setting : study.overrides)
    refuse(setting.substr(0, setting.find('=')), fmt::format("{}: {}", study.file, setting));
  for (int number = 0; const StudyQuantity& quantity : study.quantities)
    refuse(quantity.key, fmt::format("{}: quantity.{}.key = \"{}\"", study.file, ++number, quantity.key));
  const bool scatters =
      !study.quantities.empty() || std::any_of(scene.joints.begin(), scene.joints.end(), [](const auto& family) {
        return std::any_of(family.second.properties.begin(), family.second.properties.end(),
                           [](const PropertySetting& p) { return p.scatter.has_value(); });
      });
  if (study.samples > 1 && !scatters)
    add(fmt::format("{}: samples = {}: walls that are all alike, as nothing scatters; remove it", study.file,
                    study.samples));
}

}  // namespace

void check_study(const Study& study, const Scene& scene) {
  std::string faults;
  const auto add = [&](const std::string& fault) { faults += (faults.empty() ? "" : "\n") + fault; };
  const std::vector<std::string> columns = columns_of(study, scene);
  for (const LimitState& limit : study.limits) {
    if (!study.suite.any() && std::find(columns.begin(), columns.end(), limit.output) == columns.end())
      add(fmt::format("{} = \"{}\": samples.csv has no such column{}; it has: {}", limit.where, limit.output,
                      did_you_mean(limit.output, columns), fmt::join(columns, ", ")));
  }
  for (int number = 0; const StudyQuantity& quantity : study.quantities) {
    const std::string where = fmt::format("{}: quantity.{}", study.file, ++number);
    if (std::count(columns.begin(), columns.end(), quantity.name) > 1)
      add(fmt::format("{}: samples.csv has two columns called \"{}\"; give it a name of its own", where,
                      quantity.name));
    if (std::count_if(study.quantities.begin(), study.quantities.end(),
                      [&](const StudyQuantity& other) { return other.key == quantity.key; }) > 1)
      add(fmt::format("{}.key = \"{}\": two quantities of one key; remove one", where, quantity.key));
    for (const std::string& setting : study.overrides) {
      if (setting.starts_with(quantity.key + "="))
        add(fmt::format("{}.key = \"{}\": is set too ({}), which would have no effect; remove one of the two", where,
                        quantity.key, setting));
    }
  }
  for (const std::string& setting : study.overrides) {
    if (setting.starts_with("random."))
      add(fmt::format(
          "{}: {}: samples of a study are numbered from 1, and their seed is that of the study; give it seed",
          study.file, setting));
  }
  if (study.suite.any()) check_suite(study, scene, add);
  if (!faults.empty()) throw Error(Exit::bad_input, faults);
}

void add_scatter_of(const Scene& scene, Study& study) {
  for (const auto& [family, joint] : scene.joints) {
    for (const PropertySetting& p : joint.properties) {
      const std::string key = fmt::format("joints.{}.{}", key_part(family), p.id);
      if (p.scatter && std::ranges::find(study.scattered, key, &StudyQuantity::key) == study.scattered.end())
        study.scattered.push_back({key, key, p.scatter->distribution});
    }
  }
}

std::vector<StudyQuantity> Study::inputs() const {
  std::vector<StudyQuantity> all = quantities;
  if (trials != Trials::drawn) all.insert(all.end(), scattered.begin(), scattered.end());
  return all;
}

void Study::draw() const {
  if (!design && trials == Trials::drawn) design.emplace(method, seed, samples, inputs().size());
}

std::vector<double> Study::values(std::uint64_t sample) const {
  const std::vector<StudyQuantity> all = inputs();
  const std::size_t n = all.size();
  if (sample == 0) {
    std::vector<double> means;
    for (const StudyQuantity& q : all) means.push_back(random::Sampler(q.distribution).mean());
    return means;
  }
  std::vector<double> z(n, 0.0);
  switch (trials) {
    case Trials::drawn: {
      draw();
      for (std::size_t i = 0; i < n; ++i) {
        const double fresh = random::normal_quantile(design->at(sample, i));
        for (std::size_t k = i; k < n; ++k) z[k] += mix[k * n + i] * fresh;
      }
      break;
    }
    case Trials::one_at_a_time: {
      std::vector<double> tried = values(0);
      const std::size_t k = (sample - 1) / 2;
      tried[k] = random::Sampler(all[k].distribution).at_normal(sample % 2 == 1 ? -1.0 : 1.0);
      return tried;
    }
    case Trials::exchanged: {
      const std::uint64_t row = (sample - 1) / (n + 2), place = (sample - 1) % (n + 2);
      const random::Design sequence(random::Method::sobol, seed, samples, 2 * n);
      for (std::size_t k = 0; k < n; ++k)
        z[k] = random::normal_quantile(sequence.at(row + 1, place == 1 || place == k + 2 ? n + k : k));
      break;
    }
  }
  std::vector<double> drawn;
  for (std::size_t i = 0; i < n; ++i) drawn.push_back(random::Sampler(all[i].distribution).at_normal(z[i]));
  return drawn;
}

std::vector<std::string> Study::overrides_of(std::uint64_t sample) const {
  std::vector<std::string> all = overrides;
  all.push_back(fmt::format("random.seed={}", seed));
  all.push_back(fmt::format("random.sample={}", trials == Trials::drawn ? sample : 0));
  const std::vector<StudyQuantity> of = inputs();
  const std::vector<double> drawn = values(sample);
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    // A random property stays a distribution, with scatter 0, so that other keys about it remain valid.
    const bool scatters = i >= quantities.size();
    const std::string value = fmt::format("{:.17g}", drawn[i]);
    all.push_back(of[i].key + "=" + (scatters ? "{distribution=\"normal\",sd=0,mean=" + value + "}" : value));
  }
  return all;
}

}  // namespace quoin::ensemble
