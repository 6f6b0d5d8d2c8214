#include "files/result_folder.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fnmatch.h>
#include <signal.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <mutex>
#include <set>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "base/error.h"
#include "files/file.h"
#include "files/notice.h"

namespace quoin {

namespace {

namespace fs = std::filesystem;

constexpr const char* kLock = ".quoin-lock";
constexpr const char* kPage = "report.html";
constexpr const char* kManifest = ".quoin-manifest";
constexpr const char* kManifestHead = "results of quoin, partial files .";  // the token of the process follows

// Names of results; other files with these names are an error.
constexpr std::array kNames{
    "summary.json",      "history.csv",      "curve.png",          "cracks.png",         "mechanism.png",
    "blocks.pvd",        "joints.pvd",       "forces.pvd",         "forces_*.vtu",       "blocks_*.vt[pu]",
    "joints_*.vt[pu]",   "blocks_*.pvtu",    "joints_*.pvtu",      "plots/curve.*",      "plots/cracks.*",
    "plots/mechanism.*", "plots/bricks.dat", "plots/beams.dat",    "plots/joints_*.dat", "run.json",
    "checkpoint.bin",    "end_state.bin",    "sample.json",        "cracks.csv",         "histories.png",
    "curve.svg",         "cracks.svg",       "mechanism.svg",      "histories.svg",      "plots/histories.*",
    "monitors.csv",      "monitors.json",    "members.pvd",        "members_*.vtu",      "report.html",
    "base_shear.png",    "base_shear.svg",   "plots/base_shear.*", "drifts.png",         "drifts.svg",
    "plots/drifts.*"};

bool matches(const char* pattern, const std::string& name) {
  return fnmatch(pattern, name.c_str(), FNM_PATHNAME | FNM_PERIOD) == 0;
}
bool is_name_of_a_result(const std::string& name) {
  return std::any_of(kNames.begin(), kNames.end(), [&](const char* pattern) { return matches(pattern, name); });
}

// Whether a file is a page of quoin by its mark. `quoin report` adds pages after a run.
bool is_own_page(const fs::path& file) {
  std::error_code error;
  if (!fs::is_regular_file(fs::symlink_status(file, error))) return false;
  std::string head(300, '\0');
  std::ifstream(file).read(head.data(), static_cast<std::streamsize>(head.size()));
  return head.find(kPageMark) != std::string::npos;
}

struct Manifest {
  std::set<std::string> names;  // relative to the folder
  std::string token;            // token in the names of partial files
};

// Reads a manifest, which may come from outside: only names inside the folder that a run could have written count.
Manifest read_names(const fs::path& file) {
  Manifest manifest;
  std::ifstream stream(file);
  std::string line;
  const std::string head = kManifestHead;
  if (!std::getline(stream, line) || !line.starts_with(head)) return manifest;
  manifest.token = line.substr(head.size());
  const bool sane =
      std::all_of(manifest.token.begin(), manifest.token.end(), [](unsigned char c) { return std::isxdigit(c) != 0; });
  if (!sane) return {};
  while (std::getline(stream, line)) {
    if (is_name_of_a_result(line) || line == "plots" || matches("plots/*", line)) manifest.names.insert(line);
  }
  return manifest;
}

std::vector<fs::path> manifests_of_ranks(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code error;
  const std::string pattern = fmt::format("{}_r*", kManifest);
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (matches(pattern.c_str(), entry.path().filename().string()) && !read_names(entry.path()).token.empty())
      found.push_back(entry.path());
  }
  return found;
}

// Names of all ranks of the last run. Lists of ranks of an earlier one have another token.
Manifest read_manifest(const fs::path& folder) {
  Manifest manifest = read_names(folder / kManifest);
  for (const fs::path& file : manifests_of_ranks(folder)) {
    Manifest of_rank = read_names(file);
    if (of_rank.token == manifest.token) manifest.names.merge(of_rank.names);
  }
  return manifest;
}

// Names of results of quoin in a folder.
Manifest own_results(const fs::path& folder) {
  Manifest manifest = read_manifest(folder);
  if (is_own_page(folder / kPage)) manifest.names.insert(kPage);
  return manifest;
}

bool made_plots(const Manifest& manifest) {
  return std::any_of(manifest.names.begin(), manifest.names.end(),
                     [](const std::string& name) { return name == "plots" || name.starts_with("plots/"); });
}

// Whether a file is a partial file of the last run, by its token. A killed run may not have added it to the manifest
// yet.
bool is_part_of(const Manifest& manifest, const std::string& name) {
  return !manifest.token.empty() && name.ends_with(fmt::format(".{}.part", manifest.token));
}

void refuse_what_others_wrote(const fs::path& folder, const Manifest& manifest) {
  std::vector<std::string> foreign;
  std::error_code error;
  const fs::path plots = folder / "plots";
  const fs::file_status kind = fs::symlink_status(plots, error);
  if (fs::is_directory(kind) && made_plots(manifest)) {
    for (const auto& entry : fs::directory_iterator(plots, error)) {
      const std::string name = "plots/" + entry.path().filename().string();
      if (is_name_of_a_result(name) && !manifest.names.contains(name) && !is_part_of(manifest, name))
        foreign.push_back(name);
    }
  } else if (fs::exists(kind) && !(fs::is_directory(kind) && fs::is_empty(plots, error))) {
    foreign.emplace_back("plots");
  }
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (is_name_of_a_result(name) && !manifest.names.contains(name) && !is_part_of(manifest, name))
      foreign.push_back(name);
  }
  if (foreign.empty()) return;
  std::sort(foreign.begin(), foreign.end());
  const std::string others = foreign.size() > 1 ? fmt::format(" and {} more", foreign.size() - 1) : "";
  throw Error(Exit::bad_input,
              fmt::format("{}: has {}{}, which the last run of quoin in this folder did not write ({} lists what it "
                          "wrote), and a run gives its results that name; move it away or choose another folder with "
                          "--out",
                          folder.string(), foreign[0], others, kManifest));
}

// Removes old results; returns whether the folder for plots, which was ours, is kept as others have files there.
bool remove_old_results(const fs::path& folder, const Manifest& manifest, const std::set<std::string>& kept) {
  for (const std::string& name : manifest.names) {
    if (name == "plots") continue;
    for (const std::string& file : {name, fmt::format("{}.{}.part", name, manifest.token)}) {
      if (kept.contains(file)) continue;
      std::error_code error;
      fs::remove(folder / file, error);
      if (error)
        throw Error(Exit::bad_input, fmt::format("{}: an earlier result cannot be removed: {}; choose another folder "
                                                 "with --out",
                                                 (folder / file).string(), error.message()));
    }
  }
  for (const fs::path& place : {folder, folder / "plots"}) {
    std::vector<fs::path> parts;
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(place, none)) {
      if (is_part_of(manifest, entry.path().filename().string()) && entry.is_regular_file(none))
        parts.push_back(entry.path());
    }
    for (const fs::path& part : parts) fs::remove(part, none);
  }
  if (!made_plots(manifest)) return false;
  std::error_code not_empty;
  fs::remove(folder / "plots", not_empty);
  return static_cast<bool>(not_empty);
}

// Result folders of this process, with their open manifests.
struct OpenFolder {
  fs::path path;
  std::ofstream manifest;
  std::set<std::string> noted;
};
std::mutex mutex;
std::vector<OpenFolder> open_folders;

fs::path whole_path(const fs::path& path) { return fs::absolute(path).lexically_normal(); }

// Begins a manifest of this process with names of files that are there. Returns the path of the folder.
fs::path open_manifest(const fs::path& folder, const std::string& name, const std::set<std::string>& names) {
  const fs::path path = folder / name, part = part_name(path);
  std::error_code error;
  fs::remove(part, error);  // removed first, so that a link is never followed
  OpenFolder open_folder{whole_path(folder), std::ofstream(part, std::ios::trunc), names};
  open_folder.manifest << kManifestHead << part_token() << '\n';
  for (const std::string& known : names) open_folder.manifest << known << '\n';
  open_folder.manifest.flush();
  if (open_folder.manifest) fs::rename(part, path, error);
  if (!open_folder.manifest || error)
    throw Error(Exit::bad_input, path.string() + ": cannot be written; choose another folder with --out");
  const std::lock_guard guard(mutex);
  open_folders.push_back(std::move(open_folder));
  return open_folders.back().path;
}

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
}

}  // namespace

namespace {

// A process that is killed while it starts a child leaves its lock to the child, until that closes its descriptors.
constexpr std::chrono::milliseconds kWait{10};
constexpr int kMostWaits = 300;

// Whether the named holder has ended on this machine. The actual holder then releases the lock soon, or has not written
// its name yet.
bool has_died(const std::string& holder) {
  int process = 0, read = 0;
  if (std::sscanf(holder.c_str(), "process %d on %n", &process, &read) != 1 || process <= 0 || read == 0) return false;
  return holder.substr(static_cast<size_t>(read)).starts_with(host_name() + " since ") && kill(process, 0) != 0 &&
         errno == ESRCH;
}

}  // namespace

FolderLock::FolderLock(const fs::path& folder) {
  make_folder(folder);
  const fs::path path = folder / kLock;
  const auto message = [](int code) { return std::error_code(code, std::generic_category()).message(); };
  // Close on exec: gnuplot and other children would keep the lock when this process dies.
  file_ = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644);
  if (file_ < 0)
    throw Error(Exit::bad_input, fmt::format("{}: cannot be written: {}; choose another folder with --out",
                                             path.string(), message(errno)));
  for (int waits = 0; flock(file_, LOCK_EX | LOCK_NB) != 0; ++waits) {
    const int fault = errno;
    if (fault != EWOULDBLOCK) {
      notice(fmt::format("quoin: warning: {} cannot be locked ({}): start no second run in this folder",
                         folder.string(), message(fault)));
      return;
    }
    std::array<char, 300> text{};
    const ssize_t size = pread(file_, text.data(), text.size(), 0);
    std::string holder(text.data(), size > 0 ? static_cast<size_t>(size) : 0);
    if (waits < kMostWaits && has_died(holder)) {
      std::this_thread::sleep_for(kWait);
      continue;
    }
    close(file_);
    std::erase_if(holder, [](unsigned char c) { return c < 0x20 || c == 0x7f; });
    throw Error(Exit::bad_input,
                fmt::format("{}: in use by another run{}; wait for its end or choose another folder with --out",
                            folder.string(), holder.empty() ? "" : " (" + holder + ")"));
  }
  const std::string holder = fmt::format("process {} on {} since {:%Y-%m-%d %H:%M:%S} UTC\n", getpid(), host_name(),
                                         fmt::gmtime(std::time(nullptr)));
  if (ftruncate(file_, 0) != 0 || pwrite(file_, holder.data(), holder.size(), 0) < 0) {
    // The lock is valid without it; only messages to others have no name.
  }
}

FolderLock::~FolderLock() { close(file_); }

ResultFolder::ResultFolder(const fs::path& folder, std::shared_ptr<FolderLock> held,
                           const std::function<bool(const std::string&)>& is_kept)
    : lock_(held ? std::move(held) : std::make_shared<FolderLock>(folder)) {
  const Manifest old = own_results(folder);
  refuse_what_others_wrote(folder, old);
  std::set<std::string> kept;
  for (const std::string& name : old.names) {
    if (is_kept && is_kept(name) && fs::exists(folder / name)) kept.insert(name);
  }
  const bool plots_kept = remove_old_results(folder, old, kept);
  // There is a manifest at any moment: a run that is killed here finds its results when it is resumed.
  if (plots_kept) kept.insert("plots");
  path_ = open_manifest(folder, kManifest, kept);
  for (const fs::path& file : manifests_of_ranks(folder)) {
    std::error_code ignored;
    fs::remove(file, ignored);
  }
}

ResultFolder::~ResultFolder() {
  const std::lock_guard guard(mutex);
  std::erase_if(open_folders, [&](const OpenFolder& f) { return f.path == path_; });
}

void note_results_of_rank(const fs::path& folder, int rank) {
  open_manifest(folder, fmt::format("{}_r{}", kManifest, rank), {});
}

void refuse_folder_of_run(const fs::path& folder) {
  std::error_code error;
  if (!fs::exists(folder / kManifest, error)) return;
  throw Error(Exit::bad_input, fmt::format("{}: has the results of a run, and files of the same names would replace "
                                           "them; choose another folder with --out",
                                           folder.string()));
}

namespace {

constexpr const char* kOwnFiles = ".quoin-files";

bool is_there(const fs::path& file) {
  std::error_code error;
  return fs::exists(fs::symlink_status(file, error));
}

// Listed names of files that are still there: one that was removed may be someone else's when it comes back.
std::set<std::string> own_files(const fs::path& folder) {
  std::set<std::string> names;
  std::ifstream stream(folder / kOwnFiles);
  for (std::string line; std::getline(stream, line);) {
    if (is_there(folder / line)) names.insert(line);
  }
  return names;
}

}  // namespace

void refuse_files_of_others(const fs::path& folder, const std::vector<std::string>& names) {
  const std::set<std::string> own = own_files(folder);
  for (const std::string& name : names) {
    if (!is_there(folder / name) || own.contains(name)) continue;
    throw Error(
        Exit::bad_input,
        fmt::format("{0}: has {1}, which would be replaced, and quoin has not written it ({2} lists what it wrote; "
                    "versions before this one wrote no list); move {1} away or choose another folder with --out",
                    folder.string(), name, kOwnFiles));
  }
}

void list_own_files(const fs::path& folder, const std::vector<std::string>& names) {
  refuse_files_of_others(folder, names);
  make_folder(folder);
  std::set<std::string> own = own_files(folder);
  own.insert(names.begin(), names.end());
  std::string text;
  for (const std::string& name : own) text += name + '\n';
  write_file(folder / kOwnFiles, text);
}

void refuse_page_of_others(const fs::path& page) {
  std::error_code error;
  if (!fs::exists(fs::symlink_status(page, error)) ||
      own_results(page.parent_path()).names.contains(page.filename().string()))
    return;
  throw Error(Exit::bad_input,
              fmt::format("{}: is no page of quoin, and would be overwritten; move it away", page.string()));
}

void note_result(const fs::path& file) {
  const fs::path whole = whole_path(file);
  const std::lock_guard guard(mutex);
  for (OpenFolder& folder : open_folders) {
    const std::string name = whole.lexically_relative(folder.path).generic_string();
    if (name.starts_with("..")) continue;
    if (folder.noted.insert(name).second) folder.manifest << name << std::endl;
  }
}

}  // namespace quoin
