#include "shared/law_library.h"

#include <array>
#include <cstdlib>
#include <map>
#include <mutex>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "quoin/layout_asserts.h"
#include "shared/point.h"

#if defined(_WIN32)
#include <windows.h>
#else
#include <dlfcn.h>
#endif

namespace quoin::adapters {

namespace {

#if defined(_WIN32)
constexpr char path_separator = ';';
constexpr const char* suffix = ".dll";

quoin_library_function entry_point(const std::filesystem::path& file) {
  const HMODULE module = LoadLibraryW(file.c_str());
  if (module == nullptr)
    throw std::runtime_error(file.string() + ": LoadLibrary: error " + std::to_string(GetLastError()));
  return reinterpret_cast<quoin_library_function>(
      reinterpret_cast<void*>(GetProcAddress(module, QUOIN_LIBRARY_SYMBOL)));
}
#else
constexpr char path_separator = ':';
constexpr const char* suffix = ".so";

quoin_library_function entry_point(const std::filesystem::path& file) {
  void* handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) throw std::runtime_error(dlerror());
  return reinterpret_cast<quoin_library_function>(dlsym(handle, QUOIN_LIBRARY_SYMBOL));
}
#endif

const quoin_law& open(const std::filesystem::path& file) {
  const quoin_library_function entry = entry_point(file);
  const quoin_library* library = nullptr;
  try {
    library = &api::library(entry, "quoin adapter", "1.0");
  } catch (const api::Error& error) {
    throw std::runtime_error(file.string() + ": " + error.what());
  }
  const quoin_law& law = *library->laws[0];
  if (law.state_count > max_states)
    throw std::runtime_error(file.string() + ": " + law.id + " has " + std::to_string(law.state_count) +
                             " states; the adapters hold at most " + std::to_string(max_states));
  return law;
}

std::vector<std::filesystem::path> folders() {
  std::vector<std::filesystem::path> found;
  if (const char* list = std::getenv("QUOIN_LAW_PATH"); list != nullptr) {
    std::istringstream stream(list);
    for (std::string folder; std::getline(stream, folder, path_separator);)
      if (!folder.empty()) found.emplace_back(folder);
  }
  const std::filesystem::path own = own_file().parent_path();
  found.push_back(own);
  found.push_back(own.parent_path() / "laws");
  return found;
}

}  // namespace

std::filesystem::path own_file() {
#if defined(_WIN32)
  HMODULE module = nullptr;
  GetModuleHandleExW(GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS | GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT,
                     reinterpret_cast<const wchar_t*>(&own_file), &module);
  std::array<wchar_t, 32768> name{};
  GetModuleFileNameW(module, name.data(), static_cast<DWORD>(name.size()));
  return name.data();
#else
  Dl_info info{};
  dladdr(reinterpret_cast<const void*>(&own_file), &info);
  return std::filesystem::absolute(info.dli_fname);
#endif
}

const quoin_law& law_in_file(const std::filesystem::path& file) {
  static std::mutex mutex;
  static std::map<std::filesystem::path, const quoin_law*> opened;
  const std::lock_guard lock(mutex);
  const quoin_law*& law = opened[file];
  if (law == nullptr) law = &open(file);
  return *law;
}

const quoin_law& law_by_name(const std::string& name) {
  std::string tried;
  for (const std::filesystem::path& folder : folders()) {
    const std::filesystem::path file = folder / (name + suffix);
    if (std::filesystem::exists(file)) return law_in_file(file);
    tried += "\n  " + file.string();
  }
  throw std::runtime_error("no law " + name + "; looked for" + tried +
                           "\nset QUOIN_LAW_PATH to the folder of the laws");
}

}  // namespace quoin::adapters
