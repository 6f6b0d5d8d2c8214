#include "ensemble/record_suite.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "records/record.h"
#include "records/response_spectrum.h"
#include "scene/inline_toml.h"
#include "scene/read_ground.h"
#include "scene/reader.h"

namespace quoin::ensemble {

using namespace reader;

namespace {

constexpr double kDamping = 0.05;  // damping ratio of sa

// Table with absolute paths of files. Paths are relative to the folder of the study here, to that of the scene in a
// scene.
toml::table with_whole_paths(const toml::table& given, const std::string& folder) {
  toml::table whole = given;
  const bool by_axes = !given.contains("file");
  for (const char* key : {"file", "x", "y", "z"}) {
    if (!by_axes && std::string_view(key) != "file") continue;  // keys are names of columns
    const auto path = given[key].value<std::string>();
    if (!path || path->starts_with('/')) continue;
    whole.insert_or_assign(key, std::filesystem::absolute(folder + *path).lexically_normal().string());
  }
  return whole;
}

// Records of one table: one, or several with count or files.
std::vector<std::pair<std::string, toml::table>> expanded(Table& t, int index) {
  std::string name;
  int count = 1;
  t.text("name", name, "text, for tables");
  const bool counted = t.integer("count", count, 1, 100000);
  toml::table motion = t.toml();
  for (const char* key : {"name", "count", "files"}) motion.erase(key);
  std::vector<std::pair<std::string, toml::table>> all;
  if (t.has("files")) {
    std::vector<std::string> files;
    t.texts("files", files, "a list of texts, one file each");
    for (const std::string& file : files) {
      motion.insert_or_assign("file", file);
      all.emplace_back(std::filesystem::path(file).stem().string(), motion);
    }
    return all;
  }
  if (name.empty()) name = fmt::format("record {}", index);
  const toml::table* synthetic = motion["synthetic"].as_table();
  if (counted && !synthetic) t.refuse("count", "only with synthetic; remove it");
  if (!counted || !synthetic) return {{name, motion}};
  const long first = (*synthetic)["number"].value_or(0L);
  for (int i = 0; i < count; ++i) {
    toml::table one = motion;
    one["synthetic"].as_table()->insert_or_assign("number", first + i);
    all.emplace_back(fmt::format("{} {}", name, i + 1), one);
  }
  return all;
}

// Reads a record. files: context that collects the names of its files.
GroundMotion ground_of(const SuiteRecord& record, Context* files = nullptr) {
  Context context;
  context.file = record.name;
  const toml::table motion = parse("m = " + record.motion, record.name);
  GroundMotion ground = read_ground({context, *motion["m"].as_table(), "record"}, "");
  context.throw_faults();
  if (files) files->inputs.insert(files->inputs.end(), context.inputs.begin(), context.inputs.end());
  return ground;
}

void read_records(Table& study, const std::string& folder, RecordSuite& suite) {
  int index = 0;
  for (const toml::table* table : study.tables("record", "tables [[record]]", true)) {
    Table t(study.context(), *table, fmt::format("record.{}", ++index));
    const std::size_t before = suite.records.size();
    for (auto& [name, motion] : expanded(t, index))
      suite.records.push_back({name, inline_toml(with_whole_paths(motion, folder)), inline_toml(motion)});
    for (const char* key : {"scale", "pga", "pgv", "sa", "sa_period"}) {
      if (t.has(key) && (suite.method != RecordSuite::Method::cloud || std::string_view(key) != "scale"))
        t.refuse(key, suite.method == RecordSuite::Method::cloud
                          ? "only scale in a cloud; remove it"
                          : "only in a cloud, where records are not scaled otherwise; remove it");
    }
    // Checks all keys, with their lines; synthetic records of one table differ by their number alone.
    for (const char* key : {"name", "count", "files"}) t.accept(key);
    if (!t.has("files")) {
      read_ground(t, folder);
      continue;
    }
    for (std::size_t i = before; i < suite.records.size(); ++i) ground_of(suite.records[i], &study.context());
  }
  for (const SuiteRecord& record : suite.records) {
    if (std::count_if(suite.records.begin(), suite.records.end(),
                      [&](const SuiteRecord& other) { return other.name == record.name; }) == 1)
      continue;
    study.context().fault(fmt::format("{}: two records are called '{}'; give each a name of its own",
                                      study.where("record"), record.name));
    break;
  }
}

void read_levels(Table& t, RecordSuite& suite) {
  using Method = RecordSuite::Method;
  const bool incremental = suite.method == Method::incremental;
  const char* unit = suite.measure == IntensityMeasure::pgv ? "m/s" : "m/s2";
  const bool first = t.number("first", suite.first, kPositive, unit, incremental),
             growth = t.number("growth", suite.growth, above_to(1.0, 10.0), "(ratio of levels)"),
             largest = t.number("largest", suite.largest, kPositive, unit, incremental),
             tolerance = t.number("tolerance", suite.tolerance, between(1e-4, 0.5), "(of the collapse level)");
  if (!incremental && (first || growth || largest || tolerance))
    t.refuse(first     ? "first"
             : growth  ? "growth"
             : largest ? "largest"
                       : "tolerance",
             "only with method = \"incremental\"; remove it");
  if (incremental && suite.largest <= suite.first) t.refuse("largest", "more than first");
  const bool levels = t.numbers("levels", suite.levels, kPositive, unit, suite.method == Method::stripes);
  if (levels && suite.method != Method::stripes) t.refuse("levels", "only with method = \"stripes\"; remove it");
  std::sort(suite.levels.begin(), suite.levels.end());
}

}  // namespace

RecordSuite read_record_suite(Table& study, const std::string& folder) {
  RecordSuite suite;
  const toml::table* table = study.table("shaking", "a table [shaking]", study.has("record"));
  if (!table) {
    study.accept("record");
    return suite;
  }
  Table t(study.context(), *table, "shaking");
  using Method = RecordSuite::Method;
  suite.method = Method::incremental;
  t.choice("method", suite.method,
           {{"incremental", Method::incremental}, {"stripes", Method::stripes}, {"cloud", Method::cloud}});
  t.text("stage", suite.stage, "the name of the stage that shakes", true);
  t.choice("intensity", suite.measure,
           {{"pga", IntensityMeasure::pga}, {"pgv", IntensityMeasure::pgv}, {"sa", IntensityMeasure::sa}});
  t.number("sa_period", suite.period, kPositive, "s", suite.measure == IntensityMeasure::sa);
  t.number("free_time", suite.free_time, kNotNegative, "s");
  t.number("collapse_displacement", suite.displacement, kPositive, "m", true);
  read_levels(t, suite);
  t.finish();
  read_records(study, folder, suite);
  suite.files = study.context().inputs;
  return suite;
}

SuiteMotion motion_of(const RecordSuite& suite, std::size_t record) {
  const GroundMotion ground = ground_of(suite.records.at(record));
  SuiteMotion motion;
  for (const GroundMotion::Component& c : ground.components) {
    constexpr double kLatest = 3600.0;  // s, before which a record is to begin
    if (c.acceleration.time.front() > kLatest)
      throw Error(Exit::bad_input,
                  fmt::format("record '{}': begins at {:g} s of its stage, allowed: {:g} at most; give start, the time "
                              "from which it is taken",
                              suite.records.at(record).name, c.acceleration.time.front(), kLatest));
    const RecordMeasures of_component = measure_record(c.acceleration);
    motion.end = std::max(motion.end, c.acceleration.time.back());
    motion.intensity[0] = std::max(motion.intensity[0], of_component.pga);
    motion.intensity[1] = std::max(motion.intensity[1], of_component.pgv);
    if (suite.period > 0.0)
      motion.intensity[2] =
          std::max(motion.intensity[2],
                   response_spectrum(c.acceleration, kDamping, std::span(&suite.period, 1))[0].pseudo_acceleration);
  }
  if (suite.period <= 0.0) motion.intensity[2] = std::numeric_limits<double>::quiet_NaN();
  if (!(motion.intensity[0] > 0.0))
    throw Error(Exit::bad_input, fmt::format("record '{}': is 0 throughout; remove it", suite.records.at(record).name));
  return motion;
}

std::vector<std::string> overrides_for(const RecordSuite& suite, std::size_t record, const SuiteMotion& motion,
                                       double factor) {
  const std::string stage = "stage." + key_part(suite.stage);
  std::vector<std::string> lines{stage + ".ground_motion=" + suite.records.at(record).motion,
                                 fmt::format("{}.duration={:.17g}", stage, motion.end + suite.free_time)};
  const toml::table given = parse("m = " + suite.records[record].motion, suite.records[record].name);
  const double scale = given["m"]["scale"].value_or(1.0);
  // Only records without scale and pga have another factor than 1.
  if (converts_from_g(factor))
    lines.push_back(fmt::format("{}.ground_motion.pga={:.17g}", stage, factor * motion.intensity[0]));
  else
    lines.push_back(fmt::format("{}.ground_motion.scale={:.17g}", stage, scale * factor));
  return lines;
}

}  // namespace quoin::ensemble
