#include "law/law_library.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <utility>

#include "base/did_you_mean.h"
#include "base/error.h"
#include "base/input_file.h"
#include "base/printable.h"
#include "law/elf_file.h"
#include "law/law_calls.h"
#include "law/law_process.h"
#include "law/law_trial.h"
#include "law/law_watch.h"
#include "law/metadata.h"

namespace quoin {

namespace fs = std::filesystem;

namespace {

constexpr char kHostName[] = "quoin";
constexpr char kHostVersion[] = "0.1.0";

[[noreturn]] void refuse(const std::string& message) { throw Error(Exit::law_refused, message); }

fs::path program_folder() {
  std::error_code fault;
  const fs::path program = fs::read_symlink("/proc/self/exe", fault);
  return fault ? fs::path(".") : program.parent_path();
}

std::vector<fs::path>& added_folders() {
  static std::vector<fs::path> folders;
  return folders;
}

// Folders of laws, in the order of the search.
std::vector<fs::path> search_folders() {
  std::vector<fs::path> folders;
  if (const char* variable = std::getenv("QUOIN_LAW_PATH")) {
    const std::string list = variable;
    for (std::size_t begin = 0; begin <= list.size();) {
      const std::size_t end = std::min(list.find(':', begin), list.size());
      if (end > begin) folders.emplace_back(list.substr(begin, end - begin));
      begin = end + 1;
    }
  }
  folders.insert(folders.end(), added_folders().begin(), added_folders().end());
  const fs::path program = program_folder();
  folders.push_back(program / "laws");
  std::vector<fs::path> installed;
  std::error_code fault;
  for (const auto& entry : fs::directory_iterator(program.parent_path(), fault)) {
    if (!entry.path().filename().string().starts_with("lib")) continue;
    installed.push_back(entry.path() / "quoin" / "laws");
    // Debian's multiarch libdir: lib/x86_64-linux-gnu
    std::error_code inner;
    for (const auto& sub : fs::directory_iterator(entry.path(), inner)) {
      if (fs::is_directory(sub.path() / "quoin" / "laws", inner)) installed.push_back(sub.path() / "quoin" / "laws");
    }
  }
  std::sort(installed.begin(), installed.end());
  for (auto& folder : installed) {
    if (fs::is_directory(folder, fault)) folders.push_back(std::move(folder));
  }
  return folders;
}

bool is_path(const std::string& name_or_path) { return name_or_path.find('/') != std::string::npos; }

std::string resolve(const std::string& name_or_path) {
  std::error_code fault;
  if (is_path(name_or_path)) {
    if (fs::is_directory(name_or_path, fault)) {
      refuse(
          fmt::format("law '{}' could not be loaded: it is a folder; give the path of a shared library", name_or_path));
    }
    if (!fs::exists(name_or_path, fault)) {
      refuse(fmt::format(
          "law '{}' could not be loaded: no such file (working folder {}); check the path, or build the law",
          name_or_path, fs::current_path(fault).string()));
    }
    return name_or_path;
  }
  if (name_or_path.empty()) refuse("no law was named; give the name of a law (`quoin models` lists them) or a path");
  std::vector<std::string> tried;
  for (const fs::path& folder : search_folders()) {
    const fs::path file = folder / (name_or_path + ".so");
    if (fs::exists(file, fault)) return file.string();
    tried.push_back(file.string());
  }
  const std::vector<std::string> known = installed_laws();
  std::string remedy = known.empty()
                           ? std::string("no law was found there at all; build the laws or set QUOIN_LAW_PATH")
                           : fmt::format("laws found: {}", fmt::join(known, ", "));
  if (fs::exists(name_or_path, fault))
    remedy += fmt::format("; to load the file {0} of this folder write ./{0}", name_or_path);
  refuse(fmt::format("law '{}' could not be loaded: not found{}; tried\n  {}\n{}", name_or_path,
                     did_you_mean(name_or_path, known), fmt::join(tried, "\n  "), remedy));
}

// Copy of the bytes in memory, as a file for the loader; -1 where the system makes none. So overwriting the file does
// not change code in use. A rebuilt law is another file (dlopen identifies files by their inodes).
int copy_in_memory(const std::string& bytes) {
  const int copy = memfd_create("law", MFD_CLOEXEC);
  for (std::size_t done = 0; copy >= 0 && done < bytes.size();) {
    const ssize_t count = write(copy, bytes.data() + done, bytes.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      close(copy);
      return -1;
    }
    done += static_cast<std::size_t>(count);
  }
  return copy;
}

std::string name_of(int descriptor) { return fmt::format("/proc/self/fd/{}", descriptor); }

// Message of the loader, without the file name that dlerror puts in front.
std::string loader_reason(const std::string& path) {
  const char* words = dlerror();
  std::string reason = words == nullptr ? "unknown reason" : words;
  if (reason.starts_with(path + ": ")) reason.erase(0, path.size() + 2);
  return reason;
}

}  // namespace

std::shared_ptr<const LawLibrary> LawLibrary::load(const std::string& name_or_path) {
  static std::mutex one_at_a_time;
  static std::map<std::string, std::weak_ptr<const LawLibrary>> loaded;  // by path and bytes
  static std::set<std::string> tried;                                    // by path and bytes: trial loads that returned
  const std::lock_guard guard(one_at_a_time);
  const std::string path = resolve(name_or_path);
  const std::string failed = fmt::format("law '{}' could not be loaded from {}: ", name_or_path, path);
  std::string bytes;
  try {
    bytes = read_input_file(path);
  } catch (const Error& error) {
    refuse(failed + error.what());
  }
  const std::string key = fmt::format("{} {} {}", bytes.size(), std::hash<std::string>()(bytes), path);
  if (auto known = loaded[key].lock()) return known;
  const std::string missing = missing_of_elf(bytes);
  if (!missing.empty()) refuse(fmt::format("{}it is not whole: {}; copy or build it again", failed, missing));

  const auto make = [&] {
    const std::shared_ptr<LawLibrary> made(new LawLibrary());
    made->path_ = path;
    made->open(bytes, failed);
    return made;
  };
  if (!tried.contains(key)) {
    if (const std::string fault = fault_of_loading(make, law_loading_seconds); !fault.empty())
      refuse(fmt::format("law library {} {} while it was loaded; tell its author", path, fault));
    tried.insert(key);
  }
  const WatchedLoading watched(path);
  const std::shared_ptr<LawLibrary> result = make();
  loaded[key] = result;
  return result;
}

void LawLibrary::open(const std::string& bytes, const std::string& failed) {
  // RTLD_LOCAL: two laws may share symbol names. RTLD_NOW: a missing symbol is an error at load, not in the middle of a
  // run.
  constexpr int kMode = RTLD_NOW | RTLD_LOCAL;
  if (std::getenv("QUOIN_LAW_IN_PLACE") == nullptr) copy_ = copy_in_memory(bytes);
  if (copy_ >= 0) handle_ = dlopen(name_of(copy_).c_str(), kMode);
  // A law may need files beside it, and a system may refuse to run code from memory.
  if (handle_ == nullptr) handle_ = dlopen(path_.c_str(), kMode);
  if (handle_ == nullptr) {
    refuse(fmt::format("{}the dynamic loader says: {}; give a shared library built for this machine", failed,
                       loader_reason(path_)));
  }

  dlerror();
  const auto entry = reinterpret_cast<quoin_library_function>(dlsym(handle_, QUOIN_LIBRARY_SYMBOL));
  if (entry == nullptr) {
    refuse(fmt::format("{}it is a shared library, but it exports no {}, so it is no contact law of ABI version {}",
                       failed, QUOIN_LIBRARY_SYMBOL, QUOIN_ABI_MAJOR));
  }
  entry_ = reinterpret_cast<const void*>(entry);
  note_law(entry_, path_);

  quoin_host_info host{};
  host.struct_size = sizeof host;
  host.abi_major = QUOIN_ABI_MAJOR;
  host.abi_minor = QUOIN_ABI_MINOR;
  host.name = kHostName;
  host.version = kHostVersion;
  const quoin_library* library = nullptr;
  const std::string words = printable(quoin::api::text_of([&](quoin_text* text) { library = entry(&host, text); }));
  if (library == nullptr) {
    refuse(fmt::format(
        "{}the library refuses this host (ABI {}.{}): {}; rebuild one of the two against the other's headers", failed,
        QUOIN_ABI_MAJOR, QUOIN_ABI_MINOR, words.empty() ? "it gives no reason" : words));
  }
  // Only the first three fields may be read before the version is known.
  if (!is_readable(library, sizeof(uint64_t))) refuse(failed + "its quoin_library is at no place of the memory");
  constexpr uint64_t kHead = offsetof(quoin_library, abi_minor) + sizeof(uint32_t);
  if (library->struct_size < kHead) {
    refuse(fmt::format("{}its quoin_library has {} bytes: it was not filled in", failed, library->struct_size));
  }
  if (library->abi_major != QUOIN_ABI_MAJOR) {
    refuse(fmt::format("{}it was built against ABI version {}.{}, this host needs {}.x; rebuild the law", failed,
                       library->abi_major, library->abi_minor, QUOIN_ABI_MAJOR));
  }
  if (library->struct_size < sizeof(quoin_library)) {
    refuse(fmt::format("{}its quoin_library has {} bytes, but version {}.0 has {}", failed, library->struct_size,
                       QUOIN_ABI_MAJOR, sizeof(quoin_library)));
  }
  if (library->law_count == 0 || library->laws == nullptr) refuse(failed + "the library holds no law");
  const std::string fault = fault_of_tables(*library);
  if (!fault.empty()) refuse(fmt::format("{}its metadata is faulty: {}; tell its author", failed, fault));
  library_ = library;
}

LawLibrary::~LawLibrary() {
  if (handle_ == nullptr) {
    if (copy_ >= 0) close(copy_);
    return;
  }
  unregister_law(entry_);
  dlclose(handle_);
  if (copy_ < 0) return;
  // The loader identifies libraries by their names too: the name of a library that it keeps loaded must stay in use.
  void* const kept = dlopen(name_of(copy_).c_str(), RTLD_NOW | RTLD_NOLOAD);
  if (kept != nullptr) dlclose(kept);
  if (kept == nullptr) close(copy_);
}

Law Law::find(const std::string& name_or_path) {
  Law result;
  result.library = LawLibrary::load(name_or_path);
  const quoin_library& info = result.library->info();
  if (is_path(name_or_path)) {
    result.law = info.laws[0];
    return result;
  }
  std::vector<std::string> ids;
  for (uint64_t i = 0; i < info.law_count; ++i) {
    if (name_or_path == info.laws[i]->id) {
      result.law = info.laws[i];
      return result;
    }
    ids.emplace_back(info.laws[i]->id);
  }
  refuse(fmt::format("law '{}': {} holds no law of that id, only: {}; give the library's path to use its first law",
                     name_or_path, result.library->path(), fmt::join(ids, ", ")));
}

int Law::state_index(const std::string& id) const {
  for (uint64_t i = 0; i < law->state_count; ++i) {
    if (id == law->states[i]->id) return static_cast<int>(i);
  }
  return -1;
}

std::string Law::thrown_text() const {
  std::string words = "an object that is no std::exception";
  try {
    throw;
  } catch (const std::exception& error) {
    words = fmt::format("\"{}\"", printable(error.what()));
  } catch (...) {
  }
  return fmt::format(
      "the law '{}' of {} threw an exception, which no law may: {}; tell its author or choose another law", law->id,
      library->path(), words);
}

void Law::refuse_thrown() const { refuse(thrown_text()); }

namespace {

// Whether the line has the id as a whole word: "cohesion_residual" does not match cohesion.
bool names(const std::string& line, const std::string& id) {
  const auto is_word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
  for (std::size_t at = line.find(id); at != std::string::npos; at = line.find(id, at + 1)) {
    const std::size_t end = at + id.size();
    if ((at == 0 || !is_word(line[at - 1])) && (end == line.size() || !is_word(line[end]))) return true;
  }
  return false;
}

bool has_property(const quoin_law& law, const std::string& id) {
  return std::any_of(law.properties, law.properties + law.property_count,
                     [&](const quoin_property_info* info) { return id == info->id; });
}

// Lines of a law's text, printable, each preceded by the sources of the properties that it names. A line about an
// unknown property, which may list the known ones, has the source of that one only.
std::string with_sources(const std::string& words, const quoin_law& law,
                         const std::vector<const PropertySetting*>& settings) {
  const std::string text = printable(words);
  std::string result;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string line = text.substr(begin, end - begin);
    begin = end + 1;
    if (line.empty()) continue;
    const bool unknown = std::ranges::any_of(settings, [&](const PropertySetting* setting) {
      return line.starts_with(setting->id + ":") && !has_property(law, setting->id);
    });
    std::vector<std::string> sources;
    for (const PropertySetting* setting : settings) {
      const std::string& source = setting->source.text;
      if (source.empty() || !names(line, setting->id)) continue;
      if (unknown && !line.starts_with(setting->id + ":")) continue;
      if (std::find(sources.begin(), sources.end(), source) == sources.end()) sources.push_back(source);
    }
    if (!result.empty()) result += '\n';
    result += sources.empty() ? line : fmt::format("{}: {}", fmt::join(sources, ", "), line);
  }
  return result;
}

// A later setting of an id replaces an earlier one: --set replaces the scene's.
std::vector<const PropertySetting*> in_force(const std::vector<PropertySetting>& settings) {
  std::vector<const PropertySetting*> used;
  for (const PropertySetting& setting : settings) {
    std::erase_if(used, [&](const PropertySetting* other) { return other->id == setting.id; });
    used.push_back(&setting);
  }
  return used;
}

thread_local LawIsolation isolation;

quoin::api::Material make_material(const Law& of, const std::vector<const PropertySetting*>& settings) {
  const quoin_law& law = *of.law;
  std::vector<quoin::api::Value> values;
  for (const PropertySetting* setting : settings) values.push_back({setting->id, setting->numbers, setting->text});
  try {
    return {law, values};
  } catch (const quoin::api::Error& error) {
    const std::string detail = error.words.empty() ? "it gives no reason" : with_sources(error.words, law, settings);
    if (error.status == QUOIN_ERROR_PROPERTY)
      refuse(fmt::format("law '{}' refuses its properties:\n{}", law.id, detail));
    refuse(fmt::format("law '{}' made no material (status {}): {}", law.id, error.status, detail));
  } catch (const std::bad_alloc&) {  // memory may run out in our code too
    throw;
  } catch (...) {
    refuse(of.thrown_text());
  }
}

}  // namespace

struct Material::Thrown {
  std::atomic<bool> any{false};
  std::mutex mutex;  // guards the text
  std::string text;  // of the first exception
};

Material::Material(Law law, const std::vector<PropertySetting>& settings)
    : law_(std::move(law)),
      material_(make_material(law_, in_force(settings))),
      warnings_(with_sources(material_.warnings(), *law_.law, in_force(settings))),
      thrown_(std::make_shared<Thrown>()) {
  if (isolation.threads > 0)
    process_ =
        std::make_shared<LawProcess>(api(), handle(), law_.library->path(), isolation.threads, isolation.seconds);
}

quoin_status Material::evaluate(quoin_batch* batch) const {
  if (process_) return process_->evaluate(batch);
  if (thrown_->any.load(std::memory_order_relaxed)) return QUOIN_ERROR_INTERNAL;
  const LawCallNote note(this, batch);
  try {
    return api().evaluate(handle(), batch);
  } catch (...) {
    const std::lock_guard guard(thrown_->mutex);
    if (!thrown_->any.exchange(true)) thrown_->text = law_.thrown_text();
    return QUOIN_ERROR_INTERNAL;
  }
}

std::string Material::fault() const {
  if (process_) return process_->fault();
  const std::lock_guard guard(thrown_->mutex);
  return thrown_->text;
}

void Material::require_no_fault(Exit code) const {
  if (const std::string text = fault(); !text.empty()) throw Error(code, text);
}

LawIsolation isolate_laws(const LawIsolation& wanted) { return std::exchange(isolation, wanted); }

double Material::number(const std::string& property_id) const {
  double value = 0.0;
  const quoin_status status = law_.call([&] { return api().material_number(handle(), property_id.c_str(), &value); });
  if (status != QUOIN_OK) refuse(fmt::format("law '{}' has no number property '{}'", api().id, property_id));
  return value;
}

std::vector<double> Material::initial_state(const std::string& id) const {
  std::vector<std::string> known;
  bool found = false;
  for (uint64_t i = 0; i < api().initial_state_count; ++i) {
    known.emplace_back(api().initial_states[i]);
    found = found || known.back() == id;
  }
  std::vector<double> values(api().state_count, 0.0);
  if (!found || law_.call([&] { return api().initial_state(handle(), id.c_str(), values.data()); }) != QUOIN_OK) {
    throw Error(Exit::bad_input,
                fmt::format("initial state '{}': law '{}' knows {}", id, api().id, fmt::join(known, ", ")));
  }
  return values;
}

void add_law_folder(const std::string& folder) { added_folders().emplace_back(folder); }

std::vector<std::string> installed_laws() {
  std::set<std::string> found;
  std::error_code fault;
  for (const fs::path& folder : search_folders()) {
    for (const auto& entry : fs::directory_iterator(folder, fault)) {
      if (entry.path().extension() == ".so") found.insert(entry.path().stem().string());
    }
  }
  return {found.begin(), found.end()};
}

}  // namespace quoin
