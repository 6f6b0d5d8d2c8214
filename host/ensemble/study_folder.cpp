#include "ensemble/study_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <nlohmann/json.hpp>
#include <system_error>

#include "base/error.h"
#include "base/input_file.h"
#include "base/sha256.h"
#include "files/csv_text.h"
#include "files/file.h"
#include "files/result_folder.h"
#include "results/provenance.h"

#ifndef QUOIN_VERSION
#define QUOIN_VERSION "unknown"
#endif

namespace quoin::ensemble {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// Results of studies of any kind, whose files could be someone else's in a folder without a study.
constexpr const char* kResults[] = {
    "samples.csv",     "summary.json",  "index.html",        "curve_bands.csv",   "crack_probability.csv",
    "runs.csv",        "fragility.csv", "sensitivity.csv",   "sobol.csv",         "fragility_curves.csv",
    "bands.png",       "runs.png",      "convergence.png",   "fragility.png",     "crack_probability.png",
    "influence.png",   "plots",         "fragility_pga.png", "fragility_pgv.png", "fragility_sa.png",
    "sensitivity.png", "inputs"};

std::string message(int code) { return std::error_code(code, std::generic_category()).message(); }

std::string word_of(Trials trials) {
  switch (trials) {
    case Trials::drawn:
      return "drawn";
    case Trials::one_at_a_time:
      return "one at a time";
    case Trials::exchanged:
      return "exchanged";
  }
  return "?";
}

Json json_of(const StudyQuantity& quantity) {
  const random::Distribution& d = quantity.distribution;
  // JSON has no infinity.
  const auto bound = [](double v) { return std::isfinite(v) ? Json(v) : Json(nullptr); };
  return {{"name", quantity.name},  {"key", quantity.key},  {"distribution", random::shape_name(d.shape)},
          {"mean", d.mean},         {"scatter", d.scatter}, {"lower", bound(d.lower)},
          {"upper", bound(d.upper)}};
}

Json json_of(const RecordSuite& suite) {
  Json json{{"method", static_cast<int>(suite.method)},
            {"stage", suite.stage},
            {"intensity", names_of(suite.measure).key},
            {"sa_period", suite.period},
            {"first", suite.first},
            {"growth", suite.growth},
            {"largest", suite.largest},
            {"tolerance", suite.tolerance},
            {"levels", suite.levels},
            {"free_time", suite.free_time},
            {"collapse_displacement", suite.displacement},
            {"records", Json::array()},
            {"files", Json::array()}};
  for (const SuiteRecord& record : suite.records)
    json["records"].push_back({{"name", record.name}, {"ground_motion", record.as_given}});
  for (const std::string& file : suite.files) json["files"].push_back(sha256_of(read_input_file(file)));
  return json;
}

// All that samples depend on. Titles and fragilities, on which only results depend, may change.
Json identity_of(const Study& study, const Scene& scene) {
  Json json;
  json["version of quoin"] = QUOIN_VERSION;
  json["build of quoin"] = sha256_of_file("/proc/self/exe");
  json["quantities"] = Json::array();
  for (const StudyQuantity& quantity : study.quantities) json["quantities"].push_back(json_of(quantity));
  json["correlation"] = study.mix;
  json["method"] = random::method_name(study.method);
  json["seed"] = study.seed;
  json["keys set"] = study.overrides;
  json["trials"] = word_of(study.trials);
  // Samples of a Latin hypercube depend on their number.
  if (study.method == random::Method::latin_hypercube) json["samples"] = study.samples;
  if (study.suite.any()) json["records"] = json_of(study.suite);
  json["text of the scene"] = sha256_of(scene.text);
  for (int number = 0; const HashedFile& file : input_files(scene))
    json[fmt::format("file {}, {}", ++number, fs::path(file.name).filename().string())] = file.sha256;
  for (const HashedFile& law : law_files(scene)) json["law " + law.name] = law.sha256;
  return json;
}

int open_claim(const fs::path& file) {
  const int opened = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644);
  if (opened < 0)
    throw Error(Exit::bad_input, fmt::format("{}: cannot be written: {}; choose another folder with --out",
                                             file.string(), message(errno)));
  return opened;
}

[[noreturn]] void refuse_lock(const fs::path& file, int opened) {
  const int fault = errno;
  close(opened);
  throw Error(Exit::bad_input,
              fmt::format("{}: cannot be locked ({}), and without locks two processes might compute one sample; choose "
                          "a folder on a file system that knows flock",
                          file.string(), message(fault)));
}

}  // namespace

std::unique_ptr<Claim> Claim::take(const fs::path& file) {
  const int opened = open_claim(file);
  if (flock(opened, LOCK_EX | LOCK_NB) == 0) return std::unique_ptr<Claim>(new Claim(opened));
  if (errno != EWOULDBLOCK) refuse_lock(file, opened);
  close(opened);
  return nullptr;
}

std::unique_ptr<Claim> Claim::wait_for(const fs::path& file) {
  const int opened = open_claim(file);
  while (flock(opened, LOCK_EX) != 0) {
    if (errno != EINTR) refuse_lock(file, opened);
  }
  return std::unique_ptr<Claim>(new Claim(opened));
}

Claim::~Claim() { close(file_); }

void Claim::sign() const {
  std::array<char, 256> host{};
  if (gethostname(host.data(), host.size() - 1) != 0) host[0] = '\0';
  const std::string line = fmt::format("process {} on {}\n", getpid(), host.data());
  if (lseek(file_, 0, SEEK_END) < 0 || write(file_, line.data(), line.size()) < 0) return;
}

StudyFolder::StudyFolder(fs::path path, const Study& study, const Scene& scene, const StudyRequest& request)
    : path_(std::move(path)) {
  refuse_folder_of_run(path_);
  // A folder with study.json is one of quoin. Names are listed before it is written, as processes may begin at once.
  if (!fs::exists(path_ / "study.json")) list_own_files(path_, {std::begin(kResults), std::end(kResults)});
  make_folder(path_ / "samples");
  make_folder(path_ / "claims");
  const fs::path file = path_ / "study.json";
  const Json own = identity_of(study, scene);
  // The first process writes the files. Others wait, and read complete ones.
  const std::unique_ptr<Claim> entering = Claim::wait_for(path_ / "claims" / "study");
  std::error_code unknown;
  if (!fs::exists(file, unknown)) {
    keep_study(path_, request);
    write_file(file, own.dump(2) + "\n");
    return;
  }
  const Json there = Json::parse(read_input_file(file.string()), nullptr, false);
  if (there == own) {
    keep_study(path_, request);
    return;
  }
  std::string differs;
  for (const auto& [what, value] : own.items()) {
    if (!there.is_object() || !there.contains(what) || there[what] != value)
      differs += (differs.empty() ? "" : ", ") + what;
  }
  throw Error(Exit::bad_input,
              fmt::format("{0}: has the samples of another study (different: {1}); choose another folder with --out, "
                          "remove this one, or go on with the study as it was when it was begun: give {0} in place of "
                          "the study",
                          path_.string(), differs.empty() ? "files or laws that it has no more" : differs));
}

fs::path StudyFolder::sample(std::uint64_t number) const { return path_ / "samples" / fmt::format("{:06}", number); }
fs::path StudyFolder::claim(std::uint64_t number) const { return path_ / "claims" / fmt::format("{:06}", number); }

std::string table_text(const std::vector<std::pair<std::uint64_t, Sample>>& samples,
                       const std::vector<std::string>& outputs) {
  // A sample that failed early has no random properties of joints: columns are those of the sample with the most.
  const Values* inputs = nullptr;
  for (const auto& [number, sample] : samples) {
    if (!inputs || sample.inputs.size() > inputs->size()) inputs = &sample.inputs;
  }
  std::string text = "sample,status,reason";
  for (std::size_t i = 0; inputs && i < inputs->size(); ++i) text += "," + csv_text((*inputs)[i].first);
  for (const std::string& name : outputs) text += "," + name;
  text += '\n';
  const auto add = [&](const Values& values, const std::string& name) {
    for (const auto& [known, value] : values) {
      if (known == name) return "," + csv_number(value);
    }
    return std::string(",");
  };
  for (const auto& [number, sample] : samples) {
    text += fmt::format("{},{},{}", number, sample.status, sample.reason.empty() ? "" : csv_text(sample.reason));
    for (std::size_t i = 0; i < inputs->size(); ++i) text += add(sample.inputs, (*inputs)[i].first);
    for (const std::string& name : outputs) text += add(sample.outputs, name);
    text += '\n';
  }
  return text;
}

}  // namespace quoin::ensemble
