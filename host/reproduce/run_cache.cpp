#include "reproduce/run_cache.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "base/error.h"
#include "base/fnv_hash.h"
#include "files/file.h"
#include "files/notice.h"
#include "law/law_library.h"

namespace quoin::reproduce {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using Json = nlohmann::json;
using namespace nlohmann::literals;

volatile std::sig_atomic_t stop_asked = 0;
extern "C" void ask_stop(int) { stop_asked = 1; }

std::string read_text(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// Hash of all that a run depends on, as its name.
std::uint64_t hash_of(const std::string& text, std::uint64_t start = kOtherHashStart) {
  FnvHash hash(start);
  hash.add(text);
  return hash.value();
}

// Small displacements to the end, as in the paper, with a warning beyond their bound. Their effect on curves is in
// benchmarks/README.md.
constexpr const char* kLargeMotion = "solver.large_motion";

bool named(const std::vector<std::string>& overrides, const std::string& key) {
  return std::any_of(overrides.begin(), overrides.end(), [&](const auto& o) { return o.rfind(key + "=", 0) == 0; });
}

Json read_summary(const fs::path& folder) { return Json::parse(read_text(folder / "summary.json"), nullptr, false); }

pid_t start(const std::vector<std::string>& words, const fs::path& log) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const std::string log_name = log.string();
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child != 0) return child;
  // A run ends with the program that has requested it: as after Ctrl-C, with its results so far.
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(127);
  const int out = open(log_name.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (out >= 0) {
    dup2(out, STDOUT_FILENO);
    dup2(out, STDERR_FILENO);
  }
  execv("/proc/self/exe", arguments.data());
  _exit(127);
}

bool is_refusal(int code) {
  return code == static_cast<int>(Exit::bad_input) || code == static_cast<int>(Exit::law_refused);
}

std::string last_line(const fs::path& log) {
  std::string text = read_text(log);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  const std::size_t at = text.rfind('\n');
  return at == std::string::npos ? text : text.substr(at + 1);
}

// Records signals while runs are in progress, and forwards them.
class StopHandler {
 public:
  StopHandler() {
    stop_asked = 0;
    struct sigaction action {};
    action.sa_handler = ask_stop;
    sigaction(SIGINT, &action, &old_int_);
    sigaction(SIGTERM, &action, &old_term_);
  }
  ~StopHandler() {
    sigaction(SIGINT, &old_int_, nullptr);
    sigaction(SIGTERM, &old_term_, nullptr);
  }
  StopHandler(const StopHandler&) = delete;
  StopHandler& operator=(const StopHandler&) = delete;

 private:
  struct sigaction old_int_ {
  }, old_term_{};
};

}  // namespace

RunCache::RunCache(CacheSettings settings) : settings_(std::move(settings)) {
  binaries_ = hash_of(read_text("/proc/self/exe"));
  for (const std::string& law : installed_laws()) {
    try {
      binaries_ = hash_of(read_text(LawLibrary::load(law)->path()), binaries_);
    } catch (const Error&) {  // a run with this law reports the fault
    }
  }
}

std::string RunCache::key(const RunSpec& spec) const {
  const fs::path scene = settings_.scenes / (spec.scene + ".toml");
  const std::string text = read_text(scene);
  if (text.empty()) throw Error(Exit::bad_input, scene.string() + ": the scene cannot be read; set QUOIN_SCENES");
  std::string all = text + "\nlaw=" + spec.law;
  for (const std::string& o : spec.overrides) all += "\n" + o;
  for (const std::string& o : settings_.overrides) all += "\n" + o;
  const std::uint64_t hash = hash_of(all, binaries_);
  return fmt::format("{}{}-{:08x}", spec.scene, spec.law.empty() ? "" : "-" + spec.law,
                     static_cast<std::uint32_t>(hash ^ (hash >> 32)));
}

bool RunCache::done(const RunSpec& spec) const {
  const Json summary = read_summary(folder(spec));
  const std::string status = summary.is_object() ? summary.value("status", "") : "";
  return status == "done" || (spec.may_fail && status == "failed");
}

int RunCache::compute(const std::vector<RunSpec>& specs) {
  std::vector<const RunSpec*> queue;
  std::set<std::string> seen;
  for (const RunSpec& spec : specs) {
    if (seen.insert(key(spec)).second && (settings_.again || !done(spec))) queue.push_back(&spec);
  }
  if (queue.empty()) return 0;
  std::stable_sort(queue.begin(), queue.end(), [](const RunSpec* a, const RunSpec* b) { return a->cost > b->cost; });
  notice(fmt::format("{} runs, {} of them done before; {} side by side", seen.size(), seen.size() - queue.size(),
                     std::min<std::size_t>(queue.size(), static_cast<std::size_t>(settings_.jobs))));

  struct Job {
    const RunSpec* spec;
    int threads;
    Clock::time_point since;
  };
  std::map<pid_t, Job> running;
  std::size_t next = 0, finished = 0;
  int threads_used = 0, code = 0;
  StopHandler handler;
  bool reported = false;
  while (next < queue.size() || !running.empty()) {
    while (!stop_asked && next < queue.size() && threads_used < settings_.jobs) {
      const RunSpec& spec = *queue[next++];
      // One thread per run is the best use of cores. The last runs share those that are free.
      const int left = static_cast<int>(queue.size() - next);
      const int threads = std::max(1, (settings_.jobs - threads_used) / (left + 1));
      make_folder(folder(spec));
      std::error_code ignored;
      fs::remove(folder(spec) / "summary.json", ignored);
      std::vector<std::string> words{"quoin",
                                     "run",
                                     (settings_.scenes / (spec.scene + ".toml")).string(),
                                     "--out",
                                     folder(spec).string(),
                                     "--threads",
                                     std::to_string(threads)};
      if (!spec.law.empty()) words.insert(words.end(), {"--law", spec.law});
      words.insert(words.end(), {"--set", "output.frames=0"});
      if (!named(spec.overrides, kLargeMotion) && !named(settings_.overrides, kLargeMotion))
        words.insert(words.end(),
                     {"--set", std::string(kLargeMotion) + "=never", "--set", "solver.past_motion_bound=warn"});
      for (const std::vector<std::string>* list : {&spec.overrides, &std::as_const(settings_.overrides)}) {
        for (const std::string& o : *list) words.insert(words.end(), {"--set", o});
      }
      const pid_t child = start(words, folder(spec) / "log.txt");
      if (child < 0) throw Error(Exit::numerical, "no process can be started for a run; close other programs");
      running[child] = {&spec, threads, Clock::now()};
      threads_used += threads;
    }
    if (running.empty()) break;
    if (stop_asked && !reported) {
      for (const auto& [child, job] : running) kill(child, SIGTERM);
      reported = true;
    }
    int status = 0;
    const pid_t child = waitpid(-1, &status, 0);
    if (child < 0 && errno != EINTR) break;
    const auto found = running.find(child);
    if (found == running.end()) continue;
    const Job job = found->second;
    running.erase(found);
    threads_used -= job.threads;
    ++finished;
    const bool is_done = done(*job.spec);
    if (!is_done && !is_refusal(code))
      code = WIFEXITED(status) && WEXITSTATUS(status) != 0 ? WEXITSTATUS(status) : static_cast<int>(Exit::numerical);
    notice(fmt::format("[{}/{}] {} {}: {} ({:.0f} s)", finished, queue.size(), key(*job.spec), job.spec->name,
                       is_done      ? last_line(folder(*job.spec) / "log.txt")
                       : stop_asked ? std::string("NOT DONE: interrupted")
                                    : "NOT DONE: " + last_line(folder(*job.spec) / "log.txt"),
                       std::chrono::duration<double>(Clock::now() - job.since).count()));
  }
  if (stop_asked)
    throw Error(Exit::interrupted, "stopped; runs that are done are kept, the others start again next time");
  return code;
}

RunResult RunCache::result(const RunSpec& spec) const {
  RunResult result;
  result.spec = spec;
  result.folder = folder(spec);
  const Json summary = read_summary(result.folder);
  if (!summary.is_object()) {
    result.message = "no summary.json";
    return result;
  }
  result.complete = summary.value("status", "") == "done";
  if (!result.complete) result.message = summary.value("message", "interrupted");
  result.wall_clock = summary.value("wall_clock_s", 0.0);
  result.time_step = summary.value("time_step_s", 0.0);
  result.critical_time_step = summary.value("critical_time_step_s", 0.0);
  result.bed_area = summary.value("bed_area_m2", 0.0);
  result.blocks = summary.value("blocks", 0L);
  result.beams = summary.value("beams", 0L);
  result.zones = summary.value("zones", 0L);
  result.points = summary.value("contact_points", 0L);
  result.steps = summary.value("steps", 0L);
  int cycles_stage = 0;
  for (const Json& stage : summary.value("/settings/stages"_json_pointer, Json::array())) {
    ++cycles_stage;
    if (!stage.contains("cycles")) continue;
    const Json& given = stage["cycles"];
    result.cycles = Cycles{given["amplitudes_m"].get<std::vector<double>>(),
                           given["counts"].get<std::vector<int>>(),
                           given.value("velocity_m_per_s", 0.0),
                           stage.value("ramp_time_s", 0.0),
                           {}};
    break;
  }
  // The first stage only applies the vertical load.
  if (result.complete) result.curve = read_history(result.folder / "history.csv", 2, result.cycles, cycles_stage);
  return result;
}

std::filesystem::path find_scenes() {
  std::vector<fs::path> places;
  if (const char* given = std::getenv("QUOIN_SCENES")) {
    places.emplace_back(given);
  } else {
    std::error_code ignored;
    const fs::path beside = fs::read_symlink("/proc/self/exe", ignored).parent_path();
    places = {"host/scenes", beside / "../../host/scenes", beside / "../share/quoin/scenes", QUOIN_SOURCE_SCENES};
  }
  std::string tried;
  for (const fs::path& place : places) {
    if (fs::exists(place / "solid_wall_030.toml")) return fs::absolute(place).lexically_normal();
    tried += (tried.empty() ? "" : ", ") + place.string();
  }
  throw Error(Exit::bad_input, "the shipped scenes were not found in " + tried + "; set QUOIN_SCENES to their folder");
}

}  // namespace quoin::reproduce
