// Contact laws in the host: C++ ownership around the C ABI of plugin_api.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "quoin.hpp"
#include "scene/scene.h"

namespace quoin {

class LawProcess;

// A loaded library; unloaded with its last owner. Laws and materials keep their library alive.
class LawLibrary {
 public:
  // name_or_path: a path (contains '/') or the name of a law. NAME.so is searched in $QUOIN_LAW_PATH (colon separated),
  // laws/ beside the program, and ../lib*/quoin/laws. Throws Error(law_refused) naming what was tried and the reason:
  // missing file, not a shared library, not all of one, no quoin_library_v1, other ABI version. The library runs from a
  // copy in memory, made again where the file has changed since the last load. What happens to the file later has no
  // effect. With $QUOIN_LAW_IN_PLACE set it runs from its file, as debuggers and profilers need it.
  static std::shared_ptr<const LawLibrary> load(const std::string& name_or_path);
  ~LawLibrary();
  LawLibrary(const LawLibrary&) = delete;
  LawLibrary& operator=(const LawLibrary&) = delete;

  const quoin_library& info() const { return *library_; }
  const std::string& path() const { return path_; }

 private:
  LawLibrary() = default;
  void open(const std::string& bytes, const std::string& failed);
  void* handle_ = nullptr;
  const void* entry_ = nullptr;  // in the library's code
  int copy_ = -1;                // descriptor of the copy; -1: none
  const quoin_library* library_ = nullptr;
  std::string path_;
};

// One law of a library.
struct Law {
  std::shared_ptr<const LawLibrary> library;
  const quoin_law* law = nullptr;

  // The law whose id is requested by a bare name, or the only / first law of a library given by path.
  static Law find(const std::string& name_or_path);
  int state_index(const std::string& id) const;  // -1: the law has no such state
};

// An immutable material: thread-safe, freely shared.
class Material {
 public:
  // Throws Error(law_refused) with the law's own message (every fault) behind the source of the offending key when
  // known.
  Material(Law law, const std::vector<PropertySetting>& settings);
  const Law& law() const { return law_; }
  const quoin_law& api() const { return *law_.law; }
  const quoin_material* handle() const { return material_.handle(); }
  const std::string& warnings() const { return warnings_; }
  // As the law's own function. The call is noted, so that one that never returns can be named (law_calls.h). It is made
  // in a process of its own after isolate_laws(). Thread-safe.
  quoin_status evaluate(quoin_batch* batch) const;
  std::string fault() const;  // how the law's process has ended; empty: it lives, or there is none
  const LawProcess* process() const { return process_.get(); }  // null: none
  double number(const std::string& property_id) const;
  std::vector<double> initial_state(const std::string& id) const;  // throws Error(bad_input): unknown initial state
  const quoin_stiffness_bounds& stiffness_bounds() const { return material_.stiffness(); }

 private:
  Law law_;
  quoin::api::Material material_;
  std::string warnings_;
  std::shared_ptr<LawProcess> process_;
};

// Whether laws are evaluated in processes of their own.
struct LawIsolation {
  int threads = 0;       // that evaluate at once; 0: laws are evaluated in this process
  double seconds = 0.0;  // that a batch has; 0: any time
};
// For the materials that this thread makes from now on; what was said before.
LawIsolation isolate_laws(const LawIsolation& wanted);

// Texts of a law may be null.
inline const char* law_text(const char* text) { return text == nullptr ? "" : text; }

// One more folder where laws are searched by name, before those beside the program: for what is no program itself.
void add_law_folder(const std::string& folder);

// Laws in the search path, by name, for `quoin models`.
std::vector<std::string> installed_laws();

}  // namespace quoin
